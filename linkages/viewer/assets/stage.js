/** The picture of the mechanism, and what is drawn besides it. */
const LAYERS = [
  { key: "names", text: "Names", on: true },
  { key: "paths", text: "Joint paths", on: true },
  { key: "before", text: "Original motion", on: true },
  { key: "loads", text: "Loads", on: true, colour: "load" },
  { key: "reactions", text: "Reactions", on: false, colour: "spring" },
  { key: "ghost", text: "Ideal mechanism", on: false },
];

class Stage {
  /** @param {object} content of the page whose mechanism is shown */
  constructor(canvas, glasses, content) {
    this.canvas = canvas;
    this.content = content;
    this.camera = new Camera();
    this.words = new Words(content.shapes);
    this.glasses = content.mechanism.clearances.map((one) => new Glass(glasses, one, content.mechanism.period));
    this.on = Object.fromEntries(LAYERS.map((layer) => [layer.key, layer.on]));
    this.traces = [];
    this.marked = null;
  }

  /**
   * Show another motion; `sizes` are radial clearances by name, `ghost` what has none, `given`
   * other numbers by their paths, `before` {motion, parts} of what they were changed from. The
   * camera stays where it is if `still`.
   */
  show(motion, ghost, sizes, given, { before = null, still = false } = {}) {
    this.motion = motion;
    this.parts = partsOf(motion, given, this.content);
    this.before = before;
    this.ghost = ghost;
    this.forces = new Forces(motion, this.content.mechanism.loads);
    if (!still) this.camera.show(this.boxFor(boxOf(motion)));
    const [left, low, right, high] = this.camera.box;
    this.enlarged = ghost ? ghost.enlargement(motion, Math.max(right - left, high - low)) : 1;
    this.moving = motion.joints.filter((name) => this.travels(name));
    for (const glass of this.glasses) glass.show(motion, sizes[glass.contact.name]);
  }

  /** The picture stays as it is unless joints leave it. */
  boxFor(joints) {
    this.joints ??= joints;
    return this.content.box.map((side, k) => (k < 2 ? Math.min : Math.max)(side, side + joints[k] - this.joints[k]));
  }

  /** What there is to switch on. */
  get layers() {
    const there = {
      names: this.words.words.length, paths: this.moving.length, loads: this.forces.loads.length,
      reactions: this.forces.pins.length, ghost: this.ghost, before: this.before,
    };
    return LAYERS.filter((layer) => there[layer.key]);
  }

  travels(name) {
    const size = Math.max(this.camera.box[2] - this.camera.box[0], this.camera.box[3] - this.camera.box[1]);
    return ["x", "y"].some((axis) => {
      const [low, high] = this.motion.range(this.motion.find("joint_position", name, axis));
      return high - low > 1e-6 * size;
    });
  }

  get point() { return Math.min(1.5, Math.max(1, this.camera.width / 480)); }

  /** Length of the longest arrow in pixels. */
  get longest() { return 0.16 * Math.min(this.camera.width, this.camera.height); }

  scene(place) {
    const plain = new Scene(this.motion, place, this.parts);
    return this.on.ghost && this.ghost && this.enlarged > 1
      ? new EnlargedScene(plain, this.ghost, this.enlarged) : plain;
  }

  /** Trace a point of a body, or no longer. */
  trace(found) {
    const same = ({ weights }) => Object.keys({ ...weights, ...found.weights })
      .every((name) => Math.abs((weights[name] ?? 0) - (found.weights[name] ?? 0)) < 0.03);
    const there = this.traces.filter(same);
    this.traces = there.length ? this.traces.filter((one) => !same(one)) : [...this.traces, found].slice(-6);
  }

  fit() {
    const { canvas, camera } = this;
    if (camera.width === canvas.clientWidth && camera.height === canvas.clientHeight) return;
    camera.resize(canvas.clientWidth, canvas.clientHeight);
    this.words.places = null;
  }

  draw(time, held) {
    this.fit();
    const ctx = fitted(this.canvas);
    ctx.clearRect(0, 0, this.camera.width, this.camera.height);
    this.drawOn(ctx, time, held);
    for (const glass of this.glasses) glass.draw(this.motion.where(time), this.camera, theme());
  }

  /** All but the magnifying glasses, on any context of that size. */
  drawOn(ctx, time, held = null) {
    const { camera, point } = this, colours = theme(), scene = this.scene(this.motion.where(time));
    if (this.on.paths) this.drawPaths(ctx, this.motion, this.before ? colours.bar : colours.guide, 0.55);
    if (this.on.before && this.before) this.drawBefore(ctx, time, colours);
    if (this.on.ghost && this.ghost) this.drawPale(ctx, new GhostScene(scene, this.ghost), colours);
    this.drawTraces(ctx, scene, colours);
    drawShapes(ctx, this.content.shapes, scene, camera, colours, point);
    if (this.on.reactions) this.forces.drawReactions(ctx, scene, camera, colours.spring, this.longest);
    if (this.on.loads) this.forces.drawLoads(ctx, scene, camera, colours.load, this.longest);
    if (this.on.names) this.drawWords(ctx, scene, colours);
    if (this.marked) this.drawMarked(ctx, scene, colours);
    if (held) this.drawHeld(ctx, held, colours);
    this.drawScales(ctx, colours);
  }

  drawPaths(ctx, motion, colour, alpha) {
    ctx.lineWidth = 1;
    ctx.strokeStyle = colour;
    ctx.globalAlpha = alpha;
    for (const name of this.moving) this.drawPath(ctx, motion, { [name]: 1 });
    ctx.globalAlpha = 1;
  }

  /** The way of a weighted mean of joints, with gaps where it is not known. */
  drawPath(ctx, motion, weights) {
    const terms = termsOf(motion, weights), { width, height, scale, middle } = this.camera;
    if (!terms) return;
    let drawn = false, lastX = NaN, lastY = NaN;
    ctx.beginPath();
    for (let i = 0; i < motion.time.length; i++) {
      let x = 0, y = 0;
      for (const [weight, xs, ys] of terms) { x += weight * xs[i]; y += weight * ys[i]; }
      if (!Number.isFinite(x + y)) { drawn = false; continue; }
      x = width / 2 + (x - middle[0]) * scale;
      y = height / 2 - (y - middle[1]) * scale;
      if (drawn && Math.abs(x - lastX) + Math.abs(y - lastY) < 0.5) continue; // within a pixel
      if (drawn) ctx.lineTo(x, y); else ctx.moveTo(x, y);
      [drawn, lastX, lastY] = [true, x, y];
    }
    ctx.stroke();
  }

  /** Some hundred of its places in pixels. */
  path(motion, weights) {
    const terms = termsOf(motion, weights), step = Math.max(1, Math.floor(motion.time.length / 100)), found = [];
    for (let i = 0; terms && i < motion.time.length; i += step) {
      let x = 0, y = 0;
      for (const [weight, xs, ys] of terms) { x += weight * xs[i]; y += weight * ys[i]; }
      if (Number.isFinite(x + y)) found.push(this.camera.place([x, y]));
    }
    return found;
  }

  drawTraces(ctx, scene, colours) {
    this.traces.forEach(({ weights }, k) => {
      const at = scene.mean(weights);
      ctx.lineWidth = 2;
      if (this.before && this.on.before) {
        ctx.strokeStyle = lineColour(k);
        ctx.setLineDash([4, 4]);
        ctx.globalAlpha = 0.7;
        this.drawPath(ctx, this.before.motion, weights);
        ctx.setLineDash([]);
        ctx.globalAlpha = 1;
      }
      ctx.strokeStyle = ctx.fillStyle = lineColour(k);
      this.drawPath(ctx, this.motion, weights);
      if (at) drawDot(ctx, this.camera.place(at), 4.5, lineColour(k), colours.paper);
    });
  }

  /** The motion as it was before numbers were changed, at the same time. */
  drawBefore(ctx, time, colours) {
    const { motion, parts } = this.before;
    ctx.setLineDash([3, 3]);
    if (this.on.paths) this.drawPaths(ctx, motion, colours.guide, 0.8);
    ctx.setLineDash([]);
    this.drawPale(ctx, new Scene(motion, motion.where(time), parts), colours);
  }

  /** A mechanism behind the other one. */
  drawPale(ctx, scene, colours) {
    const pale = Object.fromEntries(Object.keys(colours).map((role) => [role, colours.guide]));
    pale.paper = colours.paper;
    ctx.save();
    ctx.globalAlpha = 0.4;
    const moving = this.content.shapes.filter((shape) => shape.kind === "line" && shape.name)
      .map((shape) => ({ ...shape, casing: 0, fill: "", width: Math.min(shape.width, 1.4) || 0.8 }));
    drawShapes(ctx, moving, scene, this.camera, pale, this.point);
    ctx.restore();
  }

  drawWords(ctx, scene, colours) {
    if (!this.words.places) {
      const last = this.motion.time.length - 1;
      const some = Array.from({ length: 16 }, (_, k) => this.scene(Math.round((last * k) / 16)));
      const paths = this.on.paths ? this.moving.map((name) => this.path(this.motion, { [name]: 1 })) : [];
      this.words.settle(ctx, some, paths, this.camera, this.point);
    }
    this.words.draw(ctx, scene, this.camera, colours, this.point);
  }

  /** Joints that can be edited, and those that cannot. */
  drawMarked(ctx, scene, colours) {
    for (const [name, free] of Object.entries(this.marked)) {
      const at = scene.joint(name);
      if (!at) continue;
      ctx.strokeStyle = free ? colours.driven : colours.guide;
      ctx.lineWidth = free ? 2 : 1;
      ctx.setLineDash(free ? [] : [2, 3]);
      ctx.beginPath();
      ctx.arc(...this.camera.place(at), 8, 0, 2 * Math.PI);
      ctx.stroke();
    }
    ctx.setLineDash([]);
  }

  drawHeld(ctx, [x, y], colours) {
    ctx.strokeStyle = colours.driven;
    ctx.lineWidth = 2;
    ctx.beginPath();
    ctx.arc(...this.camera.place([x, y]), 9, 0, 2 * Math.PI);
    ctx.stroke();
  }

  /** What arrows and enlargements stand for, at the lower right. */
  drawScales(ctx, colours) {
    const { width, height } = this.camera, rows = [];
    if (this.on.reactions && this.forces.reaction) {
      rows.push({ full: this.forces.reaction, colour: colours.spring, unit: "N" });
    }
    if (this.on.loads && this.forces.force) {
      rows.push({ full: this.forces.force, colour: colours.load, unit: "N" });
    }
    ctx.font = "12px system-ui, sans-serif";
    ctx.textBaseline = "middle";
    ctx.textAlign = "right";
    let y = height - 16;
    const metre = niceBelow((0.22 * Math.min(width, 640)) / this.camera.scale);
    this.drawRuler(ctx, width - 16, y, metre * this.camera.scale, quantity(metre, "m", 2), colours);
    for (const { full, colour, unit } of rows) {
      y -= 20;
      const value = niceBelow(full), length = (this.longest * value) / full;
      drawArrow(ctx, [width - 16 - length, y], [length, 0], colour);
      ctx.fillStyle = colour;
      ctx.fillText(quantity(value, unit, 2), width - 24 - length, y);
    }
    if (this.on.ghost && this.ghost) {
      ctx.fillStyle = colours.ink;
      ctx.fillText(`deviation from the ideal mechanism ${figures(this.enlarged)}×`, width - 16, y - 20);
    }
  }

  drawRuler(ctx, right, y, length, text, colours) {
    ctx.strokeStyle = ctx.fillStyle = colours.guide;
    ctx.lineWidth = 1.2;
    ctx.beginPath();
    for (const [a, b] of [[-4, 4]]) {
      ctx.moveTo(right, y + a); ctx.lineTo(right, y + b);
      ctx.moveTo(right - length, y + a); ctx.lineTo(right - length, y + b);
    }
    ctx.moveTo(right, y);
    ctx.lineTo(right - length, y);
    ctx.stroke();
    ctx.fillText(text, right - length - 8, y);
  }
}

/** [weight, all x, all y] of joints; null if a motion lacks one. */
function termsOf(motion, weights) {
  const found = Object.entries(weights).map(([name, weight]) => [weight,
    motion.find("joint_position", name, "x")?.values, motion.find("joint_position", name, "y")?.values]);
  return found.every(([, x, y]) => x && y) ? found : null;
}

function drawDot(ctx, [x, y], radius, colour, edge) {
  ctx.beginPath();
  ctx.arc(x, y, radius, 0, 2 * Math.PI);
  ctx.fillStyle = colour;
  ctx.fill();
  ctx.strokeStyle = edge;
  ctx.lineWidth = 1.5;
  ctx.stroke();
}
