/** Diagrams below each other, each with a choice of what it shows. */
const TIME = "time";
const MOST_LINES = 12;

class Panels {
  constructor(host, seek) {
    this.host = host;
    this.seek = seek;
    this.panels = [];
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

  draw(place) {
    for (const panel of this.panels) {
      panel.plot.draw(place);
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
    const close = head.appendChild(element("button", { type: "button", "aria-label": "Remove this diagram", title: "Remove" }, "×"));
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
      for (const one of members) group.append(new Option(one.name, one.name));
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
    panel.plot.show(motion, across, panel.lines, `${panel.y.replace(/^all /, "")} over ${panel.x}`);
    panel.shown = panel.lines.map(() => element("b"));
    panel.legend.replaceChildren(...panel.lines.map((one, k) => {
      const mark = element("i");
      mark.style.background = lineColour(k);
      return element("span", {}, mark, one.name, panel.shown[k]);
    }));
    const bands = !across && panel.lines.some((one) => one.bounds);
    const dots = across && panel.lines.some((one) => panel.plot.coarse(one));
    panel.note.textContent = bands ? "bands: least to largest" : dots ? "dots: frames only" : "";
    panel.note.hidden = !(bands || dots);
  }

  /** The cursor goes where the pointer is held. */
  follow(panel) {
    const { front } = panel.plot;
    const lead = (event) => {
      const box = front.getBoundingClientRect();
      this.seek(panel.plot.placeAt([event.clientX - box.left, event.clientY - box.top]));
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
