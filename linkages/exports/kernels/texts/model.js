export const model = (() => {
  const n = described.coordinates.length;
  const free = described.free, carried = described.carried, internal = described.internal;
  const firstCarried = free + internal, firstMargin = n + 2 * carried;
  const timed = new Float64Array(described.timed), work = new Float64Array(described.written);
  const full = new Float64Array(3 * n), turns = new Float64Array(described.turned.length);
  const asWritten = Float64Array.from(described.numbers, (number) => number.value);

  /* Evaluates the equations into `work`. */
  function evaluated(t, state, parameters) {
    return clock(t, parameters, timed) || equations(state, parameters, timed, work);
  }

  /* Replaces dependent coordinates that are carried along by those that close all loops; call it
     once before others look at `work` again. */
  function carry(state) {
    for (let k = 0; k < carried; k++) {
      state[firstCarried + k] = work[n + k];
      state[n + firstCarried + k] = work[n + carried + k];
    }
  }

  /* Coordinates that close all loops at a time, from those of a state close by. */
  function settled(t, state, parameters) {
    const status = evaluated(t, state, parameters);
    if (!status) carry(state);
    return status;
  }

  /* From numbers and a state whose dependent coordinates are about right. */
  function start(numbers, parameters, state) {
    const refused = feed(numbers, parameters, state);
    if (refused) return refused;
    prepare(parameters);
    const status = settled(0, state, parameters);
    if (status || turns.length === 0) return status;
    described.turned.forEach((place) => { parameters[place] = 0; });
    settle(state, parameters, timed, turns);
    described.turned.forEach((place, k) => { parameters[place] = turns[k]; });
    prepare(parameters);
    return settled(0, state, parameters);
  }

  const model = {
    ...described,
    parameters: Float64Array.from(described.parameters),
    state: Float64Array.from(described.state),

    /* Derivatives of the coordinates, then of their rates; returns a status, 0 if all is well. */
    rates(t, state, parameters, out) {
      const status = evaluated(t, state, parameters);
      for (let i = 0; i < n; i++) {
        out[i] = i >= free && i < firstCarried ? 0 : state[n + i];
        out[n + i] = work[i];
      }
      return status;
    },

    /* Values of `series`; returns a status. */
    outputs(t, state, parameters, out) {
      const status = evaluated(t, state, parameters);
      if (status) return status;
      full.set(state);
      full.set(work.subarray(0, n), 2 * n);
      return quantities(full, parameters, timed, out);
    },

    settled,

    /* Parameters and initial state from numbers of the definition file, in the order of `numbers`;
       returns a status. Dependent coordinates without a closed form are followed from the numbers
       of the file, in more steps where that is needed. */
    feed(numbers, parameters, state) {
      let status = 0;
      for (let steps = 1; steps <= 64; steps *= 4) {
        parameters.set(model.parameters);
        state.set(model.state);
        for (let k = 1; k <= steps; k++) {
          const between = asWritten.map((own, i) => own + ((numbers[i] - own) * k) / steps);
          status = start(k === steps ? numbers : between, parameters, state);
          if (status) break;
        }
        if (!status || carried === 0) return status;
      }
      return status;
    },
  };
  prepare(model.parameters);
  return model;
})();
