/** Shows the motion for numbers that differ from those of the file. */
async function liveNumbers(host, page) {
  const { recorded, stage, player } = page;
  const live = new Live(document.getElementById("worker").textContent);
  const model = await live.model;
  const names = [...CONTENT.mechanism.driven, ...CONTENT.mechanism.free];
  const [left, low, right, high] = stage.camera.box;
  const state = { model, shown: Promise.resolve() };
  let frames = Math.max(recorded.time.length, 600); // what a motion needed last time

  const compute = async (numbers) => {
    const times = evenTimes(recorded.start, recorded.end, frames);
    const found = await live.motion(numbers, times, CONTENT.tolerances);
    if (!found) return;
    page.message(stopText(model, found));
    if (found.time.length < 2) return;
    const motion = liveMotion(model, found);
    page.show(motion, null, radii(model, numbers, page.sizes));
    const swings = fastestOf(motion, names).rate * motion.duration;
    const needed = Math.min(MOST_FRAMES, Math.ceil(FINE * swings * (frames / motion.time.length)));
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
      page.show(recorded, page.ghost, page.sizes);
      state.shown = Promise.resolve();
    } else {
      state.shown = compute(numbers);
    }
    return state.shown;
  };
  state.numbers = new Numbers(host, model, Math.max(right - left, high - low), state.change);
  return state;
}

/** When, where and why a motion ends before its time; empty if it does not. */
function stopText(model, { time, status }) {
  if (!status) return "";
  const why = typeof status === "string" ? status : model.statuses[status] ?? `status ${status}`;
  if (time.length < 2) return `${why[0].toUpperCase()}${why.slice(1)}. The motion before is still shown.`;
  return `Stops at t = ${figures(time[time.length - 1], 4)} s: ${why}.`;
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
