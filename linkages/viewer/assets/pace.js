/** How fast a motion may be shown: what swings fastest must be seen often enough. */
const FRAMES = 60; // a second, of most screens
const FRAMES_PER_SWING = 12;
const FOLLOWED = 0.25; // swings between two shown frames, beyond which nobody can follow them
const SECONDS = [4, 16]; // that a motion lasts on the screen unless swings need longer
const STEADY = 1e-6; // of the largest magnitude: what changes less does not move

/** How often a series changes between rising and falling. */
function turningPoints(values) {
  const least = STEADY * largest(values);
  let found = 0, before = 0;
  for (let i = 1; i < values.length; i++) {
    const step = values[i] - values[i - 1];
    if (!(Math.abs(step) > least)) continue;
    const sign = Math.sign(step);
    if (before && sign !== before) found++;
    before = sign;
  }
  return found;
}

/** The free or driven coordinate that swings or turns most often: {name, rate per s, turns}. */
function fastestOf(motion, names) {
  let found = { name: "", rate: 0, turns: false };
  for (const name of names) {
    const series = motion.byName.get(name);
    if (!series || motion.duration === 0) continue;
    const { values } = series;
    const swings = turningPoints(values) / 2;
    const turns = series.angle ? Math.abs(values[values.length - 1] - values[0]) / (2 * Math.PI) : 0;
    const rate = Math.max(swings, turns) / motion.duration;
    if (rate > found.rate) found = { name: name.replace(/\.[^.]*$/, ""), rate, turns: turns > swings };
  }
  return found;
}

/** A speed of 1, 2 or 5 times a power of ten that is not above one. */
function roundSpeed(speed) {
  const power = 10 ** Math.floor(Math.log10(speed) + 1e-12);
  return [5, 2, 1].find((step) => step * power <= speed * (1 + 1e-9)) * power;
}

/** The speed at which everything can be followed, and a motion lasts neither too short nor long. */
function comfortable(motion, fastest) {
  if (!motion.duration) return 0;
  let speed = 1;
  if (motion.duration > SECONDS[1]) speed = motion.duration / SECONDS[1];
  if (motion.duration < SECONDS[0]) speed = motion.duration / SECONDS[0];
  const most = fastest.rate ? FRAMES / (FRAMES_PER_SWING * fastest.rate) : Infinity;
  return roundSpeed(Math.min(speed, most));
}

/** What a speed is called: "50× slower than real time". */
function speedText(speed) {
  if (speed === 1) return "Real time";
  return speed > 1 ? `${figures(speed, 3)}× faster than real time` : `${figures(1 / speed, 3)}× slower than real time`;
}

/** What is said of a speed, in more words, and whether it is too high: {text, more, warn}. */
function paceText(fastest, speed) {
  if (!Number.isFinite(speed) || !speed) return { text: "One frame", more: "", warn: false };
  if (!fastest.rate) return { text: speedText(speed), more: "", warn: false };
  const rate = (fastest.rate * speed) / FRAMES;
  const what = `${fastest.name} ${fastest.turns ? "turns" : "swings"}`;
  const often = rate >= 0.1 ? `${figures(rate, 2)} times per shown frame`
    : `once in ${figures(1 / rate, 2)} shown frames`;
  const warn = rate > FOLLOWED;
  const more = `${what} ${often}`;
  const remark = warn ? `: ${more}, too fast to follow. You see it at random places` : "";
  return { text: speedText(speed) + remark, more, warn };
}
