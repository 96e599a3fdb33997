/** Files of what is shown: pictures, curves, a film. */
const SHARP = 2; // pixels of a picture for each on the screen
const FILM = { rate: 30, bits: 8e6 }; // pictures and bits a second
const KINDS = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"];

class Exports {
  constructor(host, page) {
    this.page = page;
    this.stem = CONTENT.file.replace(/\.[^.]*$/, "");
    this.film = null;
    const menu = host.parentElement;
    menu.addEventListener("keydown", (event) => { if (event.key === "Escape") menu.open = false; });
    const button = (text, act) => {
      const made = element("button", { type: "button" }, text);
      made.addEventListener("click", () => {
        menu.open = false;
        act();
      });
      host.append(made);
      return made;
    };
    button("Picture, PNG", () => this.png("picture", this.pictureSize, (ctx) => this.picture(ctx)));
    button("Picture, SVG", () => this.svg("picture", this.pictureSize, (ctx) => this.picture(ctx)));
    button("Diagrams, PNG", () => this.png("diagrams", this.diagramsSize, (ctx) => this.diagrams(ctx)));
    button("Diagrams, SVG", () => this.svg("diagrams", this.diagramsSize, (ctx) => this.diagrams(ctx)));
    button("Curves, CSV", () => downloaded(new Blob([this.csv], { type: "text/csv" }), `${this.stem}.csv`));
    const kind = window.MediaRecorder && KINDS.find((one) => MediaRecorder.isTypeSupported(one));
    if (kind) this.record = button("Film, WebM", () => (this.film ? this.cut() : this.roll(kind)));
  }

  get pictureSize() {
    const { clientWidth, clientHeight } = document.getElementById("view");
    return [clientWidth, clientHeight];
  }

  get diagramsSize() { return [640, 260 * this.page.panels.panels.length || 1]; }

  /** Both mechanisms and all magnifying glasses, as they stand on the page. */
  picture(ctx) {
    const { page } = this, colours = theme(), [width, height] = this.pictureSize;
    ctx.fillStyle = colours.paper;
    ctx.fillRect(0, 0, width, height);
    const origin = document.getElementById("view").getBoundingClientRect();
    for (const stage of [page.stage, ...(page.second ? [page.second.stage] : [])]) {
      const box = stage.canvas.getBoundingClientRect();
      ctx.save();
      ctx.translate(box.left - origin.left, box.top - origin.top);
      stage.drawOn(ctx, page.player.time);
      ctx.restore();
    }
    let [x, y] = [width - 10, 10];
    for (const glass of page.stage.glasses) {
      const side = Math.min(168, 0.35 * width);
      ctx.save();
      ctx.translate(x - side, y);
      ctx.fillStyle = colours.paper;
      ctx.fillRect(0, 0, side, side + 22);
      ctx.strokeStyle = colours.line;
      ctx.lineWidth = 1;
      ctx.beginPath();
      ctx.rect(0, 0, side, side + 22);
      ctx.stroke();
      glass.drawOn(ctx, page.stage.motion.where(page.player.time), colours, side);
      ctx.fillStyle = colours.ink;
      ctx.font = "12px system-ui, sans-serif";
      ctx.textAlign = "center";
      ctx.textBaseline = "middle";
      ctx.fillText(glass.caption.innerText.split("\n")[0], side / 2, side + 10);
      ctx.restore();
      y += side + 32;
    }
    ctx.fillStyle = colours.soft;
    ctx.font = "12px system-ui, sans-serif";
    ctx.textAlign = "left";
    ctx.textBaseline = "middle";
    ctx.fillText(`${CONTENT.mechanism.name}, t = ${quantityLike(page.player.time, page.player.motion)}`, 12, 16);
  }

  diagrams(ctx) {
    const { panels, player } = this.page, colours = theme(), [width, height] = this.diagramsSize;
    ctx.fillStyle = colours.paper;
    ctx.fillRect(0, 0, width, height);
    panels.panels.forEach(({ plot, lines }, k) => {
      ctx.save();
      ctx.translate(0, 260 * k + 26);
      ctx.font = "600 13px system-ui, sans-serif";
      ctx.fillStyle = colours.ink;
      ctx.textAlign = "left";
      ctx.textBaseline = "middle";
      ctx.fillText(plot.title, 12, -10);
      plot.drawOn(ctx, width - 20, 200);
      plot.drawPoints(ctx, player.time, colours);
      ctx.font = "12px system-ui, sans-serif";
      ctx.textBaseline = "middle";
      ctx.textAlign = "left";
      let x = MARGIN.left;
      lines.forEach((one, n) => {
        const text = lines.length > 1 ? ownerOf(one) || one.words : one.words;
        ctx.fillStyle = lineColour(n);
        ctx.fillRect(x, 213, 14, 3);
        ctx.fillStyle = colours.soft;
        ctx.fillText(text, x + 19, 215);
        x += ctx.measureText(text).width + 36;
      });
      ctx.restore();
      plot.drawn = "";
    });
    changed();
  }

  png(name, [width, height], draw) {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [SHARP * width, SHARP * height];
    const ctx = canvas.getContext("2d");
    ctx.scale(SHARP, SHARP);
    draw(ctx);
    return new Promise((done) => canvas.toBlob((blob) => {
      downloaded(blob, `${this.stem}-${name}.png`);
      done(blob);
    }));
  }

  svg(name, [width, height], draw) {
    const paper = new Paper(width, height);
    draw(paper);
    downloaded(new Blob([paper.text], { type: "image/svg+xml" }), `${this.stem}-${name}.svg`);
    return paper.text;
  }

  /** Time, all that open diagrams show, and traced points, in SI units. */
  get csv() {
    const { panels, stage } = this.page, { motion } = panels;
    const shown = new Set(panels.panels.flatMap(({ lines, plot }) => [plot.across, ...lines]).filter(Boolean));
    const columns = [["time", "s", motion.time], ...Array.from(shown, (one) => [one.name, one.unit, one.values])];
    stage.traces.forEach(({ weights }, k) => {
      const terms = termsOf(motion, weights), name = Object.entries(weights).map(([joint, weight]) => `${figures(weight, 3)} ${joint}`).join(" + ");
      ["x", "y"].forEach((axis, n) => columns.push([`point ${k + 1} (${name}) ${axis}`, "m",
        motion.time.map((_, i) => terms.reduce((sum, term) => sum + term[0] * term[n + 1][i], 0))]));
    });
    const head = columns.map(([name, unit]) => `"${`${name}${unit && unit !== "1" ? ` [${unit}]` : ""}`.replaceAll('"', '""')}"`);
    const rows = Array.from(motion.time, (_, i) => columns.map(([, , values], k) => String(k ? Number(values[i].toPrecision(8)) : values[i])).join(","));
    return [head.join(","), ...rows, ""].join("\r\n");
  }

  /** Record from the start of the motion to its end, at the speed that is chosen. */
  roll(kind) {
    const { player } = this.page, canvas = document.createElement("canvas"), size = this.pictureSize;
    [canvas.width, canvas.height] = size;
    const ctx = canvas.getContext("2d"), chunks = [];
    const recorder = new MediaRecorder(canvas.captureStream(FILM.rate), { mimeType: kind, videoBitsPerSecond: FILM.bits });
    recorder.ondataavailable = ({ data }) => chunks.push(data);
    const done = new Promise((end) => { recorder.onstop = () => end(new Blob(chunks, { type: "video/webm" })); });
    player.pause();
    player.seek(player.motion.start);
    this.film = { recorder, ctx, before: player.time, done: done.then((blob) => { downloaded(blob, `${this.stem}.webm`); return blob; }) };
    this.record.textContent = "Stop the film";
    this.picture(ctx);
    recorder.start();
    player.play();
  }

  /** The next picture of a film; at the end of the motion it is cut. */
  frame() {
    if (!this.film) return;
    const { player } = this.page, back = player.motion.sign * (player.time - this.film.before) < 0;
    if (back || !player.playing) {
      this.cut();
      return;
    }
    this.film.before = player.time;
    this.picture(this.film.ctx);
  }

  cut() {
    const { recorder, done } = this.film;
    this.film = null;
    this.record.textContent = "Film, WebM";
    this.page.player.pause();
    recorder.stop();
    return done;
  }
}
