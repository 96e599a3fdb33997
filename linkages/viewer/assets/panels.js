/** Diagrams below each other, each with a choice of what it shows. */
const TIME = "time";
const MOST_LINES = 12;

class Panels {
  constructor(host, seek) {
    this.host = host;
    this.seek = seek;
    this.panels = [];
    this.beside = []; // other motions whose lines are shown as well
    this.more = element("button", { type: "button", id: "more" }, "+ Diagram");
    this.more.addEventListener("click", () => this.add(TIME, this.first()).focus());
    host.append(this.more);
  }

  /** Show another motion in all panels. */
  show(motion) {
    this.motion = motion;
    if (!this.panels.length) for (const [x, y] of this.defaults()) this.add(x, y);
    for (const panel of this.panels) this.refresh(panel);
  }

  draw(time) {
    const place = this.motion.placeOf(time);
    for (const panel of this.panels) {
      panel.plot.draw(place, time);
      panel.lines.forEach((series, k) => {
        panel.shown[k].textContent = steady(this.motion.at(series, place) * panel.plot.yScale?.factor, 4);
      });
    }
  }

  first() { return `all ${this.motion.series[0].variable}`; }

  /** [x, y] of the first diagrams: what a mechanism of this kind is looked at for. */
  defaults() {
    const { free, driven } = CONTENT.mechanism, all = (variable) => `all ${variable}`;
    const has = (variable) => this.motion.series.some((one) => one.variable === variable);
    const output = has("slider_position") ? all("slider_position") : this.rocking() ?? all("bar_angle");
    const found = [[TIME, output]];
    const second = ["clearance_force", "drive_effort", "bar_speed"].find(has);
    if (second) found.push([TIME, all(second)]);
    const moved = free[0] ?? driven[0];
    const rate = free.length ? this.rateOf(moved) : this.rateOf(output) ?? (has("slider_velocity") && all("slider_velocity"));
    if (moved && rate) found.push([moved, rate]);
    return found;
  }

  /** The last bar that swings to and fro and is not driven. */
  rocking() {
    const led = new Set([...CONTENT.mechanism.driven, ...CONTENT.mechanism.free]);
    return this.motion.series.filter((one) => one.variable === "bar_angle" && !led.has(one.name))
      .filter((one) => { const [low, high] = this.motion.range(one); return high - low > 1e-3 && high - low < 2 * Math.PI; })
      .at(-1)?.name;
  }

  rateOf(name) {
    const series = this.motion.byName.get(name);
    const rates = CONTENT.rates[series?.variable];
    return rates && this.motion.find(rates, ...series.place)?.name;
  }

  add(x, y) {
    const root = element("div", { class: "panel" });
    const head = root.appendChild(element("div", { class: "head" }));
    const panel = { root, x, y, lines: [], shown: [] };
    const up = head.appendChild(this.choice(panel, "y", "Shown upwards"));
    head.append(element("span", {}, "over"));
    head.append(this.choice(panel, "x", "Shown to the right"));
    panel.once = head.appendChild(element("button", { type: "button", class: "once", "aria-label": "Points once per period only", title: "Poincaré section: points once per period only" }, "⁙"));
    panel.once.addEventListener("click", () => {
      panel.plot.sectioned = !panel.plot.sectioned;
      this.refresh(panel);
      changed();
    });
    const close = head.appendChild(element("button", { type: "button", class: "close", "aria-label": "Remove this diagram", title: "Remove" }, "×"));
    close.addEventListener("click", () => this.remove(panel));
    const host = root.appendChild(element("div", { class: "plot" }));
    const foot = root.appendChild(element("div", { class: "foot" }));
    panel.legend = foot.appendChild(element("div", { class: "legend" }));
    panel.note = foot.appendChild(element("p", { class: "note" }));
    panel.plot = new Plot(host);
    this.follow(panel);
    this.host.insertBefore(root, this.more);
    this.panels.push(panel);
    this.refresh(panel);
    changed();
    return up;
  }

  remove(panel) {
    panel.root.remove();
    this.panels = this.panels.filter((other) => other !== panel);
    this.more.focus();
  }

  choice(panel, key, label) {
    const select = element("select", { class: key, "aria-label": label });
    if (key === "x") select.append(new Option("time", TIME));
    const groups = new Map();
    for (const one of this.motion.series) {
      if (!groups.has(one.variable)) groups.set(one.variable, []);
      groups.get(one.variable).push(one);
    }
    for (const [variable, members] of groups) {
      const group = element("optgroup", { label: members[0].label });
      if (key === "y" && members.length > 1 && members.length <= MOST_LINES) {
        group.append(new Option(`${members[0].label} (all)`, `all ${variable}`));
      }
      for (const one of members) group.append(new Option(one.words, one.name));
      select.append(group);
    }
    if (![...select.options].some((option) => option.value === panel[key])) {
      const members = groups.get(panel[key].replace(/^all /, "")) ?? this.motion.series;
      panel[key] = members[0].name;
    }
    select.value = panel[key];
    select.addEventListener("change", () => {
      panel[key] = select.value;
      this.refresh(panel);
      changed();
    });
    return select;
  }

  refresh(panel) {
    const { motion } = this;
    panel.lines = panel.y.startsWith("all ")
      ? motion.series.filter((one) => one.variable === panel.y.slice(4))
      : [motion.byName.get(panel.y)].filter(Boolean);
    const across = panel.x === TIME ? null : motion.byName.get(panel.x);
    const several = panel.y.startsWith("all "), { words, label } = panel.lines[0] ?? { words: "", label: "" };
    panel.plot.show(motion, across, panel.lines, `${several ? label : words} over ${across?.words ?? TIME}`, this.others(panel));
    panel.shown = panel.lines.map(() => element("b"));
    panel.legend.replaceChildren(...panel.lines.map((one, k) => {
      const mark = element("i");
      mark.style.background = lineColour(k);
      return element("span", { title: one.name }, mark, (several && ownerOf(one)) || one.words, panel.shown[k]);
    }));
    panel.once.hidden = !panel.plot.points;
    if (panel.once.hidden) panel.plot.sectioned = false;
    panel.once.setAttribute("aria-pressed", String(Boolean(panel.plot.sectioned)));
    panel.note.textContent = panel.plot.note;
    panel.note.hidden = !panel.plot.note;
  }

  /** The same lines of motions that are shown beside this one, pale. */
  others({ x, lines }) {
    return this.beside.flatMap((motion) => {
      const across = x === TIME ? null : motion.byName.get(x);
      const own = lines.map((one) => motion.byName.get(one.name));
      return x === TIME || across ? [{ motion, across, lines: own }] : [];
    });
  }

  /** The cursor goes where the pointer is held. */
  follow(panel) {
    const { front } = panel.plot;
    const lead = (event) => {
      const box = front.getBoundingClientRect();
      const place = panel.plot.placeAt([event.clientX - box.left, event.clientY - box.top]);
      this.seek(timeAt({ motion: this.motion, place }));
    };
    front.addEventListener("pointerdown", (event) => {
      front.setPointerCapture(event.pointerId);
      lead(event);
    });
    front.addEventListener("pointermove", (event) => {
      if (front.hasPointerCapture(event.pointerId)) lead(event);
    });
  }
}

/** An element with attributes and children. */
function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}
