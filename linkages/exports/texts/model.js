const evaluation = newEvaluation();

/* Numbers, parameters and the initial state of the definition, and the equations. */
export const model = {
  ...described,
  parameters: Float64Array.from(OWN_PARAMETERS),
  state: Float64Array.from(OWN_STATE),

  /* Derivatives of the coordinates, then of their rates; returns a status, 0 if all is well. */
  rates: (t, state, parameters, out) => slopes_at(t, state, parameters, evaluation, out),

  /* Values of `series`; returns a status. */
  outputs: (t, state, parameters, out) => outputs_at(t, state, parameters, evaluation, out),

  /* Replaces coordinates without a closed form by those that close all loops; returns a status. */
  settled: (t, state, parameters) => close_loops(t, state, parameters, evaluation),

  /* Parameters and initial state from numbers of the definition file, in the order of `numbers`;
     returns a status. */
  feed: (numbers, parameters, state) => start_from(numbers, parameters, state, evaluation),

  integrate,
};
prepare(model.parameters);

/* Follows a motion from times[0].

   parameters: modes of contacts and friction and assembly modes in them change as the motion goes on
   state: changes in place, to the last that was reached
   times: increasing or decreasing; visit(i, t, state) gets the state at times[i]
   options: method ("dop853", of order 8 and adaptive, or "rk4", in equal steps), rtol (1e-9), atol
     (rtol), `longest`, the longest step, and `check`, which is called before each step
   Returns {status, time, steps}: 0, or a status that `model.statuses` explains. */
function integrate(parameters, state, times, options, visit) {
  const { method = "dop853", rtol, atol, longest = Infinity, check = null } = options;
  const m = newMotion();
  Object.assign(m, { p: parameters, y: state, times, visit, check, longest, count: times.length });
  m.equal = method === "rk4" ? 1 : 0;
  m.rtol = rtol ?? 1e-9;
  m.atol = atol ?? m.rtol;
  m.t = times[0];
  m.sign = times[times.length - 1] < times[0] ? -1 : 1;
  const status = moved(m);
  return { status, time: m.t, steps: m.steps };
}
