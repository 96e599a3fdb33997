/** Edit by dragging: a joint goes where it is dragged, by other lengths, points or ground positions. */
const KEEP = 3e-3; // weight of all other joints, which should stay where they are
const SHORTEST = 1e-3; // of the picture: the shortest length
const DIGITS = 4; // of numbers in the unit of the file

class Editor {
  constructor(host, page) {
    const { live, stage } = page;
    this.page = page;
    this.stage = stage;
    this.numbers = live.numbers;
    this.kinematics = live.kinematics;
    this.model = live.model;
    this.on = false;
    this.undone = [];
    const [left, low, right, high] = stage.camera.box;
    this.size = Math.max(right - left, high - low);
    const names = new Set([...CONTENT.mechanism.ground, ...CONTENT.mechanism.bodies.flatMap((body) => body.joints)]);
    this.choices = Object.fromEntries([...names].map((name) => [name, this.choicesOf(name)]));
    this.says = element("p", { role: "status" });
    const button = (text, act) => {
      const made = element("button", { type: "button" }, text);
      made.addEventListener("click", act);
      return made;
    };
    this.undo = button("Undo", () => this.back());
    const copy = button("Copy YAML", () => copied(copy, this.numbers.yaml));
    this.copy = copy;
    const reset = button("Reset", () => this.set(this.model.numbers.map((one) => one.value)));
    this.toggle = document.getElementById("edit");
    host.append(this.says, this.undo, copy, reset, button("Done", () => this.open(false)));
    this.host = host;
    this.toggle.hidden = !Object.values(this.choices).some((found) => found.length);
    this.toggle.addEventListener("click", () => this.open(!this.on));
  }

  open(on) {
    this.on = on;
    this.host.hidden = !on;
    this.toggle.setAttribute("aria-pressed", String(on));
    if (on) {
      this.page.player.pause();
      document.getElementById("hint").hidden = true;
    }
    this.stage.marked = on ? Object.fromEntries(Object.entries(this.choices).map(([name, found]) => [name, found.length > 0])) : null;
    this.tell([]);
    changed();
  }

  /** Places among the numbers that move a joint. */
  choicesOf(joint) {
    const paths = new Map(this.model.numbers.map(({ path }, k) => [path, k]));
    const { ground, bodies, clearances } = CONTENT.mechanism;
    const known = (all) => all.filter((path) => paths.has(path)).map((path) => paths.get(path));
    if (ground.includes(joint)) return known([`joints.${joint}[0]`, `joints.${joint}[1]`]);
    const alike = this.alike(joint, clearances), found = new Set();
    for (const body of bodies) {
      for (const own of body.joints.filter((name) => alike.includes(name))) {
        const name = alike.find((one) => !one.includes(".")) ?? own;
        let some = known([`bars.${body.name}.length`, `bars.${body.name}.points.${name}[0]`, `bars.${body.name}.points.${name}[1]`,
          `sliders.${body.name}.through[0]`, `sliders.${body.name}.through[1]`]);
        // a joint in the origin of its body moves by all others
        if (!some.length) some = known([...paths.keys()].filter((path) => path.startsWith(`bars.${body.name}.points.`)));
        for (const k of some) found.add(k);
      }
    }
    return [...found];
  }

  /** A joint with a clearance is that of its journal, and that of its bearing. */
  alike(joint, clearances = CONTENT.mechanism.clearances) {
    const own = clearances.find((one) => one.joint === joint || one.bearing === joint);
    return own ? [own.joint, own.bearing] : [joint];
  }

  /** The joint near a place in pixels, or null. */
  under(at) {
    if (!this.on) return null;
    const scene = this.stage.scene(this.stage.motion.where(this.page.player.time));
    let found = null, least = 24;
    for (const name of Object.keys(this.choices)) {
      const place = scene.joint(name), away = place ? apart(this.stage.camera.place(place), at) : Infinity;
      if (away < least || (away === least && this.choices[name].length)) [found, least] = [name, away];
    }
    return found;
  }

  begin(joint) {
    this.joint = joint;
    this.before = [...this.numbers.values];
    if (!this.choices[joint].length) {
      this.says.textContent = `${joint} cannot be dragged: no length or coordinate of the file moves it. A zero in the file is a part of the structure.`;
      return false;
    }
    this.stage.editing = true;
    return true;
  }

  /** Places of all joints with numbers, first the one that is dragged; null if loops cannot close. */
  places(values) {
    const { page, kinematics } = this;
    const { rows } = kinematics.outputs(Float64Array.from(values), page.live.base, [page.player.time]);
    this.order ??= this.model.series.flatMap((one, k) => {
      const known = CONTENT.series[one.name];
      return known?.variable === "joint_position" ? [{ k, joint: known.place[0] }] : [];
    });
    const alike = this.alike(this.joint), own = [], rest = [];
    for (const { k, joint } of this.order) {
      if (joint === this.joint) own.push(rows[k][0]);
      else if (!alike.includes(joint)) rest.push(rows[k][0]);
    }
    const found = [...own, ...rest];
    return found.every(Number.isFinite) ? found : null;
  }

  /** Lead the joint towards a point of the plane, as far as the mechanism can be assembled. */
  lead(target) {
    const start = [...this.numbers.values];
    let here = this.places(start);
    const from = here ?? this.places(this.before);
    if (!from) return;
    for (let share = 1; share > 0.05; share /= 2) {
      const goal = from.map((value, k) => (k < 2 ? value + share * (target[k] - value) : value));
      const values = this.solved(here ? start : [...this.before], goal);
      if (!values) continue;
      const moved = this.choices[this.joint].filter((k) => values[k] !== this.before[k]);
      this.set(values, false);
      this.tell(moved);
      return;
    }
  }

  /** Numbers with which joints are at a goal, by Gauss and Newton; null if they cannot be assembled. */
  solved(values, goal) {
    const free = this.choices[this.joint], weight = (k) => (k < 2 ? 1 : KEEP * KEEP);
    const step = 1e-6 * this.size;
    for (let round = 0; round < 4; round++) {
      const here = this.places(values);
      if (!here) return null;
      const columns = free.map((k) => {
        const other = [...values];
        other[k] += step;
        const there = this.places(other);
        return there && there.map((value, i) => (value - here[i]) / step);
      });
      if (columns.some((column) => !column)) return null;
      const dot = (a, b) => a.reduce((sum, value, k) => sum + weight(k) * value * b[k], 0);
      const off = goal.map((value, k) => value - here[k]);
      const matrix = columns.map((a, i) => columns.map((b, j) => dot(a, b) + (i === j ? 1e-9 : 0)));
      const change = solveSquare(matrix, columns.map((column) => dot(column, off)));
      free.forEach((k, i) => { values[k] = this.allowed(k, values[k] + change[i]); });
      if (Math.max(...change.map(Math.abs)) < 1e-5 * this.size) break;
    }
    for (const k of free) {
      const { size } = this.model.numbers[k];
      values[k] = Number((values[k] / size).toPrecision(DIGITS)) * size;
    }
    return this.places(values) && values;
  }

  allowed(k, value) {
    return /\.length$/.test(this.model.numbers[k].path) ? Math.max(value, SHORTEST * this.size) : value;
  }

  end() {
    if (!this.stage.editing) return;
    this.stage.editing = false;
    if (this.before.some((value, k) => value !== this.numbers.values[k])) this.undone.push(this.before);
    this.set([...this.numbers.values]);
  }

  set(values, whole = true) {
    this.numbers.show(values);
    this.page.live.change(Float64Array.from(values), { hold: !whole && !this.page.live.engine.beside });
    this.undo.disabled = !this.undone.length;
  }

  back() {
    const values = this.undone.pop();
    if (values) this.set(values);
    this.tell([]);
  }

  /** Which numbers a drag has changed. */
  tell(moved) {
    this.undo.disabled = !this.undone.length;
    this.says.textContent = moved.length ? moved.map((k) => `${this.numbers.words(k)} ${this.numbers.text(k)}`).join(", ")
      : "Drag a ringed joint. Lengths and ground positions follow.";
  }
}

/** The solution of a square system, by elimination with pivots. */
function solveSquare(matrix, right) {
  const rows = matrix.map((row, i) => [...row, right[i]]), size = rows.length;
  for (let i = 0; i < size; i++) {
    const best = rows.slice(i).reduce((at, row, k) => (Math.abs(row[i]) > Math.abs(rows[at][i]) ? k + i : at), i);
    [rows[i], rows[best]] = [rows[best], rows[i]];
    for (let k = i + 1; k < size; k++) {
      const factor = rows[k][i] / rows[i][i];
      for (let j = i; j <= size; j++) rows[k][j] -= factor * rows[i][j];
    }
  }
  const found = new Array(size);
  for (let i = size - 1; i >= 0; i--) {
    const sum = rows[i].slice(i + 1, size).reduce((total, value, j) => total + value * found[i + 1 + j], 0);
    found[i] = (rows[i][size] - sum) / rows[i][i];
  }
  return found;
}
