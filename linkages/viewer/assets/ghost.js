/** How far a mechanism is from the same one without clearances, enlarged so that it is seen. */
const SEEN = 0.06; // of the picture: the largest deviation that is drawn

class Ghost {
  constructor(motion, aliases) {
    this.motion = motion;
    this.aliases = aliases; // joint at the bearing → its joint
  }

  joint(name, t) {
    return this.motion.joint(this.aliases[name] ?? name, this.motion.where(t));
  }

  /** How many times deviations of a motion are enlarged: 1, 2 or 5 times a power of ten. */
  enlargement(motion, size) {
    let most = 0;
    for (let i = 0; i < this.motion.time.length; i += 4) {
      const t = this.motion.time[i], place = motion.where(t);
      for (const name of motion.joints) {
        const a = motion.joint(name, place), b = this.joint(name, t);
        if (a && b) most = Math.max(most, Math.hypot(a[0] - b[0], a[1] - b[1]));
      }
    }
    return most ? Math.max(1, niceBelow((SEEN * size) / most)) : 1;
  }
}

/** The ideal mechanism at the time of a scene. */
class GhostScene extends Scene {
  constructor(scene, ghost) {
    super(scene.motion, scene.place, scene.bodies);
    this.ghost = ghost;
    this.time = timeAt(scene);
  }

  joint(name) {
    if (!this.known.has(name)) this.known.set(name, this.ghost.joint(name, this.time));
    return this.known.get(name);
  }

  found(body) {
    return body && !body.guide && !body.pair && !body.follows ? null
      : body && body.pair ? pairAngle(this, body) : super.found(body);
  }
}

/** A mechanism whose deviation from the ideal one is enlarged. */
class EnlargedScene extends Scene {
  constructor(scene, ghost, factor) {
    super(scene.motion, scene.place, scene.bodies);
    this.ghost = ghost;
    this.factor = factor;
    this.time = timeAt(scene);
  }

  joint(name) {
    if (this.known.has(name)) return this.known.get(name);
    const own = super.joint(name), ideal = this.ghost.joint(name, this.time);
    if (own && ideal) {
      this.known.set(name, own.map((value, k) => ideal[k] + this.factor * (value - ideal[k])));
    }
    return this.known.get(name);
  }

  found(body) {
    return body && body.pair ? pairAngle(this, body) : super.found(body);
  }
}

function pairAngle(scene, { pair: [first, second, own] }) {
  const a = scene.joint(first), b = scene.joint(second);
  return a && b ? Math.atan2(b[1] - a[1], b[0] - a[0]) - own : null;
}

function timeAt({ motion, place }) {
  const i = Math.floor(place), { time } = motion;
  return i + 1 < time.length ? time[i] + (place - i) * (time[i + 1] - time[i]) : time[i];
}
