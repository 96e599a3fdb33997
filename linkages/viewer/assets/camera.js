/** From metres to pixels of a canvas, y up. */
class Camera {
  constructor() {
    this.box = [0, 0, 1, 1];
    this.zoom = 1;
    this.centre = null;
    this.resize(1, 1);
  }

  /** Show a box of the plane, [left, low, right, high] in metres. */
  show(box) { this.box = box; this.update(); }

  resize(width, height) { this.width = width; this.height = height; this.update(); }

  update() {
    const [left, low, right, high] = this.box;
    const size = Math.max(right - left, high - low) || 1;
    const margin = Math.min(44, 0.1 * Math.min(this.width, this.height));
    const fits = Math.min((this.width - 2 * margin) / Math.max(right - left, 1e-3 * size),
      (this.height - 2 * margin) / Math.max(high - low, 1e-3 * size));
    this.scale = Math.max(fits, 1e-12) * this.zoom;
    this.middle = this.centre ?? [(left + right) / 2, (low + high) / 2];
  }

  place([x, y]) {
    return [this.width / 2 + (x - this.middle[0]) * this.scale,
      this.height / 2 - (y - this.middle[1]) * this.scale];
  }

  world([x, y]) {
    return [this.middle[0] + (x - this.width / 2) / this.scale,
      this.middle[1] - (y - this.height / 2) / this.scale];
  }

  /** Enlarge by a factor about a place in pixels. */
  enlarge(factor, at = [this.width / 2, this.height / 2]) {
    const fixed = this.world(at);
    this.zoom = Math.min(Math.max(this.zoom * factor, 0.25), 400);
    this.centre = this.middle;
    this.update();
    const moved = this.world(at);
    this.pan([fixed[0] - moved[0], fixed[1] - moved[1]]);
  }

  pan([x, y]) {
    this.centre = [this.middle[0] + x, this.middle[1] + y];
    this.update();
  }

  whole() { this.zoom = 1; this.centre = null; this.update(); }
}

/** The box that all joints need at all frames. */
function boxOf(motion) {
  const box = [Infinity, Infinity, -Infinity, -Infinity];
  for (const series of motion.series) {
    if (series.variable !== "joint_position") continue;
    const k = series.place[1] === "x" ? 0 : 1;
    const [low, high] = motion.range(series);
    box[k] = Math.min(box[k], low);
    box[k + 2] = Math.max(box[k + 2], high);
  }
  return box.every(Number.isFinite) ? box : [0, 0, 1, 1];
}
