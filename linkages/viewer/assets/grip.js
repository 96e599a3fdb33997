/** Links by which the mechanism can be held and led along its motion. */
const NEAR = { joint: 20, link: 12 }; // pixels
const FAITHFUL = 0.02; // of the picture: a detour that staying close in time is worth

class Grip {
  constructor(stage) { this.stage = stage; }

  /** What is under a place in pixels: a point of a body by its joints, or null. */
  under(place, at) {
    const { stage } = this, scene = stage.scene(place);
    let found = null, least = Infinity;
    for (const body of CONTENT.mechanism.bodies) {
      const names = body.joints.filter((name) => scene.joint(name));
      for (const name of names) {
        if (!stage.moving.includes(name)) continue;
        const distance = apart(stage.camera.place(scene.joint(name)), at);
        if (distance < NEAR.joint && distance < least) {
          [found, least] = [{ body, weights: { [name]: 1 } }, distance];
        }
      }
      if (least < NEAR.joint) continue;
      for (let i = 0; i < names.length; i++) {
        for (let k = i + 1; k < names.length; k++) {
          const [a, b] = [names[i], names[k]];
          if (!stage.moving.includes(a) && !stage.moving.includes(b)) continue;
          const { distance, part } = toSegment(at, stage.camera.place(scene.joint(a)),
            stage.camera.place(scene.joint(b)));
          if (distance < NEAR.link && distance + NEAR.joint < least) {
            [found, least] = [{ body, weights: { [a]: 1 - part, [b]: part } },
              distance + NEAR.joint];
          }
        }
      }
    }
    return found ?? this.within(scene, at);
  }

  /** A point of a plate, by three of its joints; or null. */
  within(scene, at) {
    for (const body of CONTENT.mechanism.bodies) {
      const names = body.joints.filter((name) => scene.joint(name));
      if (names.length < 3 || !names.some((name) => this.stage.moving.includes(name))) continue;
      for (let i = 0; i < names.length; i++) for (let j = i + 1; j < names.length; j++) for (let k = j + 1; k < names.length; k++) {
        const three = [names[i], names[j], names[k]];
        const weights = inTriangle(at, three.map((name) => this.stage.camera.place(scene.joint(name))));
        if (weights) return { body, weights: Object.fromEntries(three.map((name, n) => [name, weights[n]])) };
      }
    }
    return null;
  }

  /** The place of the motion at which the held point is nearest to a point of the plane. */
  nearest(held, target, from) {
    const { motion, camera } = this.stage;
    const [left, low, right, high] = camera.box;
    const size = Math.max(right - left, high - low), count = motion.time.length;
    const terms = Object.entries(held.weights).map(([joint, weight]) => [weight,
      motion.find("joint_position", joint, "x").values,
      motion.find("joint_position", joint, "y").values]);
    let best = from, least = Infinity;
    for (let i = 0; i < count; i++) {
      let x = -target[0], y = -target[1];
      for (const [weight, xs, ys] of terms) { x += weight * xs[i]; y += weight * ys[i]; }
      const detour = (FAITHFUL * size * (i - from)) / count;
      const cost = x * x + y * y + detour * detour;
      if (cost < least) [best, least] = [i, cost];
    }
    return this.between(held, target, best);
  }

  /** The same between frames. */
  between(held, target, i) {
    const { motion, parts } = this.stage, last = motion.time.length - 1;
    const at = (k) => new Scene(motion, k, parts).mean(held.weights);
    let found = i, least = apart(at(i), target);
    for (const k of [i - 1, i]) {
      if (k < 0 || k >= last) continue;
      const { distance, part } = toSegment(target, at(k), at(k + 1));
      if (distance < least) [found, least] = [k + part, distance];
    }
    return found;
  }
}

/** Weights of the corners that give a point of a triangle; null outside. */
function inTriangle([x, y], [[ax, ay], [bx, by], [cx, cy]]) {
  const area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
  const b = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area;
  const c = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area;
  return b >= 0 && c >= 0 && b + c <= 1 ? [1 - b - c, b, c] : null;
}

function apart([a, b], [c, d]) { return Math.hypot(a - c, b - d); }

/** How far a point is from a segment, and at which part of it the nearest one lies. */
function toSegment(point, a, b) {
  const way = [b[0] - a[0], b[1] - a[1]], square = way[0] ** 2 + way[1] ** 2;
  const along = (point[0] - a[0]) * way[0] + (point[1] - a[1]) * way[1];
  const part = square ? Math.min(1, Math.max(0, along / square)) : 0;
  return { distance: apart(point, [a[0] + part * way[0], a[1] + part * way[1]]), part };
}
