/** Numbers of the definition file, to be changed: a slider, a field and a unit each. */
const TIMES = 4; // up to which factor a slider changes a number
const PERCENT = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }; // by keys

class Numbers {
  /**
   * @param {string} slow what is to be said of how motions are computed
   * @param {Function} moved called with all numbers in SI when one has changed
   */
  constructor(host, known, size, slow, moved) {
    const { model } = known;
    this.model = model;
    this.moved = moved;
    this.values = model.numbers.map((one) => one.value);
    this.called = new Map(CONTENT.template.filter((part) => part.path).map(({ path, words }) => [path, words]));
    this.rows = model.numbers.map((one, k) => this.row(one, k, size));
    this.note = element("p");
    this.reset = element("button", { type: "button" }, "Reset all");
    this.save = element("button", { type: "button" }, "Download YAML");
    this.copy = element("button", { type: "button" }, "Copy YAML");
    this.reset.addEventListener("click", () => this.set(model.numbers.map((one) => one.value)));
    this.save.addEventListener("click", () => downloaded(new Blob([this.yaml], { type: "text/yaml" }), CONTENT.file));
    this.copy.addEventListener("click", () => copied(this.copy, this.yaml));
    host.append(element("div", { class: "bar" }, this.note, this.reset, this.copy, this.save));
    const groups = new Map();
    model.numbers.forEach((one, k) => {
      const [section, name] = parts(one.path), key = `${section} ${name}`;
      const heading = name ? [name, element("span", {}, section)] : [section];
      if (!groups.has(key)) groups.set(key, element("fieldset", {}, element("legend", {}, ...heading)));
      groups.get(key).append(this.rows[k].root);
    });
    const rest = [missingText(known), outlineText(), slow].filter(Boolean).map((text) => element("p", { class: "rest" }, text));
    host.append(...groups.values(), ...rest);
    this.tell();
  }

  row(one, k, size) {
    const id = `number-${k}`, name = parts(one.path)[2].replaceAll("_", " ");
    const label = element("label", { for: id, title: one.path }, name);
    const slider = element("input", { type: "range", min: -1, max: 1, step: "any", value: 0, "aria-label": this.words(k) });
    const field = element("input", { type: "number", step: "any", id, "aria-label": `${this.words(k)} in ${unitText(one.written) || "1"}` });
    const back = element("button", { type: "button", "aria-label": `Reset ${this.words(k)}`, title: "As in the file" }, "↺");
    const root = element("div", { class: "number" }, label, slider, field, element("span", { class: "unit" }, unitText(one.written)), back);
    const range = rangeOf(one, size), row = { root, slider, field, back, range };
    slider.addEventListener("input", () => {
      const value = range.value(Number(slider.value));
      this.change(k, Number((value / one.size).toPrecision(4)) * one.size);
    });
    slider.addEventListener("keydown", (event) => {
      const percent = PERCENT[event.key];
      if (!percent || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      const value = range.by(this.values[k], percent / 100);
      this.change(k, Number((value / one.size).toPrecision(6)) * one.size);
      slider.value = range.part(this.values[k]);
    });
    field.addEventListener("change", () => {
      if (field.value !== "" && Number.isFinite(Number(field.value))) this.change(k, Number(field.value) * one.size);
      else this.fill(k);
    });
    back.addEventListener("click", () => this.change(k, one.value));
    return row;
  }

  change(k, value) {
    this.values[k] = value;
    this.tell();
    this.moved(Float64Array.from(this.values));
  }

  /** Say other numbers, without computing their motion. */
  show(values) {
    this.values = [...values];
    this.tell();
  }

  /** What a number is called, and its value in the unit of the file. */
  words(k) { return this.called.get(this.model.numbers[k].path) ?? this.model.numbers[k].path; }

  text(k) {
    const { size, written } = this.model.numbers[k], unit = unitText(written);
    return figures(this.values[k] / size, 6) + (unit ? `\u202f${unit}` : "");
  }

  set(values) {
    this.show(values);
    this.moved(Float64Array.from(this.values));
  }

  get changedOnes() {
    return this.model.numbers.map((one, k) => k).filter((k) => this.values[k] !== this.model.numbers[k].value);
  }

  fill(k) {
    const { field, slider, range } = this.rows[k], { size } = this.model.numbers[k];
    field.value = String(Number((this.values[k] / size).toPrecision(10)));
    if (document.activeElement !== slider) slider.value = range.part(this.values[k]);
  }

  tell() {
    this.rows.forEach((row, k) => {
      if (row.told === this.values[k]) return;
      row.told = this.values[k];
      const { root, back } = row;
      const changedOne = this.values[k] !== this.model.numbers[k].value;
      root.classList.toggle("changed", changedOne);
      back.disabled = !changedOne;
      this.fill(k);
    });
    const different = this.changedOnes, count = different.length;
    this.reset.disabled = this.save.disabled = count === 0;
    this.note.textContent = count === 0 ? "All numbers are those of the file."
      : `${count === 1 ? "One number differs" : `${count} numbers differ`} from the file: ${
        different.map((k) => this.words(k)).join(", ")}.`;
    const badge = document.querySelector("#tab-numbers");
    badge?.replaceChildren("Change", ...(count ? [element("span", { class: "count" }, String(count))] : []));
  }

  /** The definition with the numbers as they are now. */
  get yaml() {
    const known = new Map(this.model.numbers.map((one, k) => [one.path, k]));
    return CONTENT.template.map((part) => {
      if (typeof part === "string") return part;
      const k = known.get(part.path), own = this.model.numbers[k];
      if (k === undefined || this.values[k] === own.value) return part.text;
      const value = String(Number((this.values[k] / own.size).toPrecision(12)));
      return own.written && own.written !== "1" ? `${value} ${own.written}` : value;
    }).join("");
  }
}

/** Quantities of the file's motion that are not there for other numbers. */
function missingText({ model, ideal }) {
  const live = new Set(model.series.map((one) => one.variable));
  const there = ({ variable, compared }) => live.has(variable) || (ideal && compared && live.has(compared));
  const gone = new Set(Object.values(CONTENT.series).filter((one) => !there(one)).map((one) => one.label));
  return gone.size ? `Not computed for other numbers: ${[...gone].join(", ")}.` : "";
}

/** Shapes that are drawn as those of the file. */
function outlineText() {
  const [first, ...others] = CONTENT.mechanism.outlines;
  if (!first) return "";
  const names = [first, ...others].join(" and ");
  return `${names[0].toUpperCase()}${names.slice(1)} are drawn as in the file.`;
}

/** How a slider from -1 to 1 becomes a value, and a value a larger one: by a factor, or by a distance. */
function rangeOf({ value, unit, path }, size) {
  const place = /\]$/.test(path) && unit === "m";
  const step = unit === "rad" ? Math.PI : place ? 0.5 * size : value === 0 ? (unit === "m" ? 0.5 * size : 1) : 0;
  if (step) return { value: (s) => value + s * step, part: (v) => clip((v - value) / step), by: (v, share) => v + share * step };
  return {
    value: (s) => value * TIMES ** s,
    part: (v) => (v / value > 0 ? clip(Math.log(v / value) / Math.log(TIMES)) : -1),
    by: (v, share) => v * (1 + share),
  };
}

/** Section, name of the entry, and what a number in it is called. */
function parts(path) {
  const axes = path.replace(/\[([01])\]$/, (_, axis) => ` ${"xy"[axis]}`);
  const [section, ...steps] = axes.split(/[. ]/);
  const entry = steps.length > 1 ? steps.shift() : "";
  return [section, entry, steps.join(" ") || section];
}

function unitText(unit) {
  return unit === "1" ? "" : unit.replace("deg", "°").replaceAll("^2", "²").replaceAll("^3", "³").replaceAll(" ", "·").replaceAll("*", "·");
}
