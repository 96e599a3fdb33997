/** The motion of another page beside this one, on the same clock; in diagrams if it has the same bodies. */
class Compare {
  constructor(page) {
    this.page = page;
    const get = (id) => document.getElementById(id);
    this.view = get("view");
    this.file = get("other");
    this.file.addEventListener("change", () => {
      const [file] = this.file.files;
      this.file.value = "";
      if (file) this.open(file);
    });
    this.close = get("close-other");
    this.close.addEventListener("click", () => this.end());
  }

  /** Show the motion of a page; its scripts stay what they are, text. */
  async open(file) {
    let found;
    try {
      found = await otherMotion(await file.text());
    } catch {
      this.page.message(`${file.name} is no page of a motion. Choose a file that view has written.`);
      return;
    }
    this.end();
    const canvas = element("canvas", { id: "second", role: "img", "aria-label": `The mechanism of ${file.name}` });
    const glasses = element("div", { class: "glasses" });
    this.view.append(canvas, glasses);
    this.view.classList.add("two");
    const stage = new Stage(canvas, glasses, found.content), { clearances } = found.content.mechanism;
    stage.show(found.motion, null, Object.fromEntries(clearances.map((one) => [one.name, one.size])), new Map());
    const bodies = ({ mechanism }) => mechanism.bodies.map((body) => body.name).join();
    this.page.second = { stage, canvas, glasses, motion: bodies(found.content) === bodies(CONTENT) ? found.motion : null };
    this.page.message("");
    document.getElementById("other-name").textContent = found.content.mechanism.name === CONTENT.mechanism.name
      ? file.name : found.content.mechanism.name;
    this.close.parentElement.hidden = false;
    this.page.curves(this.page.panels.motion);
    changed();
  }

  end() {
    const { second } = this.page;
    if (!second) return;
    second.canvas.remove();
    second.glasses.remove();
    this.view.classList.remove("two");
    this.close.parentElement.hidden = true;
    this.page.second = null;
    this.page.curves(this.page.panels.motion);
    changed();
  }
}

/** {content, motion} of the text of a page; it throws where there is none. */
async function otherMotion(text) {
  const found = new DOMParser().parseFromString(text, "text/html").getElementById("content");
  const content = JSON.parse(found.textContent);
  for (const [name, one] of Object.entries(content.series)) one.words ??= name; // pages of earlier versions
  const motion = recordedMotion(content, await unpacked(content.numbers));
  if (!(motion.time.length > 0) || !motion.joints.length) throw new Error("no motion");
  return { content, motion };
}
