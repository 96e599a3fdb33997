/** All series at the present time, in a table that can be searched. */
class Values {
  constructor(host) {
    this.search = element("input", {
      type: "search", placeholder: "Search: crank, force, …", "aria-label": "Search the values",
    });
    this.table = element("table");
    host.append(this.search, this.table);
    this.host = host;
    this.search.addEventListener("input", () => this.filter());
  }

  show(motion) {
    this.motion = motion;
    this.stale = true;
    changed();
  }

  /** The rows are made when they are first seen. */
  build() {
    const { motion } = this;
    this.stale = false;
    this.rows = [];
    const body = element("tbody");
    let variable = "";
    for (const series of motion.series) {
      if (series.variable !== variable) {
        variable = series.variable;
        const head = element("tr", { class: "group" }, element("th", { colspan: "3", scope: "colgroup" }, series.label));
        body.append(head);
        this.rows.push({ row: head, variable });
      }
      const scale = scaleFor(Math.max(...motion.range(series).map(Math.abs)), series.unit);
      const value = element("td", { class: "value" });
      const name = element("th", { scope: "row", title: series.name }, ownerOf(series) || series.words);
      name.style.fontWeight = 400;
      const row = element("tr", {}, name, value, element("td", { class: "unit" }, scale.text));
      body.append(row);
      this.rows.push({ row, series, value, scale, text: `${series.name} ${series.words}`.toLowerCase() });
    }
    this.table.replaceChildren(body);
    this.filter();
  }

  filter() {
    if (this.stale) return;
    const words = this.search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const full = new Set();
    for (const { row, series, text } of this.rows) {
      if (!series) continue;
      row.hidden = !words.every((word) => text.includes(word));
      if (!row.hidden) full.add(series.variable);
    }
    for (const { row, variable } of this.rows) if (variable) row.hidden = !full.has(variable);
    changed();
  }

  draw(place) {
    if (this.host.hidden) return;
    if (this.stale) this.build();
    for (const { row, series, value, scale } of this.rows) {
      if (series && !row.hidden) value.textContent = steady(this.motion.at(series, place) * scale.factor);
    }
  }
}
