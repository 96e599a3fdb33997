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
  changed();
}

function theme() { return colours; }

function lineColour(k) {
  const lines = CONTENT.lines[document.documentElement.dataset.theme];
  return lines[k % lines.length];
}

function followTheme(button) {
  setTheme(dark.matches ? "dark" : "light");
  dark.addEventListener("change", () => setTheme(dark.matches ? "dark" : "light"));
  button.addEventListener("click", () => {
    setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
  });
}
