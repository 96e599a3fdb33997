/** Axes of a plot: from values to pixels, with round numbers beside them. */
class Axis {
  constructor(low, high, from, to, flush) {
    const room = flush ? 0 : 0.06 * (high - low) || 0.5 * Math.abs(high) || 1;
    this.low = low - room;
    this.high = high + room;
    if (this.low === this.high) [this.low, this.high] = [low - 1, high + 1];
    this.from = from;
    this.to = to;
  }

  pixel(value) {
    return this.from + ((value - this.low) / (this.high - this.low)) * (this.to - this.from);
  }

  value(pixel) {
    return this.low + ((pixel - this.from) / (this.to - this.from)) * (this.high - this.low);
  }

  /** Round values, about so many pixels apart, but at least two. */
  ticks(apartBy, degrees) {
    const found = this.rounded(apartBy, degrees);
    return found.length < 2 && apartBy > 12 ? this.ticks(0.6 * apartBy, degrees) : found;
  }

  rounded(apartBy, degrees) {
    const rough = ((this.high - this.low) * apartBy) / Math.abs(this.to - this.from);
    const power = 10 ** Math.floor(Math.log10(rough));
    const steps = degrees && rough > 20 ? [30, 45, 90, 180, 360, 720, 1800, 3600].map((s) => s / power)
      : [1, 2, 5, 10];
    const step = (steps.find((one) => one * power >= rough) ?? 10) * power, found = [];
    for (let k = Math.ceil(this.low / step - 1e-9); k * step <= this.high + 1e-9 * step; k++) {
      found.push(k * step);
    }
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    if (digits > 4) return found.map((at) => [at, figures(Math.abs(at) < 1e-9 * step ? 0 : at, 2)]);
    return found.map((at) => [at, at.toFixed(digits).replace("-", "−").replace(/^−(0(\.0*)?)$/, "$1")]);
  }
}
