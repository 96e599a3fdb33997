/** A mechanism at one place of a motion: joints and angles, each computed once. */
class Scene {
  /** @param {object} parts {bodies, places} as `partsOf` has them */
  constructor(motion, place, parts) {
    this.motion = motion;
    this.place = place;
    this.parts = parts;
    this.known = new Map();
    this.turned = new Map();
  }

  /** Where a joint is, or a place on an axis. */
  joint(name) {
    if (!this.known.has(name)) {
      const on = this.parts.places[name];
      this.known.set(name, on ? this.onAxis(on) : this.moved(name));
    }
    return this.known.get(name);
  }

  moved(name) { return this.motion.joint(name, this.place); }

  /** A displacement along the axis of a slider. */
  onAxis({ slider, reach }) {
    const { guide } = this.parts.bodies[slider], along = this.angle(slider);
    let [x, y] = guide.origin;
    if (guide.body !== null) {
      const from = this.joint(guide.joint), turned = this.angle(guide.body);
      if (!from || turned === null) return null;
      const u = x - guide.own[0], v = y - guide.own[1];
      x = from[0] + Math.cos(turned) * u - Math.sin(turned) * v;
      y = from[1] + Math.sin(turned) * u + Math.cos(turned) * v;
    }
    return along === null ? null : [x + reach * Math.cos(along), y + reach * Math.sin(along)];
  }

  /** A weighted mean of joints, {joint: weight}; null if one is not known. */
  mean(weights) {
    let x = 0, y = 0;
    for (const name in weights) {
      const at = this.joint(name);
      if (!at) return null;
      x += weights[name] * at[0];
      y += weights[name] * at[1];
    }
    return [x, y];
  }

  /** How a body is turned; null if that cannot be told. The ground is no body. */
  angle(name) {
    if (name === null) return 0;
    if (!this.turned.has(name)) this.turned.set(name, this.found(this.parts.bodies[name]));
    return this.turned.get(name);
  }

  found(body) {
    if (!body) return null;
    if (body.guide) {
      const carrier = this.angle(body.guide.body);
      return carrier === null ? null : carrier + body.guide.angle;
    }
    const found = body.pair && pairAngle(this, body);
    if (found !== null) return found;
    const series = this.motion.find("bar_angle", body.name);
    if (series) return this.motion.at(series, this.place);
    if (!body.follows) return null;
    let sum = body.follows.offset;
    for (const [other, ratio] of body.follows.parts) {
      const angle = this.angle(other);
      if (angle === null) return null;
      sum += ratio * angle;
    }
    return sum;
  }

  /** The direction of a shape, in radians. */
  direction({ angle, ends, body }) {
    let found = angle;
    if (ends) {
      const first = this.mean(ends[0]), second = this.mean(ends[1]);
      if (!first || !second) return null;
      found += Math.atan2(second[1] - first[1], second[0] - first[0]);
    }
    if (body !== null) {
      const turned = this.angle(body);
      if (turned === null) return null;
      found += turned;
    }
    return found;
  }

  /** Where an anchor is, in pixels. */
  anchor([weights, along, across, pointsAlong, pointsAcross], angle, camera, point) {
    const at = this.mean(weights);
    if (!at) return null;
    const [x, y] = camera.place(at), cos = Math.cos(angle), sin = Math.sin(angle);
    const u = along * camera.scale + pointsAlong * point;
    const v = across * camera.scale + pointsAcross * point;
    return [x + cos * u - sin * v, y - sin * u - cos * v];
  }
}

/** How a body is turned by the two joints that are farthest apart on it. */
function pairAngle(scene, { pair: { joints: [first, second], own } }) {
  const a = scene.joint(first), b = scene.joint(second);
  return a && b ? Math.atan2(b[1] - a[1], b[0] - a[0]) - own : null;
}

/**
 * Bodies and places on axes of a motion, with numbers as they are: `given` has those that are not
 * as the page was written with, by their paths.
 */
function partsOf(motion, given, content) {
  const value = ([own, path]) => given.get(path) ?? own;
  const bodies = Object.fromEntries(content.mechanism.bodies.map((body) => {
    const { guide, pair, follows } = body, found = { ...body };
    if (guide) {
      found.guide = { ...guide, angle: value(guide.angle), origin: guide.origin?.map(value), own: guide.own?.map(value) };
    }
    if (pair) {
      const [[ax, ay], [bx, by]] = pair.places.map((place) => place.map(value));
      found.pair = { joints: pair.joints, own: Math.atan2(by - ay, bx - ax) };
    }
    if (follows) {
      found.follows = { offset: value(follows.offset), parts: follows.parts.map(([name, ratio]) => [name, value(ratio)]) };
    }
    return [body.name, found];
  }));
  const places = Object.fromEntries(Object.entries(content.places).map(([name, { slider, at }]) => {
    const [low, high] = typeof at === "number" ? [at, at] : motion.range(motion.find("slider_position", slider));
    return [name, { slider, reach: at === "high" ? high : low }];
  }));
  return { bodies, places };
}
