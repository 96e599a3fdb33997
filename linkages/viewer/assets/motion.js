/** A motion: series over frames. Between frames they are interpolated, on frames they are exact. */
class Motion {
  /**
   * @param {Float64Array} time increasing or decreasing
   * @param {object[]} series {name, variable, place, label, unit, angle, smooth, values, bounds}
   */
  constructor(time, series) {
    this.time = time;
    this.series = series;
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

  nearest(t) { return Math.round(this.where(t)); }

  /** Value of a series at a place that `where` found. */
  at(series, place) {
    const { values } = series, last = values.length - 1;
    const i = Math.min(Math.floor(place), last), u = place - i;
    const a = values[i];
    if (u <= 0 || i >= last) return a;
    const b = values[i + 1];
    if (series.smooth === false) return u < 0.5 ? a : b;
    const before = i > 0 ? values[i - 1] : 2 * a - b;
    const after = i + 2 <= last ? values[i + 2] : 2 * b - a;
    const p = (b - before) / 2, q = (after - a) / 2;
    const cubic = a + u * (p + u * (3 * (b - a) - 2 * p - q + u * (2 * (a - b) + p + q)));
    return Number.isFinite(cubic) ? cubic : a + u * (b - a);
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

/** The motion that the page was written with. */
function recordedMotion(content, numbers) {
  const series = content.motion.series.map((one) => ({
    ...CONTENT.series[one.name],
    name: one.name,
    values: arrayAt(numbers, one.values),
    bounds: one.bounds && { ...one.bounds, sides: one.bounds.sides.map((side) => arrayAt(numbers, side)) },
  }));
  return new Motion(exactAt(numbers, content.motion.time), series);
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
