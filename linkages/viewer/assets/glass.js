/** A clearance under a magnifying glass: journal, bearing and the force between them. */
const REVOLUTIONS = 3; // whose path is shown
const SECTORS = 72; // of the wall
const ROSE = 2.4; // radial clearances: the longest bar of the distribution of force

class Glass {
  /**
   * @param {object} contact {name, joint, bearing, size, force}
   * @param {number|null} period of drives and loads, a revolution
   */
  constructor(host, contact, period) {
    this.contact = contact;
    this.period = period;
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
    const { joint, bearing } = this.contact;
    this.between = termsOf(motion, { [joint]: 1 / size, [bearing]: -1 / size });
    this.rose = this.force && this.between ? this.distribution() : null;
  }

  /** From the centre of the bearing to that of the journal, in radial clearances. */
  offset(place) {
    const pin = this.motion.joint(this.contact.joint, place);
    const hole = this.motion.joint(this.contact.bearing, place);
    return pin && hole && [(pin[0] - hole[0]) / this.size, (pin[1] - hole[1]) / this.size];
  }

  /** The same at a frame. */
  frame(i) {
    let x = 0, y = 0;
    for (const [weight, xs, ys] of this.between) { x += weight * xs[i]; y += weight * ys[i]; }
    return [x, y];
  }

  /** Force on each sector of the wall, averaged over the time of the motion, in newtons. */
  distribution() {
    const { time } = this.motion, { values } = this.force, found = new Float64Array(SECTORS);
    for (let i = 0; i < time.length; i++) {
      const [x, y] = this.frame(i);
      const span = Math.abs(time[Math.min(i + 1, time.length - 1)] - time[Math.max(i - 1, 0)]) / 2;
      if (!(values[i] > 0) || !Number.isFinite(x + y)) continue;
      const turn = Math.atan2(y, x) / (2 * Math.PI);
      found[Math.floor((turn + 1) * SECTORS) % SECTORS] += values[i] * span;
    }
    return this.motion.duration ? found.map((sum) => sum / this.motion.duration) : found;
  }

  draw(place, camera, colours) {
    const side = this.canvas.clientWidth;
    if (!side) return;
    const ctx = fitted(this.canvas);
    ctx.clearRect(0, 0, side, side);
    this.drawOn(ctx, place, colours, side);
    const force = this.force ? this.motion.at(this.force, place) : NaN;
    this.write(force, (camera.scale * this.size) / (side / (2 * CONTENT.glass.reach)));
  }

  drawOn(ctx, place, colours, side) {
    const { pin, hole, wall, reach, longest } = CONTENT.glass;
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
    this.drawRose(ctx, [middle, middle], wall * unit, unit, colours);
    disc([middle, middle], wall, colours.pale, colours.bar);
    disc([middle, middle], hole, colours.paper, colours.ink);
    const at = this.offset(place);
    if (!at || !Number.isFinite(at[0] + at[1])) return;
    disc(spot(at), pin, colours.pale, colours.ink);
    this.drawPath(ctx, place, spot, colours);
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
  }

  /** Where the centre of the journal has been: the last revolutions, the last one darkest. */
  drawPath(ctx, place, spot, colours) {
    if (!this.between) return;
    const { motion } = this, last = Math.floor(place), now = motion.time[last];
    const turn = Math.min(this.period ?? Infinity, motion.duration);
    ctx.strokeStyle = colours.clearance;
    for (let k = REVOLUTIONS; k >= 1; k--) {
      const from = Math.ceil(motion.where(now - motion.sign * k * turn));
      const to = k > 1 ? Math.ceil(motion.where(now - motion.sign * (k - 1) * turn)) : last;
      if (from >= to) continue;
      ctx.globalAlpha = 0.15 + 0.25 * (REVOLUTIONS - k);
      ctx.lineWidth = k > 1 ? 0.7 : 1.1;
      ctx.beginPath();
      for (let i = from; i <= to; i++) ctx.lineTo(...spot(this.frame(i)));
      ctx.stroke();
    }
    ctx.globalAlpha = 1;
  }

  /** Bars outwards from the wall: where it carries how much of the force. */
  drawRose(ctx, [x, y], radius, unit, colours) {
    const most = this.rose ? Math.max(...this.rose) : 0;
    if (!(most > 0)) return;
    ctx.fillStyle = colours.load;
    ctx.globalAlpha = 0.45;
    this.rose.forEach((value, k) => {
      if (!value) return;
      const from = (-2 * Math.PI * (k + 0.92)) / SECTORS, to = (-2 * Math.PI * (k + 0.08)) / SECTORS;
      ctx.beginPath();
      ctx.arc(x, y, radius + (ROSE * unit * value) / most, from, to);
      ctx.lineTo(x, y);
      ctx.fill();
    });
    ctx.globalAlpha = 1;
  }

  write(force, reduction) {
    const { name, joint } = this.contact;
    const enlarged = figures(1 / reduction, 2);
    const value = Number.isFinite(force) && force ? quantity(force, "N", 3) : "";
    const state = force < 0 ? ", no contact" : force === 0 ? "no contact" : "";
    const rose = this.rose?.some((one) => one > 0) ? `<br><i></i>mean force on the wall` : "";
    const html = [`<b></b>`, ` ${enlarged}× larger`, `<br>`, `${value}${state}`, rose].join("");
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
