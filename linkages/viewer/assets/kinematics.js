/** The motion at once, while somebody drags: driven coordinates for new numbers, free ones as they were. */
const SPENT = 9; // ms of a picture that this may take
const POSES = [32, 400]; // least and largest number of frames

class Kinematics {
  constructor(engine, { model }) {
    this.engine = engine;
    this.model = model;
    this.cost = SPENT / 200; // ms a frame; measured from then on
    const { free, state } = CONTENT.mechanism;
    this.state = state;
    // with free coordinates only positions are known before the motion is
    const rates = new Set(Object.values(CONTENT.rates));
    const places = new Set(Object.keys(CONTENT.rates).filter((variable) => !rates.has(variable)));
    this.shown = ({ variable }) => !free.length || places.has(variable);
  }

  /** Outputs of the model at times, with coordinates as they are in a motion. */
  outputs(numbers, base, times) {
    const places = Array.from(times, (t) => base.where(t));
    const coordinates = this.state.map((name) => {
      const series = name && base.byName.get(name);
      return series ? Float64Array.from(places, (place) => base.at(series, place)) : null;
    });
    return this.engine.computing.posed({ numbers, times, coordinates });
  }

  /** Times of frames on both sides of a time, and which of them that time is. */
  times(base, time) {
    const most = Math.min(POSES[1], base.time.length), count = Math.round(Math.min(most, Math.max(POSES[0], SPENT / this.cost)));
    const step = (base.end - base.start) / count;
    if (!step) return [Float64Array.of(time), 0];
    const before = Math.floor((time - base.start) / step + 1e-9), after = Math.floor((base.end - time) / step + 1e-9);
    return [Float64Array.from({ length: before + 1 + after }, (_, k) => time + (k - before) * step), before];
  }

  /**
   * {motion, parameters, missing, here}: the motion about a time, in which part of it loops cannot
   * be closed, and whether they can at that time. `span` is a motion with all times.
   */
  motion(numbers, base, time, span = base) {
    const [times, now] = this.times(span, time);
    const since = performance.now(), { rows, parameters } = this.outputs(numbers, base, times);
    this.cost = 0.5 * this.cost + (0.5 * (performance.now() - since)) / times.length;
    const series = liveSeries(this.model, rows).filter(this.shown);
    const x = series.find((one) => one.variable === "joint_position");
    const missing = x.values.filter((value) => !Number.isFinite(value)).length / times.length;
    return { motion: new Motion(times, series), parameters, missing, here: Number.isFinite(x.values[now]) };
  }
}
