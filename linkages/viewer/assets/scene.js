/** A mechanism at one place of a motion: joints and angles, each computed once. */
class Scene {
  constructor(motion, place, bodies) {
    this.motion = motion;
    this.place = place;
    this.bodies = bodies;
    this.known = new Map();
    this.turned = new Map();
  }

  joint(name) {
    if (!this.known.has(name)) this.known.set(name, this.motion.joint(name, this.place));
    return this.known.get(name);
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
    if (!this.turned.has(name)) this.turned.set(name, this.found(this.bodies[name]));
    return this.turned.get(name);
  }

  found(body) {
    if (!body) return null;
    if (body.guide) {
      const carrier = this.angle(body.guide.body);
      return carrier === null ? null : carrier + body.guide.angle;
    }
    const series = this.motion.find("bar_angle", body.name);
    if (series) return this.motion.at(series, this.place);
    if (body.pair) {
      const [first, second, own] = body.pair;
      const a = this.joint(first), b = this.joint(second);
      return a && b ? Math.atan2(b[1] - a[1], b[0] - a[0]) - own : null;
    }
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
