"""An independent formulation of contact in clearances: absolute coordinates and multipliers.

Every ideal joint, guide and drive is a constraint on the centres of mass and angles of bodies. With
the diagonal mass matrix M, M q̈ + Φ_qᵀ λ = Q and Φ_q q̈ = γ give λ from Φ_q M⁻¹ Φ_qᵀ. A clearance
constrains nothing: its force follows from where the two centres are. It shares neither coordinates
nor formulas with the kernel.
"""

import math
from dataclasses import dataclass

import numpy as np
from absolute_gaps import CONTACT, FREE, taken_apart
from contact_bodies import Bodies
from time_functions import jet

import linkages
from linkages.components.contributed.load_measures import Load, Slide, Turn

LOST, RUBBED, WORK = range(3)


@dataclass
class Mode:
    """What a clearance remembers: its state and the rate of its last touch."""

    state: str = FREE
    first: float = math.nan


@dataclass(frozen=True)
class Wall:
    """Where the two ends of a clearance stand to each other: n from the pin to the end."""

    rho: float
    n: np.ndarray
    speed: float
    slip: float


class AbsoluteContact:
    """Equations of a definition with contact in its clearances.

    A vector y holds coordinates, their rates, and what was lost along the normals, lost by
    friction, and done by drives and loads (J).
    """

    def __init__(self, definition: str) -> None:
        ideal, self.gaps = taken_apart(definition)
        self.mechanism = linkages.loads(ideal)
        self.bodies = Bodies(self.mechanism, self.gaps)
        self.size = self.bodies.size
        self.pull = np.zeros(self.size)
        gravity = self.mechanism.gravity
        self.pull[0::3], self.pull[1::3] = gravity.x.value, gravity.y.value
        self.loads = [(load, *self._row(load)) for load in self.mechanism.loads]

    def _row(self, load: Load) -> tuple[np.ndarray, float]:
        """What a load acts along: row·q − constant."""
        if isinstance(load.measure, Slide | Turn):
            assert getattr(load.measure, "reference", None) is None
            return self.bodies.coordinate(load.measure.body)
        raise TypeError(f"not for this oracle: {load.measure}")

    def start(self) -> np.ndarray:
        """The state at t = 0."""
        return np.concatenate([*self.bodies.start(), np.zeros(3)])

    def places(self, y: np.ndarray) -> np.ndarray:
        """Coordinates of all bodies."""
        return y[: self.size]

    def speeds(self, y: np.ndarray) -> np.ndarray:
        """Their rates."""
        return y[self.size : 2 * self.size]

    def offsets(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Offset and rate of every clearance, shape (clearances, 2)."""
        q, bodies = self.places(y), self.bodies
        arms = bodies.arms(q)
        placed, moved = bodies.placed(q, arms), bodies.moved(self.speeds(y), arms)
        return bodies.between(placed), bodies.between(moved)

    def wall(self, y: np.ndarray, k: int) -> Wall:
        """Contact quantities of clearance `k`; at offset zero there is no direction, and n is 0."""
        offset, rate = (part[k] for part in self.offsets(y))
        return self._wall(k, offset, rate, self.speeds(y))

    def _wall(self, k: int, offset: np.ndarray, rate: np.ndarray, v: np.ndarray) -> Wall:
        gap, rho = self.gaps[k], math.hypot(*offset)
        n = offset / rho if rho else np.zeros(2)
        first = 2 * self.bodies.pins + 2 * k
        joint, end = (0.0 if b < 0 else v[3 * b + 2] for b in self.bodies.owner[first : first + 2])
        pin, hole = (end, joint) if gap.carries == "pin" else (joint, end)
        across = rate[1] * n[0] - rate[0] * n[1]
        slip = across + gap.pin_radius * pin - (gap.pin_radius + rho) * hole
        return Wall(rho, n, float(n @ rate), float(slip))

    def force(self, k: int, wall: Wall, mode: Mode) -> float:
        """Normal force of clearance `k`."""
        gap = self.gaps[k]
        if mode.state != CONTACT:
            return 0.0
        return gap.push(max(wall.rho - gap.size, 0.0), wall.speed, mode.first)

    def rates(self, t: float, y: np.ndarray, modes: list[Mode]) -> np.ndarray:
        """The right-hand side in given modes."""
        q, v, bodies = self.places(y), self.speeds(y), self.bodies
        arms = bodies.arms(q)
        forces, powers = self.pull * bodies.masses, np.zeros(3)
        for load, row, constant in self.loads:
            rate = row @ v
            push = jet(load.law, t, (row @ q - constant, rate))[0]
            forces += push * row
            powers[WORK] += push * rate
        self._press_all(modes, q, v, forces, powers)
        phi = bodies.jacobian(arms)
        light = phi / bodies.masses
        right = light @ forces - bodies.convective(t, v, arms)
        multipliers = np.linalg.solve(light @ phi.T, right)
        powers[WORK] -= multipliers @ bodies.prescribed(t, 1)
        return np.concatenate([v, (forces - phi.T @ multipliers) / bodies.masses, powers])

    def _press_all(
        self, modes: list[Mode], q: np.ndarray, v: np.ndarray, forces: np.ndarray,
        powers: np.ndarray,
    ) -> None:  # fmt: skip
        """Add forces and losses of all clearances."""
        bodies = self.bodies
        arms = bodies.arms(q)
        offset = bodies.between(bodies.placed(q, arms))
        rate = bodies.between(bodies.moved(v, arms))
        for k, mode in enumerate(modes):
            if mode.state != FREE:
                self._press(k, mode, self._wall(k, offset[k], rate[k], v), arms, forces, powers)

    def _press(
        self, k: int, mode: Mode, wall: Wall, arms: np.ndarray, forces: np.ndarray,
        powers: np.ndarray,
    ) -> None:  # fmt: skip
        """Add forces and losses of one clearance.

        Both bodies meet at one point of the wall, R from the centre of the pin and R + ρ from that
        of the hole.
        """
        gap, force = self.gaps[k], self.force(k, wall, mode)
        elastic = gap.stiffness * max(wall.rho - gap.size, 0.0) ** gap.exponent
        along = -force * gap.rub(wall.slip)
        powers[LOST] += (force - elastic) * wall.speed
        powers[RUBBED] -= along * wall.slip
        side = 1.0 if gap.carries == "pin" else -1.0  # n from hole to pin is side·n
        across = side * np.array([-wall.n[1], wall.n[0]])
        on_end = -force * wall.n + side * along * across
        levers = {"pin": gap.pin_radius, "hole": -(gap.pin_radius + wall.rho)}
        other = "hole" if gap.carries == "pin" else "pin"
        first = 2 * self.bodies.pins + 2 * k
        for point, sign, carried in ((first, -1.0, other), (first + 1, 1.0, gap.carries)):
            body = self.bodies.owner[point]
            if body >= 0:
                fx, fy = sign * on_end
                x, y = arms[:, point]
                torque = x * fy - y * fx + levers[carried] * along
                forces[3 * body : 3 * body + 3] += fx, fy, torque

    def projected(self, t: float, y: np.ndarray) -> np.ndarray:
        """The state put back onto the constraints and their rates."""
        q, v, bodies = self.places(y), self.speeds(y), self.bodies
        for _ in range(2):
            phi = bodies.jacobian(bodies.arms(q))
            q = q - phi.T @ np.linalg.solve(phi @ phi.T, bodies.closure(t, q))
        phi = bodies.jacobian(bodies.arms(q))
        v = v - phi.T @ np.linalg.solve(phi @ phi.T, phi @ v - bodies.prescribed(t, 1))
        return np.concatenate([q, v, y[2 * self.size :]])

    def energy(self, y: np.ndarray) -> float:
        """Kinetic, of weight, and elastic, in slack as well."""
        q, v = self.places(y), self.speeds(y)
        total = 0.5 * self.bodies.masses @ v**2 - self.bodies.masses @ (self.pull * q)
        for k, gap in enumerate(self.gaps):
            depth = max(self.wall(y, k).rho - gap.size, 0.0)
            total += gap.stiffness * depth ** (gap.exponent + 1) / (gap.exponent + 1)
        return float(total)
