"""Bodies by their centres of mass, what holds them together, and which points have a clearance.

Coordinates are x, y and θ of every body in turn. A joint where more than two bodies meet pins all
of them to the first; a clearance takes one of them out.
"""

import math
from collections.abc import Collection, Sequence

import numpy as np
from absolute_bodies import pair as local
from absolute_bodies import turned
from absolute_gaps import Gap
from kernel_values import at_start
from time_functions import jet

from linkages import Mechanism

Ends = tuple[int, np.ndarray, int, np.ndarray]


class Bodies:
    """Masses, points and constraints of an ideal mechanism, less what clearances leave open.

    Sliders that are `loose` have no guide here, and turn.
    """

    def __init__(
        self, mechanism: Mechanism, gaps: Sequence[Gap], loose: Collection[str] = ()
    ) -> None:
        self.mechanism, self.gaps, self.loose = mechanism, gaps, loose
        self.names = list(mechanism.bodies)
        self.size = 3 * len(self.names)
        self.drives = [(self.names.index(n), t.law) for n, t in mechanism.prescribed.items()]
        self._inertia()
        self._guides()
        self._join()
        self._constant_rows()

    def _inertia(self) -> None:
        """Mass, centre and moment of every body, masses at joints included."""
        bodies = self.mechanism.bodies
        parts = {
            name: [(body.mass.value, local(body.centre), body.inertia.value)]
            for name, body in bodies.items()
        }
        for term in self.mechanism.point_masses:
            carrier = self.mechanism.carrier(term.joint)
            if carrier is not None:
                place = local(bodies[carrier].points[term.joint])
                parts[carrier].append((term.mass.value, place, 0.0))
        self.centres, masses = {}, []
        for name, body in bodies.items():
            mass = sum(m for m, _, _ in parts[name])
            centre = sum(m * place for m, place, _ in parts[name]) / mass
            moment = sum(j + m * np.sum((place - centre) ** 2) for m, place, j in parts[name])
            self.centres[name] = centre
            # a guided body does not turn, whatever its moment
            masses += [mass, mass, moment if body.rotates or name in self.loose else 1.0]
        self.masses = np.array(masses)

    def _guides(self) -> None:
        """Sliders: body → (point of the axis, angle of the axis)."""
        self.guides: dict[int, tuple[np.ndarray, float]] = {}
        for index, (name, body) in enumerate(self.mechanism.bodies.items()):
            if body.guide is not None and name not in self.loose:
                assert body.guide.body is None, f"{name} slides on a body: not for this oracle"
                assert np.allclose(self.centres[name], 0), f"{name} is not uniform"
                self.guides[index] = local(body.guide.origin), body.guide.angle.value

    def _join(self) -> None:
        """Pairs of points that coincide, then those of clearances, which do not."""
        points: dict[str, list[tuple[int, np.ndarray]]] = {
            joint: [(-1, local(place))] for joint, place in self.mechanism.ground.items()
        }
        displaced = {(gap.joint, gap.bar): index for index, gap in enumerate(self.gaps)}
        ends: dict[int, tuple[int, np.ndarray]] = {}
        for index, (name, body) in enumerate(self.mechanism.bodies.items()):
            for joint, place in body.points.items():
                point = (index, local(place) - self.centres[name])
                if (joint, name) in displaced:
                    ends[displaced[joint, name]] = point
                else:
                    points.setdefault(joint, []).append(point)
        pins = [(*first, *other) for first, *others in points.values() for other in others]
        open_ = [(*points[gap.joint][0], *ends[k]) for k, gap in enumerate(self.gaps)]
        self.pins = len(pins)
        sides = [side for ends in (*pins, *open_) for side in (ends[:2], ends[2:])]
        self.owner = np.array([body for body, _ in sides])
        self.moving = self.owner >= 0
        self.local = np.array([place for _, place in sides]).reshape(-1, 2)

    def _constant_rows(self) -> None:
        """Φ_q without what turns with the bodies: pins, guides, angles of guides, drives."""
        pins = self._difference(range(self.pins))
        across = [self._axis_row(body, math.pi / 2) for body in self.guides]
        turns = [self._unit(3 * body + 2) for body in self.guides]
        driven = [self._coordinate_row(body) for body, _ in self.drives]
        self.constant = np.concatenate([pins, *(row[None] for row in (*across, *turns, *driven))])
        self.rows = len(self.constant)

    def _unit(self, entry: int) -> np.ndarray:
        row = np.zeros(self.size)
        row[entry] = 1
        return row

    def _axis_row(self, body: int, offset: float = 0.0) -> np.ndarray:
        row, angle = np.zeros(self.size), self.guides[body][1] + offset
        row[3 * body : 3 * body + 2] = math.cos(angle), math.sin(angle)
        return row

    def _coordinate_row(self, body: int) -> np.ndarray:
        return self._axis_row(body) if body in self.guides else self._unit(3 * body + 2)

    def coordinate(self, name: str) -> tuple[np.ndarray, float]:
        """Row and constant of an angle or of a displacement along an axis: row·q − constant."""
        body = self.names.index(name)
        row = self._coordinate_row(body)
        if body not in self.guides:
            return row, 0.0
        return row, float(row[3 * body : 3 * body + 2] @ self.guides[body][0])

    def _difference(self, pairs: Sequence[int], arms: np.ndarray | None = None) -> np.ndarray:
        """∂(second − first)/∂q of pairs of points, two rows each; of the arms' turning if given."""
        rows = np.zeros((2 * len(pairs), self.size))
        for k, pair in enumerate(pairs):
            for point, sign in ((2 * pair, -1.0), (2 * pair + 1, 1.0)):
                body = self.owner[point]
                if body >= 0:
                    rows[2 * k : 2 * k + 2, 3 * body : 3 * body + 2] += sign * np.eye(2)
                    if arms is not None:
                        x, y = arms[:, point]
                        rows[2 * k : 2 * k + 2, 3 * body + 2] += sign * -y, sign * x
        return rows

    def arms(self, q: np.ndarray) -> np.ndarray:
        """From centres of mass to points, ground axes; of the ground, from its origin."""
        angle = np.where(self.moving, q[3 * self.owner + 2], 0.0)
        c, s = np.cos(angle), np.sin(angle)
        x, y = self.local.T
        return np.array([c * x - s * y, s * x + c * y])

    def placed(self, q: np.ndarray, arms: np.ndarray) -> np.ndarray:
        """Positions of all points, shape (2, points)."""
        return arms + np.where(self.moving, [q[3 * self.owner], q[3 * self.owner + 1]], 0.0)

    def moved(self, v: np.ndarray, arms: np.ndarray) -> np.ndarray:
        """Velocities of all points."""
        x, y, spin = (v[3 * self.owner + part] for part in range(3))
        return np.where(self.moving, [x - spin * arms[1], y + spin * arms[0]], 0.0)

    def between(self, values: np.ndarray) -> np.ndarray:
        """Displaced ends less pins, shape (clearances, 2)."""
        first = 2 * self.pins
        return (values[:, first + 1 :: 2] - values[:, first::2]).T

    def closure(self, t: float, q: np.ndarray) -> np.ndarray:
        """Φ."""
        places = self.placed(q, self.arms(q))[:, : 2 * self.pins]
        gaps = (places[:, 1::2] - places[:, 0::2]).T.ravel()
        wanted = [
            self._axis_row(body, math.pi / 2)[3 * body : 3 * body + 2] @ origin
            for body, (origin, _) in self.guides.items()
        ]
        wanted += [angle for _, angle in self.guides.values()]
        wanted += [
            jet(law, t)[0] + self.coordinate(self.names[body])[1] for body, law in self.drives
        ]
        return np.concatenate([gaps, self.constant[2 * self.pins :] @ q - wanted])

    def prescribed(self, t: float, order: int) -> np.ndarray:
        """Time derivatives of what drives prescribe, zero for all other constraints."""
        values = np.zeros(self.rows)
        for k, (_, law) in enumerate(self.drives):
            values[self.rows - len(self.drives) + k] = jet(law, t)[order]
        return values

    def jacobian(self, arms: np.ndarray) -> np.ndarray:
        """Φ_q."""
        phi = self.constant.copy()
        for point, body in enumerate(self.owner[: 2 * self.pins]):
            if body >= 0:
                row, sign = 2 * (point // 2), 1.0 if point % 2 else -1.0
                phi[row, 3 * body + 2] -= sign * arms[1, point]
                phi[row + 1, 3 * body + 2] += sign * arms[0, point]
        return phi

    def convective(self, t: float, v: np.ndarray, arms: np.ndarray) -> np.ndarray:
        """γ in Φ_q q̈ = γ."""
        bias = -(np.where(self.moving, v[3 * self.owner + 2], 0.0) ** 2) * arms
        gamma = self.prescribed(t, 2)
        pinned = bias[:, : 2 * self.pins]
        gamma[: 2 * self.pins] += (pinned[:, 0::2] - pinned[:, 1::2]).T.ravel()
        return gamma

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates at t = 0: free coordinates and offsets as the definition says.

        Where the ideal mechanism stands is only where Newton's method starts.
        """
        found, q = at_start(self.mechanism), np.zeros(self.size)
        for k, (name, body) in enumerate(self.mechanism.bodies.items()):
            joint, place = next(iter(body.points.items()))
            angle = body.guide.angle.value if body.guide else found["bar_angle"][name]
            q[3 * k : 3 * k + 2] = found["joint_position"][joint]
            q[3 * k : 3 * k + 2] += turned(angle, self.centres[name] - local(place))
            q[3 * k + 2] = angle
        free = [self.coordinate(name)[0] for name in self.mechanism.initial]
        held = [row @ q for row in free]  # angles may count whole turns
        for _ in range(8):
            arms = self.arms(q)
            off = (self.between(self.placed(q, arms)) - [gap.offset for gap in self.gaps]).ravel()
            moved = [row @ q - value for row, value in zip(free, held, strict=True)]
            q = q - np.linalg.solve(
                self._square(arms, free), np.concatenate([self.closure(0.0, q), off, moved])
            )
        speeds = [given.speed for given in self.mechanism.initial.values()]
        rates = np.ravel([gap.rate for gap in self.gaps])
        right = np.concatenate([self.prescribed(0.0, 1), rates, speeds])
        return q, np.linalg.solve(self._square(self.arms(q), free), right)

    def _square(self, arms: np.ndarray, free: list[np.ndarray]) -> np.ndarray:
        """Φ_q over the Jacobians of offsets and free coordinates."""
        count = len(self.gaps)
        open_ = self._difference(range(self.pins, self.pins + count), arms)
        return np.concatenate([self.jacobian(arms), open_, *(row[None] for row in free)])
