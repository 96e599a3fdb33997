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
    super(scene.motion, scene.place, scene.parts);
    this.ghost = ghost;
    this.time = timeAt(scene);
  }

  moved(name) { return this.ghost.joint(name, this.time); }

  found(body) {
    if (body?.pair) return pairAngle(this, body);
    return body?.guide || body?.follows ? super.found(body) : null;
  }
}

/** A mechanism whose deviation from the ideal one is enlarged. */
class EnlargedScene extends Scene {
  constructor(scene, ghost, factor) {
    super(scene.motion, scene.place, scene.parts);
    this.ghost = ghost;
    this.factor = factor;
    this.time = timeAt(scene);
  }

  moved(name) {
    const own = super.moved(name), ideal = this.ghost.joint(name, this.time);
    return own && ideal ? own.map((value, k) => ideal[k] + this.factor * (value - ideal[k])) : own;
  }
}

function timeAt({ motion, place }) {
  const i = Math.floor(place), { time } = motion;
  return i + 1 < time.length ? time[i] + (place - i) * (time[i + 1] - time[i]) : time[i];
}
