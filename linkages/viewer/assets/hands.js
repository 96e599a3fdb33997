/** What mouse, fingers and keys do. */
const STILL = 4; // pixels: less is a click

function holdStage({ stage, player, editor }) {
  const { canvas, camera } = stage, grip = new Grip(stage);
  let held = null, before = null, crank = null, joint = null, first = null, target = null;
  const at = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const under = (spot) => grip.under(stage.motion.where(player.time), spot);
  canvas.addEventListener("pointerdown", (event) => {
    const spot = at(event), edited = editor.under(spot), found = edited ? null : under(spot);
    if (!found && !edited && event.pointerType !== "mouse") return;
    canvas.setPointerCapture(event.pointerId);
    before = first = spot;
    document.getElementById("hint").hidden = true;
    if (edited) {
      before = first = null;
      if (editor.begin(edited)) joint = edited;
      return;
    }
    if (!found) return;
    held = found;
    player.pause();
    crank = Crank.of(found, stage, player, camera.world(spot));
    canvas.classList.add("gripped");
  });
  canvas.addEventListener("pointermove", (event) => {
    const spot = at(event);
    if (first && apart(first, spot) > STILL) first = null;
    if (joint) {
      if (!target) requestAnimationFrame(() => { if (target && joint) editor.lead(target); target = null; });
      target = camera.world(spot);
    } else if (held) {
      if (first) return;
      const world = camera.world(spot), where = crank ? crank.turn(world) : grip.nearest(held, world, stage.motion.where(player.time));
      player.seek(crank ? where : timeAt({ motion: stage.motion, place: where }));
      stage.held = held;
    } else if (before) {
      camera.pan([(before[0] - spot[0]) / camera.scale, (spot[1] - before[1]) / camera.scale]);
      before = spot;
      changed();
    } else {
      const edited = editor.under(spot);
      canvas.classList.toggle("grip", Boolean(edited ? editor.choices[edited].length : under(spot)));
    }
  });
  const release = () => {
    if (target && joint) editor.lead(target);
    if (joint) editor.end();
    if (held && first) stage.trace(held);
    held = before = crank = joint = first = target = stage.held = null;
    canvas.classList.remove("gripped");
    changed();
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  // a finger on a link leads it; elsewhere it scrolls the page
  canvas.addEventListener("touchstart", (event) => {
    const { clientX, clientY } = event.touches[0], spot = at({ clientX, clientY });
    if (editor.under(spot) || under(spot)) event.preventDefault();
  }, { passive: false });
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    camera.enlarge(Math.exp(-0.01 * event.deltaY), at(event));
    changed();
  }, { passive: false });
  canvas.addEventListener("dblclick", () => { camera.whole(); changed(); });
}

/** A driven crank that is turned round and round: at the end of the motion it goes on at its start. */
class Crank {
  /** The crank of what is held; null where it is none, or does not turn one way all the time. */
  static of({ body }, { motion, parts }, player, world) {
    const series = motion.find("bar_angle", body.name), { driven, ground } = CONTENT.mechanism;
    const pivot = body.joints.find((name) => ground.includes(name));
    if (!series || !pivot || !driven.includes(series.name)) return null;
    const { values } = series, sign = Math.sign(values[values.length - 1] - values[0]);
    for (let i = 1; i < values.length; i++) if (!(sign * (values[i] - values[i - 1]) > 0)) return null;
    const place = motion.where(player.time), centre = new Scene(motion, place, parts).joint(pivot);
    return centre && new Crank({ values, sign, motion, centre, angle: motion.at(series, place) }, world);
  }

  constructor(known, world) {
    Object.assign(this, known);
    this.last = this.direction(world);
  }

  direction([x, y]) { return Math.atan2(y - this.centre[1], x - this.centre[0]); }

  /** The time at which the crank points where it is led. */
  turn(world) {
    const now = this.direction(world), turn = 2 * Math.PI, { values, sign } = this;
    this.angle += now - this.last - turn * Math.round((now - this.last) / turn);
    this.last = now;
    const first = values[0], last = values[values.length - 1];
    const whole = turn * Math.floor(Math.abs(last - first) / turn + 1e-9);
    if (whole && sign * (this.angle - last) > 1e-9) this.angle -= sign * whole;
    if (whole && sign * (first - this.angle) > 1e-9) this.angle += sign * whole;
    const inside = sign * Math.min(Math.max(sign * this.angle, sign * first), sign * last);
    const steps = new Motion(values, []);
    return timeAt({ motion: this.motion, place: steps.where(inside) });
  }
}

function sizeButtons(stage) {
  const { camera } = stage;
  const act = (id, what) => document.getElementById(id).addEventListener("click", () => {
    what();
    stage.words.places = null;
    changed();
  });
  act("nearer", () => camera.enlarge(1.4));
  act("farther", () => camera.enlarge(1 / 1.4));
  act("whole", () => camera.whole());
}

/** Space plays; arrows go from frame to frame, with shift ten of them; home and end to the ends. */
function followKeys(player) {
  document.addEventListener("keydown", (event) => {
    const own = event.target.closest?.("input, select, button, textarea, summary");
    if (event.ctrlKey || event.metaKey || event.altKey || (own && own.id !== "scrub" && own.id !== "play")) return;
    const far = event.shiftKey ? 10 : 1, { motion } = player;
    const acts = {
      " ": () => player.toggle(),
      ArrowRight: () => player.step(far),
      ArrowLeft: () => player.step(-far),
      Home: () => player.seek(motion.start),
      End: () => player.seek(motion.end),
    };
    const act = acts[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  });
}
