/** The clock of the page: where in the motion it is, and how fast it goes on. */
const SPEEDS = [1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10];

class Player {
  constructor(parts, drawn) {
    this.parts = parts;
    this.drawn = drawn;
    this.playing = false;
    this.time = 0;
    this.chosen = "auto";
    parts.play.addEventListener("click", () => this.toggle());
    parts.scrub.addEventListener("input", () => {
      this.pause();
      this.seek(this.motion.start + Number(parts.scrub.value) * (this.motion.end - this.motion.start));
    });
    parts.speed.addEventListener("change", () => {
      this.chosen = parts.speed.value;
      this.tellPace();
    });
  }

  /** Play another motion; the time stays if the motion has it. */
  show(motion, names) {
    const whole = !this.motion;
    this.motion = motion;
    this.fastest = fastestOf(motion, names);
    this.auto = comfortable(motion, this.fastest);
    const { speed } = this.parts;
    speed.replaceChildren(new Option(this.auto ? `auto (${speedName(this.auto)})` : "auto", "auto"),
      ...SPEEDS.map((one) => new Option(speedName(one), String(one))));
    speed.value = this.chosen;
    this.tellPace();
    this.seek(whole ? motion.start : motion.sign * Math.min(motion.sign * this.time, motion.sign * motion.end));
  }

  get speed() { return this.chosen === "auto" ? this.auto : Number(this.chosen); }
  get place() { return this.motion.where(this.time); }

  tellPace() {
    const { text, more, warn } = paceText(this.fastest, this.speed);
    const frames = this.motion.time.length / (this.motion.duration * this.fastest.rate);
    const coarse = frames < 4 ? `; the page has only ${figures(frames, 2)} frames per swing` : "";
    this.parts.pace.textContent = text + coarse;
    this.parts.pace.title = more;
    this.parts.pace.classList.toggle("warn", warn || coarse !== "");
  }

  seek(time) {
    const { start, end, sign } = this.motion;
    this.time = sign * Math.min(Math.max(sign * time, sign * start), sign * end);
    const part = (this.time - start) / (end - start || 1);
    this.parts.scrub.value = part;
    const text = `t = ${quantityLike(this.time, this.motion)}`;
    this.parts.scrub.setAttribute("aria-valuetext", text);
    this.parts.clock.textContent = text;
    changed();
  }

  /** Go to the frame that is so many frames further on. */
  step(count) {
    this.pause();
    const place = count > 0 ? Math.floor(this.place + 1e-6) : Math.ceil(this.place - 1e-6);
    const last = this.motion.time.length - 1;
    this.seek(this.motion.time[Math.min(Math.max(place + count, 0), last)]);
  }

  toggle() { if (this.playing) this.pause(); else this.play(); }

  play() {
    if (this.playing || this.motion.duration === 0) return;
    this.playing = true;
    this.parts.play.classList.add("playing");
    this.parts.play.setAttribute("aria-label", "Pause");
    let before = null;
    const tick = (now) => {
      if (!this.playing) return;
      if (before !== null) this.advance(Math.min(0.1, (now - before) / 1000));
      before = now;
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  advance(seconds) {
    const { start, end, sign, duration } = this.motion;
    let time = this.time + sign * seconds * this.speed;
    if (sign * (time - end) > 0) time = start + sign * (Math.abs(time - start) % duration);
    this.seek(time);
  }

  pause() {
    this.playing = false;
    this.parts.play.classList.remove("playing");
    this.parts.play.setAttribute("aria-label", "Play");
  }
}

function speedName(speed) {
  return speed >= 1 ? `${figures(speed, 3)}×` : `1/${figures(1 / speed, 3)}×`;
}

/** A time with as many decimals as frames need. */
function quantityLike(time, motion) {
  const scale = scaleFor(Math.max(Math.abs(motion.start), Math.abs(motion.end)), "s");
  const step = (motion.duration * scale.factor) / Math.max(1, motion.time.length - 1);
  const digits = Math.min(9, Math.max(0, Math.ceil(-Math.log10(step || 1))));
  return `${(time * scale.factor).toFixed(digits).replace("-", "−")}\u202f${scale.text}`;
}
