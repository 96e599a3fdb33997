"""An independent formulation of contact in clearances: centres of mass, multipliers, legs.

Every body has three coordinates, those of its centre of mass and its angle; every ideal joint,
guide and drive is a constraint. With the diagonal mass matrix M, M q̈ + Φ_qᵀ λ = Q and Φ_q q̈ = γ give
λ from Φ_q M⁻¹ Φ_qᵀ. A clearance constrains nothing: its force follows from where the two centres
are. SciPy's DOP853 integrates legs between touches, leaves and slacks; at their ends coordinates
are put back onto the constraints. Neither coordinates nor formulas are those of the kernel.
"""

import math
from dataclasses import dataclass

import numpy as np
from absolute_gaps import CONTACT, FREE, Gap, taken_apart
from kernel_values import at_start
from time_functions import jet

import linkages
from linkages.components.contributed.measures import Slide, Turn


@dataclass
class Mode:
    """What a clearance remembers: its state and the rate of its last touch."""

    state: str = FREE
    first: float = math.nan


class AbsoluteContact:
    """Equations of a definition with contact in its clearances.

    A vector y holds x, y and θ of every body in turn, their rates, and what was lost along the
    normals, lost by friction, and done by drives and loads (J).
    """

    def __init__(self, definition: str) -> None:
        ideal, self.gaps = taken_apart(definition)
        self.mechanism = mechanism = linkages.loads(ideal)
        self.names = list(mechanism.bodies)
        self.size = 3 * len(self.names)
        self._inertia()
        self.pairs: list[tuple[int, np.ndarray, int, np.ndarray]] = []
        self.apart: list[tuple[int, np.ndarray, int, np.ndarray]] = []
        self._join()
        self._guides()
        self.drives = [
            (self.names.index(name), term.law) for name, term in mechanism.prescribed.items()
        ]
        self._arrays()

    def _inertia(self) -> None:
        """Mass, centre and moment of every body, masses at joints included."""
        bodies = self.mechanism.bodies
        added = {name: [] for name in bodies}
        for term in self.mechanism.point_masses:
            carrier = self.mechanism.carrier(term.joint)
            if carrier is not None:
                place = local(bodies[carrier].points[term.joint])
                added[carrier].append((term.mass.value, place, 0.0))
        self.centres, masses = {}, []
        for name, body in bodies.items():
            parts = [(body.mass.value, local(body.centre), body.inertia.value), *added[name]]
            mass = sum(m for m, _, _ in parts)
            centre = sum(m * place for m, place, _ in parts) / mass
            moment = sum(j + m * np.sum((place - centre) ** 2) for m, place, j in parts)
            self.centres[name] = centre
            # a guided body does not turn, whatever its moment
            masses += [mass, mass, moment if body.rotates else 1.0]
        self.masses = np.array(masses)
        gravity = self.mechanism.gravity
        self.weight = np.zeros(self.size)
        self.weight[0::3] = self.masses[0::3] * gravity.x.value
        self.weight[1::3] = self.masses[1::3] * gravity.y.value

    def _join(self) -> None:
        """Pairs of points that coincide, and those of clearances, which do not."""
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
        for first, *others in points.values():
            self.pairs += [(*first, *other) for other in others]
        for index, gap in enumerate(self.gaps):
            self.apart.append((*points[gap.joint][0], *ends[index]))

    def _guides(self) -> None:
        """Sliders on the ground: (body, point of the axis, its direction)."""
        self.guides = []
        for index, (name, body) in enumerate(self.mechanism.bodies.items()):
            if body.guide is not None:
                assert body.guide.body is None, f"{name} slides on a body: not for this oracle"
                angle = body.guide.angle.value
                self.guides.append((index, local(body.guide.origin), angle))
                assert np.allclose(self.centres[name], 0), f"{name} is not uniform"

    def _arrays(self) -> None:
        ends = [(b, p) for pair in (*self.pairs, *self.apart) for b, p in (pair[:2], pair[2:])]
        self.owner = np.array([body for body, _ in ends])
        self.moving = self.owner >= 0
        self.local = np.array([place for _, place in ends]).reshape(-1, 2)
        pins, guides = 2 * len(self.pairs), len(self.guides)
        self.rows = pins + 2 * guides + len(self.drives)
        self.constant = np.zeros((self.rows, self.size))
        for k, (first, _, second, _) in enumerate(self.pairs):
            for axis in (0, 1):
                if first >= 0:
                    self.constant[2 * k + axis, 3 * first + axis] -= 1
                if second >= 0:
                    self.constant[2 * k + axis, 3 * second + axis] += 1
        for k, (body, _, angle) in enumerate(self.guides):
            row = pins + 2 * k
            self.constant[row, 3 * body : 3 * body + 2] = [-math.sin(angle), math.cos(angle)]
            self.constant[row + 1, 3 * body + 2] = 1
        for k, (body, _) in enumerate(self.drives):
            row = pins + 2 * guides + k
            guide = next((g for g in self.guides if g[0] == body), None)
            if guide is None:
                self.constant[row, 3 * body + 2] = 1
            else:
                self.constant[row, 3 * body : 3 * body + 2] = np.cos(guide[2]), np.sin(guide[2])

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
        spin = v[3 * self.owner + 2]
        turning = np.array(
            [v[3 * self.owner] - spin * arms[1], v[3 * self.owner + 1] + spin * arms[0]]
        )
        return np.where(self.moving, turning, 0.0)

    def closure(self, t: float, q: np.ndarray) -> np.ndarray:
        """Φ."""
        places = self.placed(q, self.arms(q))
        count = len(self.pairs)
        gaps = (places[:, 1 : 2 * count : 2] - places[:, 0 : 2 * count : 2]).T.ravel()
        rest = self.constant[2 * count :] @ q
        for k, (_, origin, angle) in enumerate(self.guides):
            rest[2 * k] -= np.dot([-math.sin(angle), math.cos(angle)], origin)
            rest[2 * k + 1] -= angle
        first = 2 * len(self.guides)
        for k, (body, law) in enumerate(self.drives):
            rest[first + k] -= jet(law, t)[0]
            rest[first + k] -= sum(
                np.dot([math.cos(a), math.sin(a)], o) for b, o, a in self.guides if b == body
            )
        return np.concatenate([gaps, rest])

    def jacobian(self, arms: np.ndarray) -> np.ndarray:
        """Φ_q."""
        phi = self.constant.copy()
        for k in range(len(self.pairs)):
            for point, sign in ((2 * k, -1.0), (2 * k + 1, 1.0)):
                body = self.owner[point]
                if body >= 0:
                    phi[2 * k, 3 * body + 2] -= sign * arms[1, point]
                    phi[2 * k + 1, 3 * body + 2] += sign * arms[0, point]
        return phi

    def between(self, values: np.ndarray) -> np.ndarray:
        """Displaced ends less pins, shape (clearances, 2)."""
        first = 2 * len(self.pairs)
        return (values[:, first + 1 :: 2] - values[:, first::2]).T

    def offsets(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Offset and rate of every clearance, shape (clearances, 2)."""
        q, v = y[: self.size], y[self.size : 2 * self.size]
        arms = self.arms(q)
        return self.between(self.placed(q, arms)), self.between(self.moved(v, arms))

    def rates(self, t: float, y: np.ndarray, modes: list[Mode]) -> np.ndarray:
        """The right-hand side in given modes."""
        q, v = y[: self.size], y[self.size : 2 * self.size]
        arms = self.arms(q)
        forces, powers = self._applied(t, q, v)
        offset, rate = self.between(self.placed(q, arms)), self.between(self.moved(v, arms))
        for k, (gap, mode) in enumerate(zip(self.gaps, modes, strict=True)):
            if mode.state != FREE:
                powers = powers + self._contact(k, gap, mode, offset[k], rate[k], v, arms, forces)
        acceleration, multipliers = self._accelerations(t, v, arms, forces)
        first = self.rows - len(self.drives)
        for k, (_, law) in enumerate(self.drives):
            powers[2] -= multipliers[first + k] * jet(law, t)[1]
        return np.concatenate([v, acceleration, powers])

    def _accelerations(
        self, t: float, v: np.ndarray, arms: np.ndarray, forces: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        phi = self.jacobian(arms)
        bias = -(np.where(self.moving, v[3 * self.owner + 2], 0.0) ** 2) * arms
        count = len(self.pairs)
        gamma = np.zeros(self.rows)
        gamma[: 2 * count] = (bias[:, 0 : 2 * count : 2] - bias[:, 1 : 2 * count : 2]).T.ravel()
        for k, (_, law) in enumerate(self.drives):
            gamma[self.rows - len(self.drives) + k] = jet(law, t)[2]
        light = phi / self.masses
        multipliers = np.linalg.solve(light @ phi.T, light @ forces - gamma)
        return (forces - phi.T @ multipliers) / self.masses, multipliers

    def _applied(self, t: float, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Weight and loads; and the powers of losses and loads."""
        forces, powers = self.weight.copy(), np.zeros(3)
        for load in self.mechanism.loads:
            match load.measure:
                case Slide(body):
                    index = self.names.index(body)
                    _, origin, angle = next(g for g in self.guides if g[0] == index)
                    row = np.zeros(self.size)
                    row[3 * index : 3 * index + 2] = math.cos(angle), math.sin(angle)
                    value = row @ q - np.dot(row[3 * index : 3 * index + 2], origin)
                case Turn(body, None):
                    row = np.zeros(self.size)
                    row[3 * self.names.index(body) + 2] = 1
                    value = row @ q
                case _:
                    raise TypeError(f"not for this oracle: {load.measure}")
            force = jet(load.law, t, (value, row @ v))[0]
            forces += force * row
            powers[2] += force * (row @ v)
        return forces, powers

    def _contact(
        self, k: int, gap: Gap, mode: Mode, e: np.ndarray, rate: np.ndarray, v: np.ndarray,
        arms: np.ndarray, forces: np.ndarray,
    ) -> np.ndarray:  # fmt: skip
        """Add the force of one clearance to those on the bodies; return its powers."""
        rho = math.hypot(*e)
        n = e / rho
        depth, speed = max(rho - gap.size, 0.0), float(n @ rate)
        force = gap.push(depth, speed, mode.first) if mode.state == CONTACT else 0.0
        loss = (force - gap.stiffness * depth**gap.exponent) * speed
        slip = self._slip(k, gap, rho, n, rate, v)
        along = -gap.friction * force * math.tanh(slip / gap.slip) if gap.friction else 0.0
        side = 1.0 if gap.carries == "pin" else -1.0  # n from hole to pin is side·n
        t = side * np.array([-n[1], n[0]])
        pin = side * force * -n + along * t  # on the pin
        on_end = pin if gap.carries == "pin" else -pin
        point = 2 * len(self.pairs) + 2 * k
        for index, sign in ((point, -1.0), (point + 1, 1.0)):
            body = self.owner[index]
            if body >= 0:
                fx, fy = sign * on_end
                x, y = arms[:, index]
                carries_pin = (index == point + 1) == (gap.carries == "pin")
                lever = gap.pin_radius if carries_pin else -(gap.pin_radius + rho)
                forces[3 * body : 3 * body + 3] += fx, fy, x * fy - y * fx + lever * along
        return np.array([loss, -along * slip, 0.0])

    def _slip(
        self, k: int, gap: Gap, rho: float, n: np.ndarray, rate: np.ndarray, v: np.ndarray
    ) -> float:
        """Tangential velocity of the pin against the hole at the point of contact."""
        point = 2 * len(self.pairs) + 2 * k
        joint, end = (0.0 if b < 0 else v[3 * b + 2] for b in self.owner[point : point + 2])
        pin, hole = (end, joint) if gap.carries == "pin" else (joint, end)
        across = float(rate @ np.array([-n[1], n[0]]))
        return across + gap.pin_radius * pin - (gap.pin_radius + rho) * hole

    def start(self) -> np.ndarray:
        """The state at t = 0: free coordinates, offsets and their rates as the definition says.

        Where the ideal mechanism stands is only where Newton's method starts.
        """
        found = at_start(self.mechanism)
        guess = np.zeros(self.size)
        for k, (name, body) in enumerate(self.mechanism.bodies.items()):
            joint, place = next(iter(body.points.items()))
            angle = body.guide.angle.value if body.guide else found["bar_angle"][name]
            guess[3 * k : 3 * k + 2] = found["joint_position"][joint]
            guess[3 * k : 3 * k + 2] += turned(angle, self.centres[name] - local(place))
            guess[3 * k + 2] = angle
        free = [self._free_row(name) for name in self.mechanism.initial]
        given = list(self.mechanism.initial.values())
        held = [row @ guess for row in free]  # angles may count whole turns
        wanted = [start.speed for start in given]
        for _ in range(8):
            arms = self.arms(guess)
            off = self.between(self.placed(guess, arms)) - [g.offset for g in self.gaps]
            parts = [
                self.closure(0.0, guess),
                off.ravel(),
                np.array(free) @ guess - held if free else [],
            ]
            guess = guess - np.linalg.solve(self._square(arms, free), np.concatenate(parts))
        right = np.zeros(self.rows)
        for k, (_, law) in enumerate(self.drives):
            right[self.rows - len(self.drives) + k] = jet(law, 0.0)[1]
        rates = np.array([g.rate for g in self.gaps]).ravel()
        right = np.concatenate([right, rates, wanted])
        return np.concatenate(
            [guess, np.linalg.solve(self._square(self.arms(guess), free), right), np.zeros(3)]
        )

    def _free_row(self, name: str) -> np.ndarray:
        row, k = np.zeros(self.size), self.names.index(name)
        guide = self.mechanism.bodies[name].guide
        if guide is None:
            row[3 * k + 2] = 1
        else:
            row[3 * k : 3 * k + 2] = math.cos(guide.angle.value), math.sin(guide.angle.value)
        return row

    def _square(self, arms: np.ndarray, free: list[np.ndarray]) -> np.ndarray:
        """Φ_q over the Jacobians of offsets and free coordinates."""
        rows = [self.jacobian(arms)]
        for k in range(len(self.gaps)):
            block = np.zeros((2, self.size))
            first = 2 * len(self.pairs) + 2 * k
            for point, sign in ((first, -1.0), (first + 1, 1.0)):
                body = self.owner[point]
                if body >= 0:
                    block[:, 3 * body : 3 * body + 2] += sign * np.eye(2)
                    block[:, 3 * body + 2] += sign * np.array([-arms[1, point], arms[0, point]])
            rows.append(block)
        return np.concatenate([*rows, *(row[None] for row in free)])

    def projected(self, t: float, y: np.ndarray) -> np.ndarray:
        """The state put back onto constraints and their rates."""
        q, v = y[: self.size].copy(), y[self.size : 2 * self.size]
        for _ in range(2):
            phi = self.jacobian(self.arms(q))
            q -= phi.T @ np.linalg.solve(phi @ phi.T, self.closure(t, q))
        phi = self.jacobian(self.arms(q))
        off = phi @ v
        for k, (_, law) in enumerate(self.drives):
            off[self.rows - len(self.drives) + k] -= jet(law, t)[1]
        v = v - phi.T @ np.linalg.solve(phi @ phi.T, off)
        return np.concatenate([q, v, y[2 * self.size :]])


def local(place: tuple) -> np.ndarray:
    """Two parameters as an array."""
    return np.array([place[0].value, place[1].value])


def turned(angle: float, vector: np.ndarray) -> np.ndarray:
    """A vector turned counter-clockwise."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])
