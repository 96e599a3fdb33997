/** Puts the page together. */
let dirty = true;

/** Something is to be drawn anew. */
function changed() { dirty = true; }

function layerChips(host, stage) {
  host.replaceChildren(...stage.layers.map(({ key, text, colour }) => {
    const box = element("input", { type: "checkbox" });
    box.checked = stage.on[key];
    box.addEventListener("change", () => {
      stage.on[key] = box.checked;
      chip.classList.toggle("on", box.checked);
      stage.words.sides = null;
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
  host.append(element("p", {}, CONTENT.how), element("pre", {}, CONTENT.origin.definition));
}

async function start() {
  const get = (id) => document.getElementById(id);
  const numbers = await unpacked(CONTENT.numbers);
  const recorded = recordedMotion(CONTENT, numbers), found = ghostMotion(CONTENT, numbers);
  const { clearances, driven, free } = CONTENT.mechanism;
  const aliases = Object.fromEntries(clearances.map((one) => [one.bearing, one.joint]));
  const ghost = found && new Ghost(found, aliases);
  const sizes = Object.fromEntries(clearances.map((one) => [one.name, one.size]));
  const stage = new Stage(get("stage"), get("glasses"));
  const player = new Player({
    play: get("play"), scrub: get("scrub"), clock: get("clock"), speed: get("speed"), pace: get("pace"),
  });
  const panels = new Panels(get("plots"), (place) => {
    player.pause();
    player.seek(timeAt({ motion: stage.motion, place }));
  });
  const values = new Values(get("values"));
  followTheme(get("theme"));
  get("summary").textContent = CONTENT.summary;
  about(get("about"));
  const show = (motion, ideal, radii, given) => {
    stage.show(motion, ideal, radii, given);
    panels.show(motion);
    values.show(motion);
    player.show(motion, [...driven, ...free]);
    layerChips(get("shown"), stage);
    changed();
  };
  const message = (text) => {
    get("message").textContent = text;
    get("message").hidden = !text;
  };
  show(recorded, ghost, sizes, new Map());
  message(CONTENT.stopped ? `The motion stopped ${CONTENT.stopped}` : "");
  const page = { stage, player, panels, values, recorded, ghost, aliases, sizes, show, message };
  page.tabs = new Tabs(get("tabs"), {
    plots: "Diagrams", values: "Values", numbers: "Change", about: "About",
  });
  const live = await liveNumbers(get("numbers"), page);
  holdStage(stage, player);
  sizeButtons(stage);
  followKeys(player);
  new ResizeObserver(changed).observe(document.body);
  const draw = () => {
    if (!dirty) return;
    dirty = false;
    stage.draw(player.place, stage.held && stage.scene(player.place).mean(stage.held.weights));
    if (page.tabs.chosen === "plots") panels.draw(player.place);
    values.draw(player.place);
  };
  const frame = () => {
    draw();
    requestAnimationFrame(frame);
  };
  frame();
  followPrinter(draw);
  Object.assign(page, { live });
  await shareAddress(get("share"), get("address"), page);
  return page;
}

/** What tests ask, and whoever opens the console. */
window.viewer = start();
