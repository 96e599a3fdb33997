/**
 * Computes motions for other numbers: beside the page, or on it where it may have no workers.
 * `model` and `ideal` (null if there is none) stand above.
 */
const PARTS = [60, 1.6]; // ms after which the beginning of a motion is told first, and growth from there
const listed = ({ numbers, series, paths, statuses, modes, free }) => ({ numbers, series, paths, statuses, modes, free });
const known = { kind: "model", model: listed(model), ideal: ideal && listed(ideal) };

/**
 * Series of one of the models at times, as far as it comes, and its parameters. `told` gets the
 * beginning of the motion while the rest is computed.
 */
function follow(of, numbers, times, options, told = null) {
  const parameters = Float64Array.from(of.parameters), state = Float64Array.from(of.state);
  const rows = of.series.map(() => new Float64Array(times.length));
  const out = new Float64Array(of.series.length);
  let reached = 0, status = of.feed(numbers, parameters, state), failed = 0;
  const own = parameters.slice(0, of.paths.length), since = Date.now();
  let due = PARTS[0];
  const visit = (i, t, at) => {
    failed = failed || of.outputs(t, at, parameters, out);
    if (failed) return;
    rows.forEach((row, k) => { row[i] = out[k]; });
    reached = i + 1;
    if (!told || Date.now() - since < due || reached === times.length) return;
    due = (Date.now() - since) * PARTS[1];
    told({ kind: "part", rows: rows.map((row) => row.slice(0, reached)), reached, parameters: own });
  };
  if (!status) status = of.integrate(parameters, state, times, options, visit).status;
  return { rows, reached, parameters: own, status: status || failed };
}

/** Numbers of the ideal mechanism: it has some of those of the other one. */
function idealNumbers(numbers) {
  const places = new Map(model.numbers.map((one, k) => [one.path, k]));
  return ideal.numbers.map(({ path, value }) => numbers[places.get(path)] ?? value);
}

/**
 * Outputs at times of a mechanism whose coordinates are given, with no motion computed.
 * `coordinates` has an array for each coordinate and rate of the state, or null where it stays as it
 * is at the start. Where loops cannot be closed there is no number.
 */
function posed({ numbers, times, coordinates }) {
  const parameters = Float64Array.from(model.parameters), state = Float64Array.from(model.state);
  const rows = model.series.map(() => new Float64Array(times.length).fill(NaN));
  const out = new Float64Array(model.series.length), start = model.feed(numbers, parameters, state);
  const own = parameters.slice(0, model.paths.length);
  let status = start;
  for (let i = 0; i < times.length && !start; i++) {
    coordinates.forEach((values, k) => { if (values) state[k] = values[i]; });
    const failed = model.settled(times[i], state, parameters) || model.outputs(times[i], state, parameters, out);
    status = status || failed;
    if (!failed) rows.forEach((row, k) => { row[i] = out[k]; });
  }
  return { rows, parameters: own, status };
}

/**
 * `check` is called again and again while it computes, and may throw; `told` gets the beginning of
 * the motion.
 */
function answer({ numbers, times, rtol, atol }, check = null, told = null) {
  const options = { rtol, atol, check };
  const found = follow(model, numbers, times, options, told);
  const beside = ideal && found.reached > 1
    ? follow(ideal, idealNumbers(numbers), times.subarray(0, found.reached), options) : null;
  return { kind: "motion", ...found, ideal: beside };
}

if (typeof document === "undefined") {
  onmessage = ({ data }) => {
    const found = answer(data, null, postMessage), rows = [...found.rows, ...(found.ideal?.rows ?? [])];
    postMessage(found, rows.map((row) => row.buffer));
  };
  postMessage(known);
} else {
  window.computing = { known, answer, posed };
}
