/** Shapes of linkages/plots/mechanism/shapes.py on a canvas. */
function drawShapes(ctx, shapes, scene, camera, colours, point) {
  ctx.lineCap = ctx.lineJoin = "round";
  for (const shape of shapes) {
    if (shape.kind === "word") continue;
    const angle = scene.direction(shape.direction);
    if (angle === null) continue;
    const path = shape.kind === "line" ? linePath(shape, scene, angle, camera, point)
      : discPath(shape, scene, angle, camera, point);
    if (path) paint(ctx, path, shape, colours, point);
  }
  ctx.setLineDash([]);
}

function linePath(shape, scene, angle, camera, point) {
  const path = new Path2D();
  for (const stroke of shape.strokes) {
    let first = true;
    for (const anchor of stroke) {
      const at = scene.anchor(anchor, angle, camera, point);
      if (!at) return null;
      if (first) path.moveTo(...at); else path.lineTo(...at);
      first = false;
    }
    if (shape.closed) path.closePath();
  }
  return path;
}

function discPath(shape, scene, angle, camera, point) {
  const at = scene.anchor(shape.centre, angle, camera, point);
  if (!at) return null;
  const path = new Path2D();
  path.arc(at[0], at[1], shape.metres * camera.scale + shape.points * point, 0, 2 * Math.PI);
  return path;
}

function paint(ctx, path, shape, colours, point) {
  if (shape.casing) {
    ctx.setLineDash([]);
    ctx.strokeStyle = colours.paper;
    ctx.lineWidth = (shape.width + 2 * shape.casing) * point;
    ctx.stroke(path);
  }
  if (shape.fill) {
    ctx.globalAlpha = shape.opacity;
    ctx.fillStyle = colours[shape.fill];
    ctx.fill(path);
    ctx.globalAlpha = 1;
  }
  if (shape.width) {
    ctx.setLineDash(shape.dashes.map((length) => length * point));
    ctx.strokeStyle = colours[shape.role];
    ctx.lineWidth = shape.width * point;
    ctx.stroke(path);
  }
}

const HIDDEN = -1;
const CROWDED = 0.2; // of the motion: how long names may meet

/**
 * Names: each keeps the side on which it is least in the way over the whole motion, so that none
 * jumps about. A name of a body that has no room among others is left out until there is some.
 */
class Words {
  constructor(shapes) {
    this.words = shapes.filter((shape) => shape.kind === "word");
    this.lines = shapes.filter((shape) => shape.kind === "line" && shape.width >= 1);
    this.sides = null;
  }

  size(point) { return Math.max(12, Math.round(9 * point)); }

  font(word, point) {
    return `${word.strong ? "600 " : ""}${this.size(point)}px system-ui, sans-serif`;
  }

  /** Choose the sides, from some scenes of the motion. */
  settle(ctx, scenes, camera, point) {
    const busy = scenes.map((scene) => this.covered(scene, camera, point));
    const taken = scenes.map(() => []);
    this.sides = this.words.map((word) => {
      ctx.font = this.font(word, point);
      const size = [ctx.measureText(word.text).width, this.size(point) + 1];
      let best = 0, least = Infinity, crowd = 0;
      for (let side = 0; side < 8; side++) {
        let cost = side === 1 ? 0 : 0.2, met = 0;
        scenes.forEach((scene, k) => {
          const box = this.box(word, scene, camera, point, side, size);
          if (!box) return;
          for (const spot of busy[k]) if (inside(spot, box)) cost += 1;
          for (const other of taken[k]) if (meet(other, box)) met += 1;
        });
        cost += 12 * met;
        if (cost < least) [best, least, crowd] = [side, cost, met];
      }
      if (!word.strong && crowd > CROWDED * scenes.length) return HIDDEN;
      scenes.forEach((scene, k) => {
        const box = this.box(word, scene, camera, point, best, size);
        if (box) taken[k].push(box);
      });
      return best;
    });
  }

  /** Spots along all lines. */
  covered(scene, camera, point) {
    const spots = [];
    for (const shape of this.lines) {
      const angle = scene.direction(shape.direction);
      if (angle === null) continue;
      for (const stroke of shape.strokes) {
        const places = stroke.map((one) => scene.anchor(one, angle, camera, point));
        if (places.some((at) => !at)) continue;
        for (let i = 1; i < places.length; i++) {
          const [a, b] = [places[i - 1], places[i]];
          const steps = Math.min(60, Math.ceil(Math.hypot(b[0] - a[0], b[1] - a[1]) / 6)) || 1;
          for (let k = 0; k <= steps; k++) {
            spots.push([a[0] + ((b[0] - a[0]) * k) / steps, a[1] + ((b[1] - a[1]) * k) / steps]);
          }
        }
      }
    }
    return spots;
  }

  /** [left, top, right, bottom] of a word on a side of what it stands beside. */
  box(word, scene, camera, point, side, [width, height]) {
    const angle = scene.direction(word.direction);
    if (angle === null) return null;
    const places = word.beside.map((one) => scene.anchor(one, angle, camera, point));
    if (!places.length || places.some((at) => !at)) return null;
    const x = places.reduce((sum, at) => sum + at[0], 0) / places.length;
    const y = places.reduce((sum, at) => sum + at[1], 0) / places.length;
    const way = (side * Math.PI) / 4, gap = (word.gap + 2) * point;
    const dx = Math.cos(way) * (gap + width / 2), dy = -Math.sin(way) * (gap + height / 2);
    return [x + dx - width / 2, y + dy - height / 2, x + dx + width / 2, y + dy + height / 2];
  }

  draw(ctx, scene, camera, colours, point) {
    ctx.textAlign = "center";
    ctx.textBaseline = "middle";
    const taken = [];
    this.words.forEach((word, k) => {
      if (this.sides[k] === HIDDEN) return;
      ctx.font = this.font(word, point);
      const size = [ctx.measureText(word.text).width, this.size(point) + 1];
      const box = this.box(word, scene, camera, point, this.sides[k], size);
      if (!box || (!word.strong && taken.some((other) => meet(other, box)))) return;
      taken.push(box);
      const middle = [(box[0] + box[2]) / 2, (box[1] + box[3]) / 2];
      ctx.strokeStyle = colours.paper;
      ctx.lineWidth = 3 * point;
      ctx.globalAlpha = 0.8;
      ctx.strokeText(word.text, ...middle);
      ctx.globalAlpha = 1;
      ctx.fillStyle = colours[word.role];
      ctx.fillText(word.text, ...middle);
    });
  }
}

function inside([x, y], [left, top, right, bottom]) {
  return x > left - 2 && x < right + 2 && y > top - 2 && y < bottom + 2;
}

function meet(a, b) {
  return a[0] < b[2] + 3 && b[0] < a[2] + 3 && a[1] < b[3] + 2 && b[1] < a[3] + 2;
}
