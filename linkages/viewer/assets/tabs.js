/** Tabs at the side, led by arrow keys as well. */
class Tabs {
  constructor(host, names) {
    this.host = host;
    this.buttons = Object.entries(names).map(([id, text]) => {
      const button = element("button", { type: "button", role: "tab", id: `tab-${id}`, "aria-controls": id }, text);
      button.addEventListener("click", () => this.open(id));
      return [id, button];
    });
    host.append(...this.buttons.map(([, button]) => button));
    host.addEventListener("keydown", (event) => this.key(event));
    this.open(this.buttons[0][0]);
  }

  open(chosen) {
    this.chosen = chosen;
    for (const [id, button] of this.buttons) {
      button.setAttribute("aria-selected", String(id === chosen));
      button.tabIndex = id === chosen ? 0 : -1;
      document.getElementById(id).hidden = id !== chosen;
    }
    changed();
  }

  key(event) {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    const at = this.buttons.findIndex(([id]) => id === this.chosen), count = this.buttons.length;
    const [id, button] = this.buttons[(at + step + count) % count];
    this.open(id);
    button.focus();
  }
}
