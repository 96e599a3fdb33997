/** Light and dark. */
const dark = window.matchMedia("(prefers-color-scheme: dark)");
let colours = {};

function setTheme(name) {
  const root = document.documentElement;
  root.dataset.theme = name;
  const style = getComputedStyle(root);
  const own = (variable) => style.getPropertyValue(variable).trim();
  colours = {
    ...CONTENT.palette[name], paper: own("--card"), line: own("--line"), soft: own("--soft"),
  };
  root.style.setProperty("--load", colours.load);
  root.style.setProperty("--reaction", colours.spring);
  changed();
}

function theme() { return colours; }

function lineColour(k) {
  const lines = CONTENT.lines[document.documentElement.dataset.theme];
  return lines[k % lines.length];
}

/** Paper is light; `draw` draws at once. */
function followPrinter(draw) {
  let before = null;
  const take = (name) => { setTheme(name); draw(); };
  window.addEventListener("beforeprint", () => {
    before = document.documentElement.dataset.theme;
    take("light");
  });
  window.addEventListener("afterprint", () => take(before ?? "light"));
}

function followTheme(button) {
  setTheme(dark.matches ? "dark" : "light");
  dark.addEventListener("change", () => setTheme(dark.matches ? "dark" : "light"));
  button.addEventListener("click", () => {
    setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
  });
}
