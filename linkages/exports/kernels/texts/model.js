export const model = (() => {
  const n = described.coordinates.length;
  const free = described.free, carried = described.carried, internal = described.internal;
  const firstCarried = free + internal, moved = firstCarried;
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
    let status = feed(numbers, parameters, state);
    if (status) return status;
    described.turned.forEach((place) => { parameters[place] = 0; });
    prepare(parameters);
    status = settled(0, state, parameters);
    if (!status && turns.length > 0) {
      settle(state, parameters, timed, turns);
      described.turned.forEach((place, k) => { parameters[place] = turns[k]; });
      prepare(parameters);
      status = settled(0, state, parameters);
    }
    return status || (modes ? wake(0, state, parameters, -1) : 0);
  }

  /* --- modes: contacts and friction that change the equations --- */

  const modes = described.modes.length, firstFunction = n + 2 * carried;
  const { active, owners, jumps, sticks, shakes, held } = described.switching || { owners: [] };
  const values = new Float64Array(described.become);

  const functionOf = (k) => work[firstFunction + k];
  const rateOf = (k) => work[firstFunction + modes + k];
  const isWatched = (k, p) => active[k] < 0 || p[held + active[k]] > 0;

  /* Sets modes that follow from the state: all of them, or those behind one that has changed. */
  function wake(t, state, p, behind) {
    for (let k = 0; k < modes; k++) {
      let owner = behind < 0 ? behind : active[k];
      while (owner >= 0 && owner !== behind) owner = active[owner];
      if (owner !== behind) continue;
      const status = evaluated(t, state, p);
      if (status) return status;
      const on = functionOf(k) > 0 || (functionOf(k) === 0 && rateOf(k) >= 0);
      p[held + k] = isWatched(k, p) && on ? 1 : -1;
      if (behind < 0) remember(k, t, state, p);
    }
    return evaluated(t, state, p);
  }

  function remember(k, t, state, p) {
    if (!owners.includes(k)) return;
    become(state, p, timed, values);
    owners.forEach((owner, r) => { if (owner === k) p[held + modes + r] = values[r]; });
  }

  /* A mode that stuck goes to the side to which its function leaves. */
  function takeSide(k, t, state, p) {
    p[held + k] = -1;
    let status = evaluated(t, state, p);
    const down = -rateOf(k);
    p[held + k] = 1;
    status = status || evaluated(t, state, p);
    if (!status && rateOf(k) < down) {
      p[held + k] = -1;
      status = evaluated(t, state, p);
    }
    return status;
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

    /* Margins of blocks and their rates at a state, zero where it is singular; null if there is no
       such state. */
    margins(t, state, parameters) {
      const first = firstFunction + 2 * modes;
      return evaluated(t, state, parameters) ? null : work.slice(first);
    },

    /* The first mode that the state contradicts after `rates` there; -1 if there is none. */
    contradicted(parameters) {
      for (let k = 0; k < modes; k++) {
        const mode = parameters[held + k] || 1;
        if (isWatched(k, parameters) && mode * functionOf(k) < 0) return k;
      }
      return -1;
    },

    /* Changes a mode where its function has crossed zero, and what follows from that in state and
       parameters; returns a status, -3 for what is not followed. */
    changed(k, t, state, parameters) {
      const p = parameters;
      let status = evaluated(t, state, p);
      if (status) return status;
      if (shakes[k]) return -3;
      if (p[held + k] === 0) return takeSide(k, t, state, p);
      const rises = p[held + k] < 0, before = rateOf(k);
      if (values.length) become(state, p, timed, values);
      const jumping = rises && jumps[k] >= 0 && before > 0;
      if (!(rises && jumps[k] >= 0) || jumping) p[held + k] = -p[held + k];
      if (rises) {
        owners.forEach((owner, r) => { if (owner === k) p[held + modes + r] = values[r]; });
      }
      if (jumping) for (let i = 0; i < moved; i++) state[n + i] = values[jumps[k] + i];
      status = settled(t, state, p);
      if (!status && jumping && rateOf(k) < 0) {
        p[held + k] = -1;
        status = evaluated(t, state, p);
      }
      status = status || wake(t, state, p, k);
      if (!status && p[held + k] * rateOf(k) < -1e-9 * abs(before)) {
        if (!sticks[k]) return -3;
        p[held + k] = 0;
        status = evaluated(t, state, p) || (functionOf(k) < -1e-9 ? -3 : 0);
      }
      return status;
    },

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
