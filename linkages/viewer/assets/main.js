/** Puts the page together. */
let dirty = true;

/** Something is to be drawn anew. */
function changed() { dirty = true; }

function layerChips(host, page) {
  const { stage } = page, key = stage.layers.map((layer) => layer.key).join(" ");
  if (host.dataset.layers === key) return; // whoever is at one of them stays there
  host.dataset.layers = key;
  host.replaceChildren(...stage.layers.map(({ key, text, colour }) => {
    const box = element("input", { type: "checkbox" });
    box.checked = stage.on[key];
    box.addEventListener("change", () => {
      stage.on[key] = box.checked;
      chip.classList.toggle("on", box.checked);
      stage.words.places = null;
      page.curves(page.panels.motion);
      changed();
    });
    const chip = element("label", { class: "chip" }, box);
    chip.classList.toggle("on", box.checked);
    if (colour) chip.append(element("i", { class: colour }));
    chip.append(text);
    return chip;
  }));
}

function about(host) {
  for (const note of CONTENT.notes) host.append(element("p", {}, `Note: ${note}`));
  host.append(element("p", {}, CONTENT.how), element("pre", { tabindex: "0", "aria-label": "Definition" }, CONTENT.origin.definition));
}

async function start() {
  const get = (id) => document.getElementById(id);
  const numbers = await unpacked(CONTENT.numbers);
  const recorded = recordedMotion(CONTENT, numbers), found = ghostMotion(CONTENT, numbers);
  const { clearances, driven, free } = CONTENT.mechanism;
  const aliases = Object.fromEntries(clearances.map((one) => [one.bearing, one.joint]));
  const ghost = found && new Ghost(found, aliases);
  const sizes = Object.fromEntries(clearances.map((one) => [one.name, one.size]));
  const stage = new Stage(get("stage"), get("glasses"), CONTENT);
  const player = new Player({
    play: get("play"), scrub: get("scrub"), clock: get("clock"), speed: get("speed"), pace: get("pace"),
  });
  const panels = new Panels(get("plots"), (time) => {
    player.pause();
    player.seek(time);
  });
  const values = new Values(get("values"));
  const said = (id) => (text) => {
    if (get(id).textContent !== text) get(id).textContent = text;
    get(id).hidden = !text;
  };
  followTheme(get("theme"));
  get("summary").textContent = CONTENT.summary;
  about(get("about"));
  const page = { stage, player, panels, values, recorded, ghost, aliases, sizes, second: null, message: said("message"), busy: said("busy") };
  /** Show a motion in diagrams, and pale what it is compared with. */
  page.curves = (motion) => {
    panels.beside = [stage.on.before && stage.before?.motion, page.second?.motion].filter(Boolean);
    panels.show(motion);
  };
  page.show = (motion, ideal, radii, given, { before = null } = {}) => {
    stage.show(motion, ideal, radii, given, { before, still: stage.editing });
    page.curves(motion);
    values.show(motion);
    player.show(motion, [...driven, ...free]);
    layerChips(get("shown"), page);
    changed();
  };
  page.show(recorded, ghost, sizes, new Map());
  page.message(CONTENT.stopped ? `The motion stopped ${CONTENT.stopped}` : "");
  page.tabs = new Tabs(get("tabs"), {
    ...(CONTENT.plane && { plane: "Plane" }), plots: "Diagrams", values: "Values", numbers: "Change", about: "About",
  });
  page.plane = CONTENT.plane && new Plane(get("plane"), page, CONTENT.plane, numbers);
  page.live = await liveNumbers(get("numbers"), page);
  page.editor = new Editor(get("editor"), page);
  page.exports = new Exports(get("exports"), page);
  page.compare = new Compare(page);
  holdStage(page);
  sizeButtons(stage);
  followKeys(player);
  new ResizeObserver(changed).observe(document.body);
  const draw = () => {
    if (!dirty) return;
    dirty = false;
    const { time } = player;
    stage.draw(time, stage.held && stage.scene(stage.motion.where(time)).mean(stage.held.weights));
    page.second?.stage.draw(time, null);
    if (page.tabs.chosen === "plots") panels.draw(time);
    if (page.tabs.chosen === "plane") page.plane.draw();
    values.draw(panels.motion.placeOf(time));
    page.drawn = (page.drawn ?? 0) + 1;
  };
  const frame = () => {
    draw();
    page.exports.frame();
    requestAnimationFrame(frame);
  };
  frame();
  followPrinter(draw);
  await shareAddress(get("share"), get("address"), page);
  return page;
}

