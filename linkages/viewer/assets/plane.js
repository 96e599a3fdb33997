/** An isoperiodic plane with its loci: a point that is chosen plays its motion. */
const STEPS = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const ROOM = { left: 62, right: 22, top: 12, bottom: 42 };
const LOCUS = "#E6007E", HALO = "#FFFFFF";
const LOCUS_LINES = [["solid", []], ["dashed", [6, 3]], ["dotted", [2, 2]]];

class Plane {
  /** `known` is CONTENT.plane, and `numbers` are those of the page. */
  constructor(host, page, known, numbers) {
    this.page = page;
    for (const axis of [known.x, known.y]) axis.unit = unitText(axis.unit);
    this.known = known;
    this.columns = known.x.values.length;
    this.rows = known.y.values.length;
    this.classes = arrayAt(numbers, known.classes);
    this.counts = arrayAt(numbers, known.counts);
    this.spans = exactAt(numbers, known.spans);
    this.states = exactAt(numbers, known.states);
    this.multipliers = arrayAt(numbers, known.multipliers);
    this.loci = known.loci.map(([label, x, y]) => [label, arrayAt(numbers, x), arrayAt(numbers, y)]);
    this.looks = new Map(known.looks.map(([code, colour, words]) => [code, { colour, words }]));
    this.canvas = element("canvas", { tabindex: "0", role: "img", "aria-describedby": "plane-facts",
      "aria-label": `Periods over ${this.title(known.x)} and ${this.title(known.y)}. Click a point, or move with arrow keys, to play its motion.` });
    this.facts = element("div", { id: "plane-facts", role: "status" });
    this.note = element("p", { hidden: "" }, "The picture has other numbers than this point.");
    this.played = null; // all numbers of the point that was chosen; null for those of the page
    host.append(element("div", { class: "map" }, this.canvas), this.legend(), this.facts, this.note);
    this.image = this.painted();
    [this.row, this.column] = known.first;
    this.tell(true);
    this.follow();
  }

  get cell() { return this.row * this.columns + this.column; }

  title({ label, unit }) { return unit ? `${label} in ${unit}` : label; }

  legend() {
    const there = new Set(this.classes), list = element("div", { class: "legend" });
    for (const [code, { colour, words }] of this.looks) {
      if (!there.has(code)) continue;
      const mark = element("i", { class: "patch" });
      mark.style.background = colour;
      list.append(element("span", {}, mark, words));
    }
    for (const [k, [label]] of this.loci.entries()) {
      const mark = element("i", { class: "locus" });
      mark.style.borderTopStyle = LOCUS_LINES[k % LOCUS_LINES.length][0];
      list.append(element("span", {}, mark, label));
    }
    return list;
  }

  /** A pixel for each point, upwards and to the right. */
  painted() {
    const image = document.createElement("canvas"), ctx = image.getContext("2d");
    [image.width, image.height] = [this.columns, this.rows];
    const { x, y } = this.known, right = rises(x.values), up = rises(y.values);
    this.classes.forEach((code, k) => {
      const column = k % this.columns, row = Math.floor(k / this.columns);
      ctx.fillStyle = this.looks.get(code).colour;
      ctx.fillRect(right ? column : this.columns - 1 - column, up ? this.rows - 1 - row : row, 1, 1);
    });
    return image;
  }

  layout(width, height) {
    const edges = ({ values }) => {
      const half = Math.abs(values[values.length - 1] - values[0]) / (values.length - 1) / 2;
      return [Math.min(...values) - half, Math.max(...values) + half];
    };
    this.x = new Axis(...edges(this.known.x), ROOM.left, width - ROOM.right, true);
    this.y = new Axis(...edges(this.known.y), height - ROOM.bottom, ROOM.top, true);
  }

  draw() {
    const { clientWidth: width, clientHeight: height } = this.canvas, { live } = this.page;
    if (width < 20) return;
    this.note.hidden = !live?.numbers.values.some((value, k) => value !== (this.played?.[k] ?? live.model.numbers[k].value));
    const ctx = fitted(this.canvas), { soft, ink, paper } = theme();
    this.layout(width, height);
    ctx.clearRect(0, 0, width, height);
    const size = [this.x.to - this.x.from, this.y.from - this.y.to];
    ctx.imageSmoothingEnabled = false;
    ctx.drawImage(this.image, this.x.from, this.y.to, ...size);
    ctx.save();
    ctx.beginPath();
    ctx.rect(this.x.from, this.y.to, ...size);
    ctx.clip();
    this.drawLoci(ctx);
    ctx.restore();
    ctx.fillStyle = ctx.strokeStyle = soft;
    ctx.font = "12px system-ui, sans-serif";
    ctx.lineWidth = 1;
    ctx.strokeRect(this.x.from, this.y.to, ...size);
    ctx.textAlign = "center";
    for (const [at, text] of this.x.ticks(80)) ctx.fillText(text, this.x.pixel(at), this.y.from + 16);
    ctx.fillText(this.axisText(this.known.x), (this.x.from + this.x.to) / 2, height - 8);
    ctx.textAlign = "right";
    for (const [at, text] of this.y.ticks(50)) ctx.fillText(text, this.x.from - 6, this.y.pixel(at) + 4);
    ctx.save();
    ctx.translate(14, (this.y.from + this.y.to) / 2);
    ctx.rotate(-Math.PI / 2);
    ctx.textAlign = "center";
    ctx.fillText(this.axisText(this.known.y), 0, 0);
    ctx.restore();
    this.drawMark(ctx, ink, paper);
  }

  axisText({ label, unit }) { return unit ? `${label} [${unit}]` : label; }

  drawLoci(ctx) {
    for (const [k, [, xs, ys]] of this.loci.entries()) {
      ctx.beginPath();
      let down = false;
      xs.forEach((x, i) => {
        if (!Number.isFinite(x + ys[i])) down = false;
        else if (down) ctx.lineTo(this.x.pixel(x), this.y.pixel(ys[i]));
        else { ctx.moveTo(this.x.pixel(x), this.y.pixel(ys[i])); down = true; }
      });
      for (const [colour, thick, dashes] of [[HALO, 3.5, []], [LOCUS, 1.6, LOCUS_LINES[k % LOCUS_LINES.length][1]]]) {
        ctx.strokeStyle = colour;
        ctx.lineWidth = thick;
        ctx.setLineDash(dashes);
        ctx.stroke();
      }
      ctx.setLineDash([]);
    }
  }

  /** A ring about the point that is chosen. */
  drawMark(ctx, ink, paper) {
    const x = this.x.pixel(this.known.x.values[this.column]), y = this.y.pixel(this.known.y.values[this.row]);
    for (const [colour, thick] of [[paper, 5], [ink, 2]]) {
      ctx.strokeStyle = colour;
      ctx.lineWidth = thick;
      ctx.beginPath();
      ctx.arc(x, y, 8, 0, 2 * Math.PI);
      ctx.stroke();
    }
  }

  /** Pointer and keys. */
  follow() {
    this.canvas.addEventListener("click", (event) => {
      const box = this.canvas.getBoundingClientRect();
      const near = (values, value) => values.reduce((best, one, k) => (Math.abs(one - value) < Math.abs(values[best] - value) ? k : best), 0);
      const column = near(this.known.x.values, this.x.value(event.clientX - box.left));
      const row = near(this.known.y.values, this.y.value(event.clientY - box.top));
      this.choose(row, column);
    });
    this.canvas.addEventListener("keydown", (event) => {
      const step = STEPS[event.key];
      if (!step || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      event.stopPropagation(); // elsewhere arrow keys step through the motion
      const far = event.shiftKey ? 10 : 1, held = (value, count) => Math.min(Math.max(value, 0), count - 1);
      const way = (values) => (rises(values) ? far : -far);
      this.choose(held(this.row + step[1] * way(this.known.y.values), this.rows),
        held(this.column + step[0] * way(this.known.x.values), this.columns));
    });
  }

  /** Show the motion of a point on its attractor. */
  async choose(row, column) {
    const { live, player } = this.page;
    if (!live) return; // the page is still being put together
    [this.row, this.column] = [row, column];
    const { cell } = this, span = this.spans[cell];
    this.played = this.values;
    this.tell(false);
    changed();
    if (!Number.isFinite(span)) return;
    const still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    await live.play(this.played, span);
    if (cell !== this.cell) return; // overtaken by the next choice
    player.pause();
    player.seek(player.motion.start);
    if (!still) player.play();
    this.tell(true);
  }

  /** All numbers of the definition at the point. */
  get values() {
    const { numbers } = this.page.live.model, { x, y, paths } = this.known;
    const set = new Map();
    for (const [path, values] of y.sets) set.set(path, values[this.row]);
    for (const [path, values] of x.sets) set.set(path, values[this.column]);
    paths.forEach((path, k) => set.set(path, this.states[this.cell * paths.length + k]));
    return numbers.map(({ path, value }) => set.get(path) ?? value);
  }

  /** What is known of the point, in a table; `there`: its motion is shown. */
  tell(there) {
    const { x, y, several } = this.known, code = this.classes[this.cell], { words } = this.looks.get(code);
    const count = this.counts[this.cell], span = this.spans[this.cell];
    const rows = [[x, this.column], [y, this.row]].map(([axis, k]) => [axis.label, `${figures(axis.values[k], 6)} ${axis.unit}`.trim()]);
    if (code > 0) {
      rows.push(["period", `${count === 1 ? "1 period" : `${count} periods`} of the drives, ${quantity(span, "s", 7)}`]);
      rows.push([several[0] < several[1] ? `largest ${several[0]} of ${several[1]} multipliers` : "multipliers", this.spectrum()]);
    } else {
      const played = Number.isFinite(span) ? `: ${count} periods of the drives from its last state` : "";
      rows.push(["motion", `${words}${played}`]);
    }
    for (const { force } of there ? CONTENT.mechanism.clearances : []) {
      const series = this.page.stage.motion.byName.get(force);
      if (series) rows.push([`largest ${series.words}`, quantity(Math.max(...this.page.stage.motion.range(series)), series.unit, 4)]);
    }
    this.facts.replaceChildren(element("table", {}, element("tbody", {}, ...rows.map(([name, value]) =>
      element("tr", {}, element("th", { scope: "row" }, name), element("td", {}, value))))));
  }

  spectrum() {
    const [shown] = this.known.several, texts = [];
    for (let k = 0; k < shown; k++) {
      const [real, imaginary] = this.multipliers.subarray(2 * (this.cell * shown + k));
      const size = Math.hypot(real, imaginary);
      if (Number.isNaN(size)) return "no orbit was found near the motion";
      if (size < this.known.noise) texts.push(`< ${figures(this.known.noise, 1)}`);
      else if (imaginary) texts.push(`${figures(real, 7)} ${imaginary < 0 ? "−" : "+"} ${figures(Math.abs(imaginary), 7)}i`);
      else texts.push(figures(real, 7));
    }
    return texts.join("; ");
  }
}

/** Whether values along an axis increase. */
function rises(values) { return values[values.length - 1] >= values[0]; }
