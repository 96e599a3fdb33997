/** A clearance under a magnifying glass: journal, bearing and the force between them. */
class Glass {
  /** @param {object} contact {name, joint, bearing, size, force} */
  constructor(host, contact) {
    this.contact = contact;
    const figure = document.createElement("figure");
    this.canvas = figure.appendChild(document.createElement("canvas"));
    this.caption = figure.appendChild(document.createElement("figcaption"));
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", `Journal in its bearing at ${contact.joint}, enlarged`);
    host.append(figure);
    this.figure = figure;
  }

  show(motion, size) {
    this.motion = motion;
    this.size = size;
    this.force = motion.byName.get(this.contact.force);
    this.full = this.force ? fullLength(Array.from(this.force.values, Math.abs)) : 0;
  }

  /** From the centre of the bearing to that of the journal, in radial clearances. */
  offset(place) {
    const pin = this.motion.joint(this.contact.joint, place);
    const hole = this.motion.joint(this.contact.bearing, place);
    return pin && hole && [(pin[0] - hole[0]) / this.size, (pin[1] - hole[1]) / this.size];
  }

  draw(place, camera, colours) {
    const { pin, hole, wall, reach, longest } = CONTENT.glass;
    const side = this.canvas.clientWidth, ctx = fitted(this.canvas);
    if (!side) return;
    const unit = side / (2 * reach), middle = side / 2;
    const spot = ([x, y]) => [middle + x * unit, middle - y * unit];
    const disc = ([x, y], radius, fill, edge) => {
      ctx.beginPath();
      ctx.arc(x, y, radius * unit, 0, 2 * Math.PI);
      ctx.fillStyle = fill;
      ctx.fill();
      ctx.strokeStyle = edge;
      ctx.lineWidth = 1;
      ctx.stroke();
    };
    ctx.clearRect(0, 0, side, side);
    disc([middle, middle], wall, colours.pale, colours.bar);
    disc([middle, middle], hole, colours.paper, colours.ink);
    const at = this.offset(place);
    if (!at || !Number.isFinite(at[0] + at[1])) return;
    disc(spot(at), pin, colours.pale, colours.ink);
    this.trail(ctx, place, spot, colours);
    ctx.strokeStyle = ctx.fillStyle = colours.clearance;
    ctx.lineWidth = 1.6;
    ctx.beginPath();
    ctx.moveTo(middle, middle);
    ctx.lineTo(...spot(at));
    ctx.stroke();
    for (const [x, y] of [[middle, middle], spot(at)]) {
      ctx.beginPath();
      ctx.arc(x, y, 2.2, 0, 2 * Math.PI);
      ctx.fill();
    }
    const force = this.force ? this.motion.at(this.force, place) : NaN;
    const far = Math.hypot(...at);
    if (this.full && Number.isFinite(force) && far > 1e-9) {
      const way = [at[0] / far, at[1] / far], length = longest * clip(force / this.full);
      const colour = force < 0 ? colours.ink : colours.load;
      drawArrow(ctx, spot([hole * way[0], hole * way[1]]),
        [way[0] * length * unit, -way[1] * length * unit], colour);
    }
    this.write(force, (camera.scale * this.size) / unit);
  }

  /** Where the journal has just been. */
  trail(ctx, place, spot, colours) {
    const last = Math.floor(place), first = Math.max(0, last - 30);
    ctx.strokeStyle = colours.clearance;
    ctx.lineWidth = 1.2;
    for (let i = first; i < last; i++) {
      const a = this.offset(i), b = this.offset(i + 1);
      if (!a || !b) continue;
      ctx.globalAlpha = (0.5 * (i - first)) / 30;
      ctx.beginPath();
      ctx.moveTo(...spot(a));
      ctx.lineTo(...spot(b));
      ctx.stroke();
    }
    ctx.globalAlpha = 1;
  }

  write(force, reduction) {
    const { name, joint } = this.contact;
    const enlarged = figures(1 / reduction, 2);
    const value = Number.isFinite(force) && force ? quantity(force, "N", 3) : "";
    const state = force < 0 ? ", no contact" : value ? "" : "no contact";
    const html = [`<b></b>`, ` ${enlarged}× larger`, `<br>`, `${value}${state}`].join("");
    if (this.caption.innerHTML !== html) this.caption.innerHTML = html;
    this.caption.firstChild.textContent = `${name} at ${joint}`;
  }
}

/** The context of a canvas that has as many pixels as the screen. */
function fitted(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  const ctx = canvas.getContext("2d");
  ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
  return ctx;
}
