const LEAST_TOLERANCE = 1e-300; // so that what is and stays zero has no error

/* Follows a motion from times[0] with Dormand and Prince's method of order 8 (Hairer, Nørsett,
   Wanner: Solving Ordinary Differential Equations I, II.5, II.6 and II.10).

   model: has rates(t, state, parameters, out) and settled(t, state, parameters) -> status
   state: changes in place, to the last that was reached
   options: rtol (1e-9), atol (rtol), and the longest step
   times: increasing or decreasing; visit(i, t, state) gets the state at times[i]
   parameters: their modes, of contacts and friction, change as well
   Returns {status, time, steps}: 0, a status of the model, -2 where steps become too small, or -3
   where friction or contacts change in a way that is not followed (also: back in time). */
export function integrate(model, parameters, state, times, options, visit) {
  const { rtol, atol, longest } = { longest: Infinity, ...options };
  const relative = rtol ?? 1e-9, absolute = Math.max(atol ?? relative, LEAST_TOLERANCE);
  const { a, b, c, error, further_a: furtherA, further_c: furtherC, dense } = DOP853;
  const size = state.length, end = b.length, last = times[times.length - 1];
  const sign = last < times[0] ? -1 : 1;
  const stages = Array.from({ length: end + 1 + furtherA.length }, () => new Float64Array(size));
  const next = new Float64Array(size), trial = new Float64Array(size);
  const discarded = new Float64Array(size);
  const switching = model.modes.length > 0;
  let t = times[0], index = 0, steps = 0, prepared = false;

  function stage(row, weights, h, at) {
    trial.set(state);
    for (let j = 0; j < weights.length; j++) {
      if (weights[j] === 0) continue;
      const factor = h * weights[j], slopes = stages[j];
      for (let i = 0; i < size; i++) trial[i] += factor * slopes[i];
    }
    return model.rates(t + at * h, trial, parameters, stages[row]);
  }

  function tried(h) {
    for (let row = 1; row < end; row++) {
      const status = stage(row, a[row], h, c[row]);
      if (status) return status;
    }
    const status = stage(end, b, h, 1);
    next.set(trial);
    return status;
  }

  function errorOf(h) {
    const sums = [0, 0];
    for (let i = 0; i < size; i++) {
      const scale = absolute + relative * Math.max(Math.abs(state[i]), Math.abs(next[i]));
      for (let e = 0; e < 2; e++) {
        let found = 0;
        for (let j = 0; j <= end; j++) found += error[e][j] * stages[j][i];
        sums[e] += (found / scale) ** 2;
      }
    }
    if (sums[0] === 0) return 0;
    return (Math.abs(h) * sums[0]) / Math.sqrt((sums[0] + 0.01 * sums[1]) * size);
  }

  /* The state at a part of the step, from all stages. */
  function between(h, part) {
    trial.set(state);
    dense.forEach((powers, j) => {
      let weight = 0;
      for (let k = powers.length - 1; k >= 0; k--) weight = (weight + powers[k]) * part;
      for (let i = 0; i < size; i++) trial[i] += h * weight * stages[j][i];
    });
    return trial;
  }

  /* Further stages for dense output, once for a step. */
  function prepare(h) {
    for (let k = 0; !prepared && k < furtherA.length; k++) {
      const status = stage(end + 1 + k, furtherA[k], h, furtherC[k]);
      if (status) return status;
    }
    prepared = true;
    return 0;
  }

  /* The mode that the state at a part of the step contradicts; -1 if none, or if there is no such
     state: steps that go on there are rejected. */
  function contradicted(h, part) {
    const status = model.rates(t + part * h, between(h, part), parameters, discarded);
    return status ? -1 : model.contradicted(parameters);
  }

  /* The part of the step after which a mode changes, just behind that, and which; of 8 places the
     first that contradicts a mode, then bisection. */
  function change(h) {
    let low = 0, high = 0, mode = -1;
    for (let k = 1; k <= 8 && mode < 0; k++) {
      low = high;
      high = k / 8;
      mode = contradicted(h, high);
    }
    for (let k = 0; mode >= 0 && k < 60; k++) {
      const middle = (low + high) / 2;
      const found = contradicted(h, middle);
      if (middle === low || middle === high) break;
      if (found < 0) low = middle;
      else [high, mode] = [middle, found];
    }
    return { mode, part: high };
  }

  /* Samples within the step; those of iterated groups are settled. */
  function sampled(h, reached) {
    while (index < times.length && sign * (times[index] - reached) <= 0) {
      if (times[index] === reached) trial.set(next);
      else {
        const status = prepare(h);
        if (status) return status;
        between(h, (times[index] - t) / h);
      }
      const status = model.settled(times[index], trial, parameters);
      if (status) return status;
      visit(index, times[index], trial);
      index += 1;
    }
    return 0;
  }

  function firstStep() {
    let position = 0, slope = 0;
    for (let i = 0; i < size; i++) {
      const scale = absolute + relative * Math.abs(state[i]);
      position += (state[i] / scale) ** 2;
      slope += (stages[0][i] / scale) ** 2;
    }
    const both = position > 1e-10 && slope > 1e-10;
    return both ? 0.01 * Math.sqrt(position / slope) : 1e-6;
  }

  /* Whether drives lead a block through a singular position: intervals are halved until margins
     change little in each, and where one is least. */
  function ledThrough(from, margins, to, reached, depth) {
    t = to;
    const isSmall = (scale, k) => Math.abs(reached[k]) < 1e-7 * scale;
    const found = reached ? model.marginScale.findIndex(isSmall) : -1;
    if (!reached) return model.settled(to, state, parameters);
    if (found >= 0) return 1000 + model.blocks[found];
    const count = model.marginScale.length;
    const split = model.marginScale.some((scale, k) => {
      const [before, after] = [margins[count + k], reached[count + k]];
      return Math.max(Math.abs(before), Math.abs(after)) * Math.abs(to - from) > 0.35 * scale ||
        (margins[k] * before * (to - from) < 0 && reached[k] * after * (to - from) > 0);
    });
    if (!split || depth === 40) return 0;
    const middle = (from + to) / 2, there = model.margins(middle, state, parameters);
    return ledThrough(from, margins, middle, there, depth + 1) ||
      ledThrough(middle, there, to, reached, depth + 1);
  }

  /* Visits all times of a motion that drives determine. */
  function driven() {
    let before = model.margins(t, state, parameters);
    for (; index < times.length; index++) {
      const here = model.margins(times[index], state, parameters);
      if (!before) return model.settled(t, state, parameters);
      const status = index > 0 ? ledThrough(t, before, times[index], here, 0) : 0;
      if (status) return status;
      t = times[index];
      visit(index, t, state);
      before = here;
    }
    return 0;
  }

  const ended = (status) => ({ status, time: t, steps });
  if (size === 0) return ended(driven());
  if (switching && sign < 0) return ended(-3);
  let status = model.settled(t, state, parameters);
  status = status || model.rates(t, state, parameters, stages[0]);
  if (status) return ended(status);
  for (; index < times.length && times[index] === t; index++) visit(index, t, state);
  let h = sign * Math.min(firstStep(), longest), rejected = false, changes = 0, since = t;
  while (sign * (last - t) > 0) {
    if (Math.abs(h) < 1e-14 * Math.max(Math.abs(t), 1e-3)) return ended(status || -2);
    const final = sign * (t + 1.01 * h - last) > 0;
    if (final) h = last - t;
    status = tried(h);
    const error = status ? Infinity : errorOf(h);
    if (!(error <= 1)) {
      h *= error < Infinity ? Math.max(1 / 3, 0.9 * error ** (-1 / 8)) : 0.25;
      rejected = true;
      continue;
    }
    prepared = false;
    let reached = final ? last : t + h, mode = -1;
    if (switching) {
      status = prepare(h);
      if (status) return ended(status);
      const found = change(h);
      mode = found.mode;
      if (mode >= 0) {
        reached = t + found.part * h;
        next.set(between(h, found.part));
      }
    }
    status = sampled(h, reached) || model.settled(reached, next, parameters);
    if (status) return ended(status);
    t = reached;
    state.set(next);
    if (mode >= 0) status = model.changed(mode, t, state, parameters);
    status = status || model.rates(t, state, parameters, stages[0]);
    if (status) return ended(status);
    if (mode >= 0) {
      changes = t - since > 1e-10 * Math.abs(t) ? 1 : changes + 1;
      if (changes === 1) since = t;
      if (changes > 100) return ended(-2);
    }
    steps += 1;
    const growth = error > 0 ? Math.min(6, 0.9 * error ** (-1 / 8)) : 6;
    h = sign * Math.min(Math.abs(h) * (rejected ? Math.min(1, growth) : growth), longest);
    rejected = false;
  }
  return ended(0);
}
