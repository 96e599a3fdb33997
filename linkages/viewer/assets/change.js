const PERIODIC = /^(drives|loads|laws|parameters)\b/; // numbers on which the period of a section may depend

/** Shows the motion for numbers that differ from those of the file. */
async function liveNumbers(host, page) {
  const { recorded, stage, player } = page;
  const live = new Live(await inflated(document.getElementById("worker").textContent).text());
  const known = await live.model, { model, ideal } = known;
  const names = [...CONTENT.mechanism.driven, ...CONTENT.mechanism.free];
  const [left, low, right, high] = stage.camera.box;
  const before = CONTENT.plane ? null : { motion: recorded, parts: partsOf(recorded, new Map(), CONTENT) };
  const kinematics = new Kinematics(live, known);
  const state = { ...known, engine: live, kinematics, shown: Promise.resolve(), base: recorded, preview: null, span: null };
  let frames = Math.max(recorded.time.length, 600); // what a motion needed last time
  state.first = state.last = [recorded, page.ghost, page.sizes, new Map()]; // what is shown of whole motions
  const own = (numbers, parameters) => [radii(model, numbers, page.sizes), given(model, parameters)];
  const compute = async (numbers) => {
    const times = state.span ? evenTimes(0, state.span, frames) : timesOf(recorded, frames);
    const found = await live.motion(numbers, times, CONTENT.tolerances, (part) => grow(numbers, part));
    if (!found) return;
    page.message(stopText(known, found));
    page.busy("");
    if (found.time.length < 2) {
      state.preview = null;
      page.show(...state.last);
      return;
    }
    const motion = liveMotion(known, found);
    const ghost = motion.ideal && !ideal.free ? new Ghost(motion.ideal, page.aliases) : null;
    const swings = fastestOf(motion.own, names).rate * motion.own.duration;
    const needed = Math.min(MOST_FRAMES, Math.ceil(FINE * swings * (frames / motion.own.time.length)));
    if (recorded.section && !state.span && !state.numbers.changedOnes.some((k) => PERIODIC.test(model.numbers[k].path))) {
      motion.own.section = motion.own.sectionAt(recorded.section.time);
    }
    if (!found.status) state.base = motion.own; // coordinates of a motion that stopped lead nowhere
    state.preview = null;
    state.last = [motion.own, ghost, ...own(numbers, found.parameters), { before }];
    page.show(...state.last);
    if (needed <= frames) return;
    frames = Math.min(MOST_FRAMES, Math.ceil(1.2 * needed));
    await compute(numbers);
  };

  /** The beginning of a motion: diagrams have it, the picture as soon as it reaches the time. */
  const grow = (numbers, part) => {
    if (part.time.length < 2) return;
    const motion = liveMotion(known, part, state.span ?? recorded.end).own;
    page.curves(motion);
    page.values.show(motion);
    if (motion.sign * (player.time - motion.end) <= 0) {
      stage.show(motion, null, ...own(numbers, part.parameters), { before, still: true });
    }
    changed();
  };

  /** Positions of driven coordinates at once. */
  const sketch = (numbers) => {
    const { motion, parameters, missing, here } = kinematics.motion(numbers, state.base, player.time, state.span ? state.base : recorded);
    if (!here) {
      page.busy("Cannot be assembled here");
      return false;
    }
    state.preview = motion;
    stage.show(motion, null, ...own(numbers, parameters), { before, still: true });
    page.busy([CONTENT.mechanism.free.length ? "Positions only: the motion is being computed" : "",
      missing ? `cannot be assembled in ${figures(100 * missing, 2)} % of the motion` : ""].filter(Boolean).join("; "));
    changed();
    return true;
  };

  /** Show what numbers make of the motion; `hold` leaves the motion itself to a later call. */
  state.change = (numbers, { hold = false } = {}) => {
    const same = model.numbers.every((one, k) => one.value === numbers[k]);
    if (same) {
      live.forget();
      page.message("");
      page.busy("");
      state.base = recorded;
      state.span = null;
      state.preview = null;
      state.last = state.first;
      page.show(...state.last);
      state.shown = Promise.resolve();
    } else {
      sketch(numbers);
      if (hold) live.forget(); else state.shown = compute(numbers);
    }
    return state.shown;
  };
  /** Show the motion of numbers from their initial state, for a time in seconds. */
  state.play = (numbers, span) => {
    state.span = span;
    state.numbers.show(numbers);
    page.busy("The motion is being computed");
    state.shown = compute(Float64Array.from(numbers));
    return state.shown;
  };
  const slow = live.beside ? "" : "Motions are computed on this page itself, because workers are forbidden here. It stands still meanwhile.";
  state.numbers = new Numbers(host, known, Math.max(right - left, high - low), slow, state.change);
  return state;
}

/** Even times of a motion, and those at which its section is. */
function timesOf(recorded, count) {
  const even = evenTimes(recorded.start, recorded.end, count);
  if (!recorded.section) return even;
  const near = (1e-3 * recorded.duration) / count, { section } = recorded;
  const others = even.filter((t) => Math.abs(section.time[Math.round(section.where(t))] - t) > near);
  return Float64Array.from([...others, ...section.time]).sort((a, b) => recorded.sign * (a - b));
}

/** Path of a parameter → what it is. */
function given({ paths }, parameters) {
  return new Map(paths.map((path, k) => [path, parameters[k]]));
}

/** When, where and why a motion ends before its time, or deviations are not known; or nothing. */
function stopText({ model, ideal }, { time, status, ideal: beside }) {
  if (!status) {
    return beside?.status ? `No deviations from the ideal mechanism: ${reason(ideal, beside.status)}.` : "";
  }
  const why = reason(model, status);
  if (time.length < 2) return `${why[0].toUpperCase()}${why.slice(1)}. The motion before is still shown.`;
  return `Stops at t = ${figures(time[time.length - 1], 4)} s: ${why}.`;
}

function reason(of, status) {
  const text = typeof status === "string" ? status : of.statuses[status] ?? `status ${status}`;
  return text.replace(/\.$/, ""); // sentences here end with a stop of their own
}

/** Radial clearances among the numbers. */
function radii(model, numbers, sizes) {
  const found = { ...sizes };
  model.numbers.forEach(({ path }, k) => {
    const match = /^clearances\.(.+)\.size$/.exec(path);
    if (match) found[match[1]] = numbers[k];
  });
  return found;
}
