/** One diagram: series over time, or over another series, with a cursor and points of a section. */
const MARGIN = { left: 54, right: 14, top: 18, bottom: 20 };
const PER_SWING = 5; // frames, with which what is between them can be told

class Plot {
  constructor(host) {
    this.back = host.appendChild(document.createElement("canvas"));
    this.front = host.appendChild(document.createElement("canvas"));
    this.front.className = "cursor";
    this.front.setAttribute("role", "img");
  }

  /**
   * What to draw: `x` is a series, or null for time; `lines` are series; `others` {motion, across,
   * lines} are drawn pale.
   */
  show(motion, x, lines, title, others = []) {
    this.motion = motion;
    this.across = x;
    this.lines = lines;
    this.others = others;
    this.title = title;
    this.front.setAttribute("aria-label", title);
    this.drawn = "";
  }

  get peak() { return Math.max(0, ...this.ranges.flat().map(Math.abs)); }

  /** Least and largest of all that is drawn. */
  get ranges() {
    return [...this.lines.map((one) => this.motion.range(one)),
      ...this.others.flatMap(({ motion, lines }) => lines.filter(Boolean).map((one) => motion.range(one)))];
  }

  /** What is to be said of how it is drawn. */
  get note() {
    if (this.sectioned) return "points: once per period";
    if (!this.across) return this.lines.some((one) => one.bounds) ? "bands: least to largest" : "";
    if (!this.lines.some((one) => this.coarse(one))) return "";
    return this.closely ? `last ${quantity(this.motion.detail.duration, "s", 2)} of the motion` : "dots: frames only";
  }

  /** Points once per period: [x, y] in shown values, of each line; null where there are none. */
  get points() {
    const { section } = this.motion, x = this.across && section?.byName.get(this.across.name);
    const lines = x ? this.lines.map((one) => section.byName.get(one.name)) : [];
    return x && lines.every(Boolean) && lines.length ? { section, x, lines } : null;
  }

  /** Samples of some swings, where frames do not show these; null where there are none. */
  get closely() {
    const { detail } = this.motion, x = this.across && detail?.byName.get(this.across.name);
    const lines = x ? this.lines.map((one) => detail.byName.get(one.name)) : [];
    return x && lines.every(Boolean) && lines.length ? { motion: detail, across: x, lines } : null;
  }

  draw(place, time) {
    const key = `${this.back.clientWidth}x${this.back.clientHeight} ${document.documentElement.dataset.theme} ${this.sectioned}`;
    if (this.back.clientWidth < 20) return;
    if (this.drawn !== key) this.drawStill();
    this.drawn = key;
    this.drawCursor(place, time);
  }

  layout(width, height) {
    const unit = this.lines[0]?.unit ?? "";
    this.yScale = scaleFor(this.peak, unit);
    const [low, high] = ends(this.ranges).map((value) => value * this.yScale.factor);
    this.y = new Axis(low, high, height - MARGIN.bottom, MARGIN.top, false);
    const sides = [MARGIN.left, width - MARGIN.right];
    if (this.across) {
      const range = ends([this.motion.range(this.across), ...this.others.map(({ motion, across }) => motion.range(across))]);
      this.xScale = scaleFor(Math.max(...range.map(Math.abs)), this.across.unit);
      this.wraps = this.across.angle && range[1] - range[0] > 2 * Math.PI * 1.001;
      this.x = new Axis(...(this.wraps ? [0, 360] : range.map((value) => value * this.xScale.factor)), ...sides, this.wraps);
    } else {
      const times = [this.motion.start, this.motion.last ?? this.motion.end].sort((a, b) => a - b);
      this.xScale = scaleFor(Math.max(...times.map(Math.abs)), "s");
      this.wraps = false;
      this.x = new Axis(...times.map((value) => value * this.xScale.factor), ...sides, true);
    }
  }

  /** Shown value to the right, of a frame or between two. */
  xAt(value) {
    const shown = value * this.xScale.factor;
    return this.wraps ? ((shown % 360) + 360) % 360 : shown;
  }

  drawStill() {
    const ctx = fitted(this.back), { clientWidth: width, clientHeight: height } = this.back;
    ctx.clearRect(0, 0, width, height);
    this.drawOn(ctx, width, height);
  }

  /** All but the cursor, on any context. */
  drawOn(ctx, width, height) {
    this.layout(width, height);
    this.drawAxes(ctx, theme(), width, height);
    ctx.save();
    ctx.beginPath();
    ctx.rect(MARGIN.left, 0, width - MARGIN.left - MARGIN.right, height - MARGIN.bottom + 1);
    ctx.clip();
    this.drawCurves(ctx);
    ctx.restore();
  }

  drawCurves(ctx) {
    if (this.sectioned) return;
    ctx.setLineDash([4, 4]);
    for (const other of this.others) {
      other.lines.forEach((series, k) => {
        const band = series?.bounds && !other.across;
        ctx.globalAlpha = band ? 0.25 : 0.5;
        if (band) this.drawBand(ctx, series, lineColour(k), other);
        else if (series) this.drawLine(ctx, series, lineColour(k), other);
      });
    }
    ctx.setLineDash([]);
    ctx.globalAlpha = 1;
    const { closely } = this;
    this.lines.forEach((series, k) => {
      const colour = lineColour(k);
      if (this.across && this.coarse(series)) {
        if (closely) this.drawLine(ctx, closely.lines[k], colour, closely); else this.drawDots(ctx, series, colour);
      } else if (series.bounds && !this.across) this.drawBand(ctx, series, colour);
      else this.drawLine(ctx, series, colour);
    });
  }

  drawAxes(ctx, colours, width, height) {
    ctx.font = "12px system-ui, sans-serif";
    ctx.lineWidth = 1;
    const bottom = height - MARGIN.bottom;
    ctx.textBaseline = "middle";
    ctx.textAlign = "right";
    for (const [at, text] of this.y.ticks(36, this.yScale.text === "°")) {
      const y = Math.round(this.y.pixel(at)) + 0.5;
      ctx.strokeStyle = colours.line;
      ctx.beginPath();
      ctx.moveTo(MARGIN.left, y);
      ctx.lineTo(width - MARGIN.right, y);
      ctx.stroke();
      ctx.fillStyle = colours.soft;
      ctx.fillText(text, MARGIN.left - 7, y);
    }
    ctx.textBaseline = "top";
    ctx.textAlign = "center";
    for (const [at, text] of this.x.ticks(70, this.across && this.xScale.text === "°")) {
      const x = Math.round(this.x.pixel(at)) + 0.5;
      ctx.strokeStyle = colours.line;
      ctx.beginPath();
      ctx.moveTo(x, bottom);
      ctx.lineTo(x, MARGIN.top);
      ctx.stroke();
      ctx.fillStyle = colours.soft;
      ctx.fillText(text, Math.min(x, width - 14), bottom + 5);
    }
    ctx.fillStyle = colours.soft;
    ctx.textBaseline = "top";
    ctx.textAlign = "left";
    if (this.yScale.text) ctx.fillText(this.yScale.text, 6, 1);
    ctx.textAlign = "right";
    ctx.fillText(`${this.across ? this.across.words : "t"} in ${this.xScale.text || "1"}`, width - MARGIN.right, 1);
  }

  /** Whether frames are too few to tell what a series does between them. */
  coarse(series) {
    return Boolean(this.motion.detail?.byName.has(series.name)) || series.values.length * 2 < PER_SWING * turningPoints(series.values);
  }

  drawLine(ctx, series, colour, { motion, across } = this) {
    const factor = this.yScale.factor, count = series.values.length;
    const parts = Math.min(8, Math.max(1, Math.ceil((4 * (across ? 1000 : 250)) / count)));
    ctx.strokeStyle = colour;
    ctx.lineWidth = count > 1000 && across ? 1 : 1.6;
    ctx.lineJoin = "round";
    ctx.beginPath();
    let before = NaN;
    for (let k = 0; k <= (count - 1) * parts; k++) {
      const place = k / parts, y = motion.at(series, place) * factor;
      const x = this.xAt(across ? motion.at(across, place) : timeAt({ motion, place }));
      if (!Number.isFinite(y)) { before = NaN; continue; }
      const at = [this.x.pixel(x), this.y.pixel(y)];
      const broken = !Number.isFinite(before) || (this.wraps && Math.abs(x - before) > 180);
      if (broken) ctx.moveTo(...at); else ctx.lineTo(...at);
      before = x;
    }
    ctx.stroke();
  }

  /** Least and largest of stretches of frames: what frames alone do not show. */
  drawBand(ctx, series, colour, { motion: { time } } = this) {
    const factor = this.yScale.factor;
    const { stretch, sides: [low, high] } = series.bounds;
    const at = (k) => this.x.pixel(this.xAt(time[Math.min(k * stretch, time.length - 1)]));
    ctx.fillStyle = colour;
    for (let k = 0; k < low.length; k++) {
      const left = at(k), right = at(k + 2);
      const top = this.y.pixel(high[k] * factor), bottom = this.y.pixel(low[k] * factor);
      ctx.fillRect(Math.min(left, right), top, Math.max(0.8, Math.abs(right - left)),
        Math.max(1, bottom - top));
    }
  }

  /** Frames that do not show a series are no curve over another one. */
  drawDots(ctx, series, colour) {
    ctx.fillStyle = colour;
    ctx.globalAlpha = 0.6;
    for (let i = 0; i < series.values.length; i++) {
      ctx.fillRect(this.x.pixel(this.xAt(this.across.values[i])) - 0.7,
        this.y.pixel(series.values[i] * this.yScale.factor) - 0.7, 1.4, 1.4);
    }
    ctx.globalAlpha = 1;
  }

  /** Where the motion was at the end of each period so far. */
  drawPoints(ctx, time, colours) {
    const { points } = this;
    if (!points) return;
    const { section, x, lines } = points, last = Math.floor(section.where(time) + 1e-9);
    lines.forEach((series, k) => {
      for (let i = 0; i < section.time.length; i++) {
        if (i > last && !this.sectioned) break;
        const at = [this.x.pixel(this.xAt(x.values[i])), this.y.pixel(series.values[i] * this.yScale.factor)];
        ctx.globalAlpha = i > last ? 0.15 : 1;
        drawDot(ctx, at, i === last ? 4.5 : 2.6, i === last ? colours.ink : lineColour(k), colours.paper);
      }
    });
    ctx.globalAlpha = 1;
  }

  drawCursor(place, time) {
    const ctx = fitted(this.front), colours = theme();
    const { clientWidth: width, clientHeight: height } = this.front;
    ctx.clearRect(0, 0, width, height);
    this.drawPoints(ctx, time, colours);
    const value = this.across ? this.motion.at(this.across, place) : time;
    const x = this.x.pixel(this.xAt(value));
    if (!Number.isFinite(x)) return;
    ctx.strokeStyle = colours.ink;
    ctx.globalAlpha = 0.45;
    ctx.beginPath();
    ctx.moveTo(x, MARGIN.top);
    ctx.lineTo(x, height - MARGIN.bottom);
    ctx.stroke();
    ctx.globalAlpha = 1;
    this.lines.forEach((series, k) => {
      const y = this.y.pixel(this.motion.at(series, place) * this.yScale.factor);
      if (!Number.isFinite(y)) return;
      drawDot(ctx, [x, y], 3.6, lineColour(k), colours.paper);
    });
  }

  /** The place of the motion nearest to a spot in pixels. */
  placeAt([x, y]) {
    if (!this.across) return this.motion.where(this.x.value(x) / this.xScale.factor);
    let best = 0, least = Infinity;
    for (let i = 0; i < this.motion.time.length; i++) {
      const dx = this.x.pixel(this.xAt(this.across.values[i])) - x;
      for (const series of this.lines) {
        const dy = this.y.pixel(series.values[i] * this.yScale.factor) - y;
        const square = dx * dx + dy * dy;
        if (square < least) [best, least] = [i, square];
      }
    }
    return best;
  }
}

/** Least and largest of ranges. */
function ends(ranges) {
  return [Math.min(...ranges.map(([low]) => low)), Math.max(...ranges.map(([, high]) => high))];
}
