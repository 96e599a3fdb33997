/** Beside the page: computes motions for other numbers. `model` and `integrate` stand above. */
const listed = ({ numbers, series, free, statuses, modes }) => ({ numbers, series, free, statuses, modes });
postMessage({ kind: "model", model: listed(model) });

onmessage = ({ data: { numbers, times, rtol, atol } }) => {
  const parameters = Float64Array.from(model.parameters), state = Float64Array.from(model.state);
  const rows = model.series.map(() => new Float64Array(times.length));
  const out = new Float64Array(model.series.length);
  let reached = 0, status = model.feed(numbers, parameters, state), failed = 0;
  const visit = (i, t, at) => {
    failed = failed || model.outputs(t, at, parameters, out);
    if (failed) return;
    rows.forEach((row, k) => { row[i] = out[k]; });
    reached = i + 1;
  };
  if (!status) status = integrate(parameters, state, times, { rtol, atol }, visit).status;
  postMessage({ kind: "motion", rows, reached, status: status || failed },
    rows.map((row) => row.buffer));
};
