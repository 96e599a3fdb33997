/** A motion: series over frames. Between frames they are interpolated, on frames they are exact. */
const JUMP = 5; // times the rates of change beside it together: what changes faster between frames jumps

class Motion {
  /**
   * @param {Float64Array} time increasing or decreasing
   * @param {object[]} series {name, variable, place, words, label, unit, angle, smooth, values, bounds}
   * @param {object} more {section, detail} where frames do not show these, and `last`, the time to
   *   which the motion is still being computed
   */
  constructor(time, series, { section = null, detail = null, last = null } = {}) {
    this.time = time;
    this.series = series;
    this.section = section;
    this.detail = detail;
    this.last = last;
    this.sign = time.length > 1 && time[time.length - 1] < time[0] ? -1 : 1;
    this.byName = new Map(series.map((one) => [one.name, one]));
    this.byPlace = new Map(series.map((one) => [`${one.variable}/${one.place.join("/")}`, one]));
  }

  get start() { return this.time[0]; }
  get end() { return this.time[this.time.length - 1]; }
  get duration() { return Math.abs(this.end - this.start); }

  find(variable, ...place) { return this.byPlace.get(`${variable}/${place.join("/")}`); }

  /** Place of a time among the frames, as a whole number and a part of one. */
  where(t) {
    const { time, sign } = this;
    let low = 0, high = time.length - 1;
    if (high <= 0 || sign * (t - time[0]) <= 0) return 0;
    if (sign * (t - time[high]) >= 0) return high;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (sign * (time[middle] - t) <= 0) low = middle; else high = middle;
    }
    return low + (t - time[low]) / (time[high] - time[low]);
  }

  /** The same; not a number where the motion is not known yet. */
  placeOf(t) {
    const beyond = this.sign * (t - this.end) > 1e-9 * this.duration;
    return this.last !== null && beyond ? NaN : this.where(t);
  }

  /** Value of a series at a place that `where` found. */
  at(series, place) {
    if (!(place >= 0)) return NaN;
    const { values } = series, last = values.length - 1;
    const i = Math.min(Math.floor(place), last), u = place - i;
    const a = values[i];
    if (u <= 0 || i >= last) return a;
    const b = values[i + 1];
    if (series.smooth === false) return u < 0.5 ? a : b;
    if (this.jumps(values, i)) return a + u * (b - a);
    // slopes do not look across jumps, such as those of loads: a cubic would overshoot there
    const span = this.time[i + 1] - this.time[i];
    let p = b - a, q = b - a;
    if (i > 0 && !this.jumps(values, i - 1)) {
      const part = span / (this.time[i + 1] - this.time[i - 1]);
      p += part * (this.rise(values, i - 1) * span - p);
    }
    if (i + 2 <= last && !this.jumps(values, i + 1)) {
      const part = span / (this.time[i + 2] - this.time[i]);
      q += part * (this.rise(values, i + 1) * span - q);
    }
    const cubic = a + u * (p + u * (3 * (b - a) - 2 * p - q + u * (2 * (a - b) + p + q)));
    return Number.isFinite(cubic) ? cubic : a + u * (b - a);
  }

  /** Mean rate of change from a frame to the next one. */
  rise(values, i) { return (values[i + 1] - values[i]) / (this.time[i + 1] - this.time[i]); }

  /** Whether values jump between a frame and the next one. */
  jumps(values, i) {
    if (i < 1 || i + 2 >= values.length) return false;
    const beside = Math.abs(this.rise(values, i - 1)) + Math.abs(this.rise(values, i + 1));
    return Math.abs(this.rise(values, i)) > JUMP * beside;
  }

  /** The state of a section at some of the frames. */
  sectionAt(times) {
    const places = Array.from(times).filter((t) => this.sign * (t - this.end) <= 1e-9 * this.duration).map((t) => this.where(t));
    const series = CONTENT.mechanism.state.map((name) => this.byName.get(name)).filter(Boolean);
    return new Motion(times.subarray(0, places.length), series.map((one) => ({
      ...one, values: Float64Array.from(places, (place) => this.at(one, place)), bounds: null,
    })));
  }

  /** Where a joint is: [x, y], or null. */
  joint(name, place) {
    const x = this.find("joint_position", name, "x"), y = this.find("joint_position", name, "y");
    if (!x || !y) return null;
    const found = [this.at(x, place), this.at(y, place)];
    return Number.isFinite(found[0] + found[1]) ? found : null;
  }

  get joints() {
    return this.series.filter((one) => one.variable === "joint_position" && one.place[1] === "x")
      .map((one) => one.place[0]);
  }

  /** Least and largest of a series, over what it does between frames too. */
  range(series) {
    let low = Infinity, high = -Infinity;
    for (const values of series.bounds?.sides ?? [series.values]) {
      for (const value of values) {
        if (!Number.isFinite(value)) continue;
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
    return low <= high ? [low, high] : [0, 0];
  }
}

/** The motion that a page was written with. */
function recordedMotion(content, numbers) {
  const series = content.motion.series.map((one) => ({
    ...content.series[one.name],
    name: one.name,
    values: arrayAt(numbers, one.values),
    bounds: one.bounds && { ...one.bounds, sides: one.bounds.sides.map((side) => arrayAt(numbers, side)) },
  }));
  const some = (part) => part && new Motion(exactAt(numbers, part.time),
    Object.entries(part.series).map(([name, at]) => ({ ...content.series[name], name, values: arrayAt(numbers, at) })));
  const { section, detail } = content.motion;
  return new Motion(exactAt(numbers, content.motion.time), series, { section: some(section), detail: some(detail) });
}

/** Joints of the ideal mechanism, or null. */
function ghostMotion(content, numbers) {
  const ghost = content.motion.ghost;
  if (!ghost) return null;
  const series = Object.entries(ghost.joints).flatMap(([name, places]) => ["x", "y"].map(
    (axis, k) => ({
      name: `${name}.${axis}`, variable: "joint_position", place: [name, axis],
      values: arrayAt(numbers, places[k]),
    })));
  return new Motion(exactAt(numbers, ghost.time), series);
}
