/** Shows the motion for numbers that differ from those of the file. */
async function liveNumbers(host, page) {
  const { recorded, stage, player } = page;
  const live = new Live(await inflated(document.getElementById("worker").textContent).text());
  const known = await live.model, { model, ideal } = known;
  const names = [...CONTENT.mechanism.driven, ...CONTENT.mechanism.free];
  const [left, low, right, high] = stage.camera.box;
  const state = { ...known, engine: live, shown: Promise.resolve() };
  let frames = Math.max(recorded.time.length, 600); // what a motion needed last time

  const compute = async (numbers) => {
    const times = evenTimes(recorded.start, recorded.end, frames);
    const found = await live.motion(numbers, times, CONTENT.tolerances);
    if (!found) return;
    page.message(stopText(known, found));
    if (found.time.length < 2) return;
    const motion = liveMotion(known, found);
    const ghost = motion.ideal && !ideal.free ? new Ghost(motion.ideal, page.aliases) : null;
    page.show(motion.own, ghost, radii(model, numbers, page.sizes), given(model, found.parameters));
    const swings = fastestOf(motion.own, names).rate * motion.own.duration;
    const needed = Math.min(MOST_FRAMES, Math.ceil(FINE * swings * (frames / motion.own.time.length)));
    if (needed <= frames) return;
    frames = Math.min(MOST_FRAMES, Math.ceil(1.2 * needed));
    await compute(numbers);
  };
  state.change = (numbers) => {
    const same = model.numbers.every((one, k) => one.value === numbers[k]);
    if (same) {
      live.next?.done(null);
      live.next = null;
      page.message("");
      page.show(recorded, page.ghost, page.sizes, new Map());
      state.shown = Promise.resolve();
    } else {
      state.shown = compute(numbers);
    }
    return state.shown;
  };
  const slow = live.beside ? "" : "Motions are computed on this page itself, for workers are forbidden here: it stands still meanwhile.";
  state.numbers = new Numbers(host, known, Math.max(right - left, high - low), slow, state.change);
  return state;
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
