/** Addresses of the page that hold changed numbers and the time. */
const TIME_KEY = "t", PLAY_KEY = "autoplay"; // no id of an element, to which browsers would scroll

/** What stands behind the # of an address: the time, and numbers in SI that are not those of the file. */
function stateText(numbers, time) {
  const parts = new URLSearchParams();
  for (const k of numbers.changedOnes) parts.append(numbers.model.numbers[k].path, String(numbers.values[k]));
  parts.append(TIME_KEY, String(Number(time.toPrecision(6))));
  return parts.toString();
}

/** The same read: {values, time, plays}; numbers that the page does not have are left out. */
function stateOf(text, { numbers }) {
  const parts = new URLSearchParams(text.replace(/^#/, ""));
  const known = (key) => parts.has(key) && parts.get(key).trim() !== "" && Number.isFinite(Number(parts.get(key)));
  const values = numbers.map(({ path, value }) => (known(path) ? Number(parts.get(path)) : value));
  return { values, time: known(TIME_KEY) ? Number(parts.get(TIME_KEY)) : null, plays: parts.has(PLAY_KEY) };
}

/** Copy a text, and say on a button whether that was possible. */
async function copied(button, text) {
  const name = button.dataset.name ??= button.textContent;
  const done = await navigator.clipboard?.writeText(text).then(() => true, () => false) || copiedByHand(text);
  button.textContent = done ? "Copied" : "Not copied";
  clearTimeout(Number(button.dataset.timer));
  button.dataset.timer = setTimeout(() => { button.textContent = name; }, 2000);
}

/** The same in frames that have no clipboard. */
function copiedByHand(text) {
  const area = element("textarea", { "aria-label": "Copied text" }), had = document.activeElement;
  area.value = text;
  document.body.append(area);
  area.select();
  const done = document.execCommand("copy");
  area.remove();
  had?.focus();
  return done;
}

/** Save a file. */
function downloaded(blob, name) {
  const address = URL.createObjectURL(blob);
  element("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
}

/** Follows the address, and gives the one of what is shown. A page in a frame has none. */
function shareAddress(button, field, { live, player }) {
  const own = window.location.protocol !== "about:";
  button.hidden = !own;
  if (!own) return Promise.resolve();
  button.addEventListener("click", () => {
    field.value = `${window.location.href.split("#")[0]}#${stateText(live.numbers, player.time)}`;
    field.hidden = false;
    field.select(); // the field has it where nothing may be copied
    copied(button, field.value);
  });
  const follow = async () => {
    if (window.location.hash.length < 2) return;
    const { values, time, plays } = stateOf(window.location.hash, live.model);
    if (values.some((value, k) => value !== live.numbers.values[k])) live.numbers.set(values);
    await live.shown;
    if (plays && !window.matchMedia("(prefers-reduced-motion: reduce)").matches) player.play();
    if (time === null) return;
    player.pause();
    player.seek(time);
  };
  window.addEventListener("hashchange", follow);
  return follow();
}
