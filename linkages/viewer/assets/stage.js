/** The picture of the mechanism, and what is drawn besides it. */
const LAYERS = [
  { key: "names", text: "Names", on: true },
  { key: "paths", text: "Joint paths", on: true },
  { key: "loads", text: "Loads", on: true, colour: "load" },
  { key: "reactions", text: "Reactions", on: false, colour: "spring" },
  { key: "ghost", text: "Ideal mechanism", on: false },
];

class Stage {
  constructor(canvas, glasses) {
    this.canvas = canvas;
    this.camera = new Camera();
    this.words = new Words(CONTENT.shapes);
    this.glasses = CONTENT.mechanism.clearances.map((one) => new Glass(glasses, one));
    this.on = Object.fromEntries(LAYERS.map((layer) => [layer.key, layer.on]));
  }

  /**
   * Show another motion; `sizes` are radial clearances by name, `ghost` what has none, `given`
   * other numbers by their paths.
   */
  show(motion, ghost, sizes, given) {
    this.motion = motion;
    this.parts = partsOf(motion, given);
    this.ghost = ghost;
    this.forces = new Forces(motion, CONTENT.mechanism.loads);
    this.camera.show(this.boxFor(boxOf(motion)));
    const [left, low, right, high] = this.camera.box;
    this.enlarged = ghost ? ghost.enlargement(motion, Math.max(right - left, high - low)) : 1;
    this.moving = motion.joints.filter((name) => this.travels(name));
    for (const glass of this.glasses) glass.show(motion, sizes[glass.contact.name]);
  }

  /** The picture stays as it is unless joints leave it. */
  boxFor(joints) {
    this.joints ??= joints;
    return CONTENT.box.map((side, k) => (k < 2 ? Math.min : Math.max)(side, side + joints[k] - this.joints[k]));
  }

  /** What there is to switch on. */
  get layers() {
    const there = {
      names: this.words.words.length, paths: this.moving.length, loads: this.forces.loads.length,
      reactions: this.forces.pins.length, ghost: this.ghost,
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

  draw(place, held) {
    const { canvas, camera, point } = this, colours = theme();
    const ctx = fitted(canvas);
    if (camera.width !== canvas.clientWidth || camera.height !== canvas.clientHeight) {
      camera.resize(canvas.clientWidth, canvas.clientHeight);
      this.words.sides = null;
    }
    ctx.clearRect(0, 0, camera.width, camera.height);
    const scene = this.scene(place);
    if (this.on.paths) this.drawPaths(ctx, colours);
    if (this.on.ghost && this.ghost) this.drawGhost(ctx, scene, colours);
    drawShapes(ctx, CONTENT.shapes, scene, camera, colours, point);
    if (this.on.reactions) this.forces.drawReactions(ctx, scene, camera, colours.spring, this.longest);
    if (this.on.loads) this.forces.drawLoads(ctx, scene, camera, colours.load, this.longest);
    if (this.on.names) this.drawWords(ctx, scene, colours);
    if (held) this.drawHeld(ctx, held, colours);
    this.drawScales(ctx, colours);
    for (const glass of this.glasses) glass.draw(place, camera, colours);
  }

  drawPaths(ctx, colours) {
    ctx.lineWidth = 1;
    ctx.strokeStyle = colours.guide;
    ctx.globalAlpha = 0.55;
    for (const name of this.moving) {
      const x = this.motion.find("joint_position", name, "x").values;
      const y = this.motion.find("joint_position", name, "y").values;
      ctx.beginPath();
      for (let i = 0; i < x.length; i++) {
        if (Number.isFinite(x[i] + y[i])) ctx.lineTo(...this.camera.place([x[i], y[i]]));
      }
      ctx.stroke();
    }
    ctx.globalAlpha = 1;
  }

  drawGhost(ctx, scene, colours) {
    const pale = Object.fromEntries(Object.keys(colours).map((role) => [role, colours.guide]));
    pale.paper = colours.paper;
    ctx.save();
    ctx.globalAlpha = 0.4;
    const moving = CONTENT.shapes.filter((shape) => shape.kind === "line" && shape.name)
      .map((shape) => ({ ...shape, casing: 0, fill: "", width: Math.min(shape.width, 1.4) || 0.8 }));
    drawShapes(ctx, moving, new GhostScene(scene, this.ghost), this.camera, pale, this.point);
    ctx.restore();
  }

  drawWords(ctx, scene, colours) {
    if (!this.words.sides) {
      const last = this.motion.time.length - 1;
      const some = Array.from({ length: 16 }, (_, k) => this.scene(Math.round((last * k) / 16)));
      this.words.settle(ctx, some, this.camera, this.point);
    }
    this.words.draw(ctx, scene, this.camera, colours, this.point);
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
