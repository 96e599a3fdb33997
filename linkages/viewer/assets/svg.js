/** Paper that takes the calls of a canvas and becomes an SVG file. */
class Paper {
  constructor(width, height) {
    Object.assign(this, {
      width, height, parts: [], path: "", stack: [], dashes: [], offset: [0, 0], clips: 0, clipped: "",
      fillStyle: "#000", strokeStyle: "#000", lineWidth: 1, lineCap: "butt", lineJoin: "miter", globalAlpha: 1,
      font: "12px sans-serif", textAlign: "left", textBaseline: "alphabetic",
    });
    this.ruler = document.createElement("canvas").getContext("2d");
  }

  save() {
    const { fillStyle, strokeStyle, lineWidth, lineCap, lineJoin, globalAlpha, font, textAlign, textBaseline, dashes, offset, clipped } = this;
    this.stack.push({ fillStyle, strokeStyle, lineWidth, lineCap, lineJoin, globalAlpha, font, textAlign, textBaseline, dashes, offset, clipped });
  }

  restore() { Object.assign(this, this.stack.pop()); }
  translate(x, y) { this.offset = [this.offset[0] + x, this.offset[1] + y]; }
  setLineDash(dashes) { this.dashes = dashes; }
  clearRect() {}

  measureText(text) {
    this.ruler.font = this.font;
    return this.ruler.measureText(text);
  }

  at(x, y) { return `${short(x + this.offset[0])} ${short(y + this.offset[1])}`; }
  beginPath() { this.path = ""; }
  closePath() { this.path += "Z"; }
  moveTo(x, y) { this.path += `M${this.at(x, y)}`; }
  lineTo(x, y) { this.path += `${this.path ? "L" : "M"}${this.at(x, y)}`; }

  rect(x, y, width, height) {
    this.moveTo(x, y);
    for (const [a, b] of [[x + width, y], [x + width, y + height], [x, y + height]]) this.lineTo(a, b);
    this.closePath();
  }

  arc(x, y, radius, from, to, back = false) {
    const turn = 2 * Math.PI, whole = Math.abs(to - from) >= turn - 1e-9;
    let sweep = to - from;
    if (whole) sweep = back ? -turn : turn;
    else if (!back && sweep < 0) sweep += turn;
    else if (back && sweep > 0) sweep -= turn;
    const spot = (angle) => [x + radius * Math.cos(angle), y + radius * Math.sin(angle)];
    this.lineTo(...spot(from));
    for (const share of [0.5, 1]) {
      this.path += `A${short(radius)} ${short(radius)} 0 0 ${sweep > 0 ? 1 : 0} ${this.at(...spot(from + share * sweep))}`;
    }
  }

  clip() {
    this.clipped = ` clip-path="url(#clip${++this.clips})"`;
    this.parts.push(`<clipPath id="clip${this.clips}"><path d="${this.path}"/></clipPath>`);
  }

  get alpha() { return this.globalAlpha < 1 ? ` opacity="${short(this.globalAlpha)}"` : ""; }

  get edge() {
    const dashes = this.dashes.length ? ` stroke-dasharray="${this.dashes.map(short).join(" ")}"` : "";
    return `stroke="${plain(this.strokeStyle)}" stroke-width="${short(this.lineWidth)}" stroke-linecap="${this.lineCap}" stroke-linejoin="${this.lineJoin}"${dashes}`;
  }

  stroke() { if (this.path) this.parts.push(`<path d="${this.path}" fill="none" ${this.edge}${this.alpha}${this.clipped}/>`); }
  fill() { if (this.path) this.parts.push(`<path d="${this.path}" fill="${plain(this.fillStyle)}"${this.alpha}${this.clipped}/>`); }

  fillRect(x, y, width, height) {
    const had = this.path;
    this.path = "";
    this.rect(x, y, width, height);
    this.fill();
    this.path = had;
  }

  fillText(text, x, y) { this.word(text, x, y, `fill="${plain(this.fillStyle)}"`); }
  strokeText(text, x, y) { this.word(text, x, y, `fill="none" ${this.edge}`); }

  word(text, x, y, look) {
    const anchor = { center: "middle", right: "end" }[this.textAlign] ?? "start";
    const base = { middle: "central", top: "hanging" }[this.textBaseline] ?? "auto";
    const [left, top] = this.at(x, y).split(" ");
    this.parts.push(`<text x="${left}" y="${top}" text-anchor="${anchor}" dominant-baseline="${base}" style="font:${plain(this.font)}" ${look}${this.alpha}>${plain(text)}</text>`);
  }

  get text() {
    const { width, height } = this;
    return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}">\n${this.parts.join("\n")}\n</svg>\n`;
  }
}

function short(value) { return String(Math.round(100 * value) / 100); }

function plain(text) {
  return String(text).replace(/[&<>"]/g, (sign) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[sign]);
}
