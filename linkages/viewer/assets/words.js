/** Names in the picture. */
const CROWDED = 0.2; // of the motion: how long names may meet
const CELL = 6; // pixels
const FAR = [0, 7, 16]; // pixels farther from what a name belongs to
const ALONG = [0.5, 0.3, 0.7]; // places on a bar
const WEIGHTS = { drawn: 1, path: 0.15, outside: 40, met: 12 }; // of what a name covers

/** How much is drawn in any rectangle of the picture. */
class Crowd {
  constructor(width, height) {
    this.columns = Math.ceil(width / CELL) + 1;
    this.rows = Math.ceil(height / CELL) + 1;
    this.width = width;
    this.height = height;
    this.sums = new Float32Array((this.columns + 1) * (this.rows + 1));
  }

  add([x, y], weight) {
    const column = Math.floor(x / CELL), row = Math.floor(y / CELL);
    if (column < 0 || row < 0 || column >= this.columns || row >= this.rows) return;
    this.sums[(row + 1) * (this.columns + 1) + column + 1] += weight;
  }

  line(a, b, weight) {
    const steps = Math.min(400, Math.ceil(Math.hypot(b[0] - a[0], b[1] - a[1]) / CELL)) || 1;
    for (let k = 0; k <= steps; k++) {
      this.add([a[0] + ((b[0] - a[0]) * k) / steps, a[1] + ((b[1] - a[1]) * k) / steps], weight);
    }
  }

  /** After the last `add`. */
  sum() {
    const wide = this.columns + 1;
    for (let row = 1; row <= this.rows; row++) {
      for (let column = 1; column < wide; column++) {
        const at = row * wide + column;
        this.sums[at] += this.sums[at - 1] + this.sums[at - wide] - this.sums[at - wide - 1];
      }
    }
  }

  in([left, top, right, bottom]) {
    const wide = this.columns + 1;
    const within = (value, most) => Math.min(most, Math.max(0, value));
    const a = within(Math.floor((left - 1) / CELL), this.columns), b = within(Math.ceil((right + 1) / CELL), this.columns);
    const c = within(Math.floor((top - 1) / CELL), this.rows), d = within(Math.ceil((bottom + 1) / CELL), this.rows);
    const found = this.sums[d * wide + b] - this.sums[c * wide + b] - this.sums[d * wide + a] + this.sums[c * wide + a];
    const outside = left < 2 || top < 2 || right > this.width - 2 || bottom > this.height - 2;
    return Math.max(0, found) + (outside ? WEIGHTS.outside : 0);
  }
}

/**
 * Names: each keeps the place beside its body or joint at which it is least in the way over the
 * whole motion, so that none jumps about. A name of a body that has no room among others is left out
 * until there is some.
 */
class Words {
  constructor(shapes) {
    this.words = shapes.filter((shape) => shape.kind === "word");
    this.drawn = shapes.filter((shape) => shape.kind !== "word");
    this.places = null;
  }

  size(point) { return Math.max(12, Math.round(9 * point)); }

  font(word, point) {
    return `${word.strong ? "600 " : ""}${this.size(point)}px system-ui, sans-serif`;
  }

  /** Choose the places from some scenes of the motion; `paths` are polylines in pixels. */
  settle(ctx, scenes, paths, camera, point) {
    const crowds = scenes.map((scene) => this.crowd(scene, paths, camera, point));
    const taken = scenes.map(() => []);
    this.places = this.words.map((word) => {
      ctx.font = this.font(word, point);
      const size = [ctx.measureText(word.text).width, this.size(point) + 1];
      let best = null, least = Infinity, crowd = 0;
      for (const far of FAR) for (const along of word.beside.length === 2 ? ALONG : [0.5]) {
        for (let side = 0; side < 8; side++) {
          const place = { side, far, along };
          let cost = (side === 1 ? 0 : 0.2) + scenes.length * ((word.strong ? 0.15 : 0.04) * far + Math.abs(along - 0.5)), met = 0;
          scenes.forEach((scene, k) => {
            const box = this.box(word, scene, camera, point, place, size);
            if (!box) return;
            cost += crowds[k].in(box);
            for (const other of taken[k]) if (meet(other, box)) met += 1;
          });
          cost += WEIGHTS.met * met;
          if (cost < least) [best, least, crowd] = [place, cost, met];
        }
      }
      if (!word.strong && crowd > CROWDED * scenes.length) return null;
      scenes.forEach((scene, k) => {
        const box = this.box(word, scene, camera, point, best, size);
        if (box) taken[k].push(box);
      });
      return best;
    });
  }

  crowd(scene, paths, camera, point) {
    const found = new Crowd(camera.width, camera.height);
    for (const shape of this.drawn) {
      const angle = scene.direction(shape.direction);
      if (angle === null) continue;
      if (shape.kind === "disc") {
        const at = scene.anchor(shape.centre, angle, camera, point);
        const radius = shape.metres * camera.scale + shape.points * point;
        for (let k = 0; at && k < 8; k++) {
          found.add([at[0] + radius * Math.cos((k * Math.PI) / 4), at[1] + radius * Math.sin((k * Math.PI) / 4)], WEIGHTS.drawn);
        }
        continue;
      }
      for (const stroke of shape.strokes) {
        const places = stroke.map((one) => scene.anchor(one, angle, camera, point));
        if (places.some((at) => !at)) continue;
        for (let i = 1; i < places.length; i++) found.line(places[i - 1], places[i], WEIGHTS.drawn);
        if (shape.closed) found.line(places[places.length - 1], places[0], WEIGHTS.drawn);
      }
    }
    for (const path of paths) for (let i = 1; i < path.length; i++) found.line(path[i - 1], path[i], WEIGHTS.path);
    found.sum();
    return found;
  }

  /** [left, top, right, bottom] of a word at a place beside what it belongs to. */
  box(word, scene, camera, point, { side, far, along }, [width, height]) {
    const angle = scene.direction(word.direction);
    if (angle === null) return null;
    const places = word.beside.map((one) => scene.anchor(one, angle, camera, point));
    if (!places.length || places.some((at) => !at)) return null;
    const shares = places.length === 2 ? [1 - along, along] : places.map(() => 1 / places.length);
    const x = places.reduce((sum, at, k) => sum + shares[k] * at[0], 0);
    const y = places.reduce((sum, at, k) => sum + shares[k] * at[1], 0);
    const way = (side * Math.PI) / 4, gap = (word.gap + 2) * point + far;
    const dx = Math.cos(way) * (gap + width / 2), dy = -Math.sin(way) * (gap + height / 2);
    return [x + dx - width / 2, y + dy - height / 2, x + dx + width / 2, y + dy + height / 2];
  }

  draw(ctx, scene, camera, colours, point) {
    ctx.textAlign = "center";
    ctx.textBaseline = "middle";
    ctx.lineJoin = "round";
    const taken = [];
    this.words.forEach((word, k) => {
      if (!this.places[k]) return;
      ctx.font = this.font(word, point);
      const size = [ctx.measureText(word.text).width, this.size(point) + 1];
      const box = this.box(word, scene, camera, point, this.places[k], size);
      if (!box || (!word.strong && taken.some((other) => meet(other, box)))) return;
      taken.push(box);
      const middle = [(box[0] + box[2]) / 2, (box[1] + box[3]) / 2];
      ctx.strokeStyle = colours.paper;
      ctx.lineWidth = 4 * point;
      ctx.globalAlpha = 0.85;
      ctx.strokeText(word.text, ...middle);
      ctx.globalAlpha = 1;
      ctx.fillStyle = colours[word.role];
      ctx.fillText(word.text, ...middle);
    });
  }
}

function meet(a, b) {
  return a[0] < b[2] + 3 && b[0] < a[2] + 3 && a[1] < b[3] + 2 && b[1] < a[3] + 2;
}
