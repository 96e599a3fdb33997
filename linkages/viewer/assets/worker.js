/**
 * Computes motions for other numbers: beside the page, or on it where it may have no workers.
 * `model` and `ideal` (null if there is none) stand above.
 */
const listed = ({ numbers, series, paths, statuses, modes, free }) => ({ numbers, series, paths, statuses, modes, free });
const known = { kind: "model", model: listed(model), ideal: ideal && listed(ideal) };

/** Series of one of the models at times, as far as it comes, and its parameters. */
function follow(of, numbers, times, options) {
  const parameters = Float64Array.from(of.parameters), state = Float64Array.from(of.state);
  const rows = of.series.map(() => new Float64Array(times.length));
  const out = new Float64Array(of.series.length);
  let reached = 0, status = of.feed(numbers, parameters, state), failed = 0;
  const own = parameters.slice(0, of.paths.length);
  const visit = (i, t, at) => {
    failed = failed || of.outputs(t, at, parameters, out);
    if (failed) return;
    rows.forEach((row, k) => { row[i] = out[k]; });
    reached = i + 1;
  };
  if (!status) status = of.integrate(parameters, state, times, options, visit).status;
  return { rows, reached, parameters: own, status: status || failed };
}

/** Numbers of the ideal mechanism: it has some of those of the other one. */
function idealNumbers(numbers) {
  const places = new Map(model.numbers.map((one, k) => [one.path, k]));
  return ideal.numbers.map(({ path, value }) => numbers[places.get(path)] ?? value);
}

/** `check` is called again and again while it computes, and may throw. */
function answer({ numbers, times, rtol, atol }, check = null) {
  const options = { rtol, atol, check };
  const found = follow(model, numbers, times, options);
  const beside = ideal && found.reached > 1
    ? follow(ideal, idealNumbers(numbers), times.subarray(0, found.reached), options) : null;
  return { kind: "motion", ...found, ideal: beside };
}

if (typeof document === "undefined") {
  onmessage = ({ data }) => {
    const found = answer(data), rows = [...found.rows, ...(found.ideal?.rows ?? [])];
    postMessage(found, rows.map((row) => row.buffer));
  };
  postMessage(known);
} else {
  window.computing = { known, answer };
}
