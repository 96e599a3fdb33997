/** Forces as arrows, all of one kind to one scale. */
const EXCEPTION = 1.3; // times what three quarters stay below: larger ones have the longest arrow

/** What the longest arrow stands for: the largest, if it is no rare exception. */
function fullLength(sizes) {
  const known = sizes.filter(Number.isFinite).sort((a, b) => a - b);
  if (!known.length) return 0;
  const most = known[known.length - 1];
  return Math.min(most, EXCEPTION * known[Math.floor(0.75 * (known.length - 1))]) || most;
}

/** The largest of 1, 2 or 5 times a power of ten that is not above a value. */
function niceBelow(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [5, 2, 1].find((step) => step * power <= value * (1 + 1e-9)) * power;
}

/** An arrow in pixels that ends, or begins, at a place. */
function drawArrow(ctx, [x, y], [dx, dy], colour, { ends = false, width = 2.2 } = {}) {
  const length = Math.hypot(dx, dy);
  if (!(length > 1.5)) return;
  const [ux, uy] = [dx / length, dy / length];
  const head = Math.min(11, 0.6 * length);
  const [bx, by] = ends ? [x - dx, y - dy] : [x, y];
  const [tx, ty] = [bx + dx, by + dy], [nx, ny] = [tx - head * ux, ty - head * uy];
  ctx.strokeStyle = ctx.fillStyle = colour;
  ctx.lineWidth = Math.min(width, 0.4 * head);
  ctx.lineCap = "butt";
  ctx.beginPath();
  ctx.moveTo(bx, by);
  ctx.lineTo(nx, ny);
  ctx.stroke();
  drawHead(ctx, [tx, ty], [ux, uy], head, colour);
}

/** The head of an arrow that ends at a place, in a direction of length 1. */
function drawHead(ctx, [x, y], [ux, uy], length, colour) {
  const half = 0.42 * length, nx = x - length * ux, ny = y - length * uy;
  ctx.fillStyle = colour;
  ctx.beginPath();
  ctx.moveTo(x, y);
  ctx.lineTo(nx - half * uy, ny + half * ux);
  ctx.lineTo(nx + half * uy, ny - half * ux);
  ctx.fill();
}

/** A torque as an arc about a place, as long as a part of a turn. */
function drawTorque(ctx, [x, y], part, radius, colour) {
  if (!(Math.abs(part) > 0.02)) return;
  const sweep = -part * 1.5 * Math.PI, from = -Math.PI / 2 - sweep / 2, to = from + sweep;
  ctx.strokeStyle = colour;
  ctx.lineWidth = 2.2;
  ctx.beginPath();
  ctx.arc(x, y, radius, from, to, sweep < 0);
  ctx.stroke();
  const way = to + (Math.sign(sweep) * Math.PI) / 2;
  const tip = [x + radius * Math.cos(to), y + radius * Math.sin(to)];
  drawHead(ctx, [tip[0] + 7 * Math.cos(way), tip[1] + 7 * Math.sin(way)], [Math.cos(way), Math.sin(way)], 11, colour);
}

/** The loads and reactions of a motion, each with the scale of its kind. */
class Forces {
  constructor(motion, loads) {
    this.motion = motion;
    const known = loads.map((load) => ({ ...load, values: motion.byName.get(load.series) }));
    this.loads = known.filter((load) => load.values);
    const sizes = (chosen) => fullLength(chosen.flatMap((load) => this.sampled(load.values)));
    this.force = sizes(this.loads.filter((load) => load.kind !== "about"));
    this.torque = sizes(this.loads.filter((load) => load.kind === "about"));
    const found = (variable, name, joint) => ({
      joint,
      x: motion.find(variable, name, "x"),
      y: motion.find(variable, name, "y"),
    });
    // on each body where several share a pin, else on the one beside the first
    const shared = motion.series
      .filter((one) => one.variable === "pin_reaction" && one.place[1] === "x")
      .map(({ place: [name] }) => found("pin_reaction", name, name.slice(0, name.lastIndexOf("."))));
    const pins = new Set(shared.map((pin) => pin.joint));
    this.pins = [...shared, ...motion.joints.filter((joint) => !pins.has(joint))
      .map((joint) => found("joint_reaction", joint, joint))].filter((pin) => pin.x && pin.y && (largest(pin.x.values) || largest(pin.y.values)));
    this.reaction = fullLength(this.pins.flatMap((pin) => {
      const y = this.sampled(pin.y);
      return this.sampled(pin.x).map((x, k) => Math.hypot(x, y[k]));
    }));
  }

  /** Magnitudes at some hundred frames. */
  sampled(series) {
    const step = Math.max(1, Math.floor(series.values.length / 300));
    return Array.from({ length: Math.ceil(series.values.length / step) }, (_, k) => Math.abs(series.values[k * step]));
  }

  drawLoads(ctx, scene, camera, colour, longest) {
    for (const load of this.loads) {
      const value = this.motion.at(load.values, scene.place);
      if (!Number.isFinite(value)) continue;
      if (load.kind === "about") {
        const at = scene.joint(load.joint);
        if (at && this.torque) {
          drawTorque(ctx, camera.place(at), clip(value / this.torque), 0.3 * longest + 8, colour);
        }
        continue;
      }
      const length = this.force ? longest * clip(value / this.force) : 0;
      for (const [at, angle] of spots(load, scene)) {
        if (!at || angle === null) continue;
        const way = [length * Math.cos(angle), -length * Math.sin(angle)];
        drawArrow(ctx, camera.place(at), way, colour, { ends: load.kind !== "between" });
      }
    }
  }

  drawReactions(ctx, scene, camera, colour, longest) {
    for (const pin of this.pins) {
      const x = this.motion.at(pin.x, scene.place), y = this.motion.at(pin.y, scene.place);
      const size = Math.hypot(x, y), at = scene.joint(pin.joint);
      if (!at || !Number.isFinite(size) || !this.reaction || !size) continue;
      const length = (longest * Math.min(1, size / this.reaction)) / size;
      drawArrow(ctx, camera.place(at), [x * length, -y * length], colour);
    }
  }
}

function clip(value) { return Math.min(1, Math.max(-1, value)); }

/** Where a load acts and in which direction it is positive. */
function spots(load, scene) {
  switch (load.kind) {
    case "between": {
      const [a, b] = load.joints.map((joint) => scene.joint(joint));
      if (!a || !b) return [];
      const angle = Math.atan2(b[1] - a[1], b[0] - a[0]);
      return [[a, angle + Math.PI], [b, angle]];
    }
    case "fixed": return [[scene.joint(load.joint), (load.axis * Math.PI) / 2]];
    case "turning": {
      const turned = scene.angle(load.body);
      return [[scene.joint(load.joint), turned === null ? null : turned + (load.axis * Math.PI) / 2]];
    }
    case "along": return [[scene.joint(load.joint), scene.angle(load.body)]];
    default: throw new Error(`unknown kind of load: ${load.kind}`);
  }
}
