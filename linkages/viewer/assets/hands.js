/** What mouse, fingers and keys do. */
function holdStage(stage, player) {
  const { canvas, camera } = stage, grip = new Grip(stage);
  let held = null, before = null;
  const at = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  canvas.addEventListener("pointerdown", (event) => {
    const found = grip.under(player.place, at(event));
    if (!found && event.pointerType !== "mouse") return;
    canvas.setPointerCapture(event.pointerId);
    before = at(event);
    if (!found) return;
    held = found;
    player.pause();
    canvas.classList.add("gripped");
  });
  canvas.addEventListener("pointermove", (event) => {
    const spot = at(event);
    if (held) {
      const place = grip.nearest(held, camera.world(spot), player.place);
      player.seek(timeAt({ motion: stage.motion, place }));
      stage.held = held;
    } else if (before) {
      camera.pan([(before[0] - spot[0]) / camera.scale, (spot[1] - before[1]) / camera.scale]);
      before = spot;
      changed();
    } else {
      canvas.classList.toggle("grip", Boolean(grip.under(player.place, spot)));
    }
  });
  const release = () => {
    held = before = stage.held = null;
    canvas.classList.remove("gripped");
    changed();
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  // a finger on a link leads it; elsewhere it scrolls the page
  canvas.addEventListener("touchstart", (event) => {
    const { clientX, clientY } = event.touches[0];
    if (grip.under(player.place, at({ clientX, clientY }))) event.preventDefault();
  }, { passive: false });
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    camera.enlarge(Math.exp(-0.01 * event.deltaY), at(event));
    changed();
  }, { passive: false });
  canvas.addEventListener("dblclick", () => { camera.whole(); changed(); });
}

function sizeButtons(stage) {
  const { camera } = stage;
  const act = (id, what) => document.getElementById(id).addEventListener("click", () => {
    what();
    stage.words.sides = null;
    changed();
  });
  act("nearer", () => camera.enlarge(1.4));
  act("farther", () => camera.enlarge(1 / 1.4));
  act("whole", () => camera.whole());
}

/** Space plays; arrows go from frame to frame, with shift ten of them; home and end to the ends. */
function followKeys(player) {
  document.addEventListener("keydown", (event) => {
    const own = event.target.closest?.("input, select, button, textarea");
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
