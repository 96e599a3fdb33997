"""An independent formulation of a mechanism: absolute coordinates and Lagrange multipliers.

Every body, massless links too, has three coordinates; every joint is a constraint. With M q̈ + h +
Φ_qᵀ λ = Q and Φ_q q̈ + b = law″ it shares neither coordinates nor formulas with the kernel
(Shabana, "Computational Dynamics", 3rd ed., ch. 6). Constraint forces on the bodies are −Φ_qᵀ λ.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from absolute_bodies import Layout, State, pair, turned
from absolute_constraints import Constraint, constraints
from absolute_covered import NotCoveredError, require_covered
from absolute_forces import inertia, loads, weight
from absolute_measures import along_axis, coordinate

from linkages.components.contributed.load_measures import Bearing
from linkages.components.contributed.terms import axis_label
from linkages.components.mechanisms.mechanism import Mechanism

MOST_REACTIONS = 200
"""Iterations of forces that press frictions."""


@dataclass(frozen=True)
class Solved:
    """Accelerations q̈ and what each constraint exerts (force or torque of its measure)."""

    state: State
    accelerations: np.ndarray
    efforts: list[tuple[Constraint, np.ndarray]]


class AbsoluteModel:
    """Equations of a mechanism in absolute coordinates."""

    def __init__(self, mechanism: Mechanism) -> None:
        require_covered(mechanism)
        self.mechanism = mechanism
        self.layout = Layout(mechanism)
        self.constraints = constraints(mechanism, self.layout)
        self.free = [coordinate(self.layout, name) for name in mechanism.initial]
        equations = sum(c.size for c in self.constraints) + len(self.free)
        self.redundant = equations > self.layout.size
        """Whether constraints repeat each other; reactions are then not determined."""
        self.pressed = [load for load in mechanism.loads if load.bearing is not None]
        if self.redundant and self.pressed:
            raise NotCoveredError(
                self.pressed[0].path, "friction by reactions that are not determined"
            )

    def configuration(
        self, places: Mapping[str, np.ndarray], angles: Mapping[str, float]
    ) -> np.ndarray:
        """Coordinates from positions of joints and angles of bodies (not of sliders)."""
        result = np.zeros(self.layout.size)

        def direction(name: str | None) -> float:
            guide = None if name is None else self.mechanism.bodies[name].guide
            if guide is not None:
                return direction(guide.body) + guide.angle.value
            return 0.0 if name is None else angles[name]

        for name, body in self.mechanism.bodies.items():
            angle = direction(name)
            joint, local = next(iter(body.points.items()))
            start = self.layout.start[name]
            result[start : start + 2] = places[joint] - turned(angle, pair(local))
            result[start + 2] = angle
        return result

    def closure(self, state: State) -> np.ndarray:
        """Φ: every measure less its prescribed value."""
        parts = [c.measure(state).value - c.prescribed(state.time)[0] for c in self.constraints]
        return np.concatenate(parts)

    def jacobian(self, state: State) -> np.ndarray:
        """Φ_q."""
        return np.concatenate([c.measure(state).jacobian for c in self.constraints])

    def state(self, time: float, places: np.ndarray, free_rates: Mapping[str, float]) -> State:
        """The state with given rates of the free coordinates.

        First, places are corrected by Newton's method with the free coordinates held: what is
        given has round-off, or as many digits as somebody wrote down.
        """
        rest = np.zeros(self.layout.size)
        start = State(self.layout, time, places, rest)
        held = [measure(start).value for measure in self.free]
        for _ in range(6):
            now = State(self.layout, time, places, rest)
            off = [m(now).value - value for m, value in zip(self.free, held, strict=True)]
            places = places - self._solved_for_rates(now, np.concatenate([self.closure(now), *off]))
        now = State(self.layout, time, places, rest)
        wanted = [np.full(c.size, c.prescribed(time)[1]) for c in self.constraints]
        wanted += [np.array([free_rates[name]]) for name in self.mechanism.initial]
        return State(self.layout, time, places, self._solved_for_rates(now, np.concatenate(wanted)))

    def _solved_for_rates(self, state: State, right: np.ndarray) -> np.ndarray:
        return refined_solve(self.full_jacobian(state), right, self.redundant)

    def full_jacobian(self, state: State) -> np.ndarray:
        """Φ_q above the rows of the free coordinates: square where the mobility is right."""
        return np.concatenate([self.jacobian(state), *(m(state).jacobian for m in self.free)])

    def solve(self, state: State) -> Solved:
        """Accelerations and multipliers.

        Frictions that follow reactions are iterated: their coefficients make that a contraction
        unless the mechanism may lock.
        """
        forces = dict.fromkeys((load.bearing for load in self.pressed), 0.0)
        for _ in range(MOST_REACTIONS):
            solved = self._solved(state, forces)
            found = {bearing: self._pressing(bearing, solved) for bearing in forces}
            off = [abs(found[bearing] - force) for bearing, force in forces.items()]
            forces = found
            if max(off, default=0.0) <= 1e-15 * max(forces.values(), default=0.0):
                return solved
        raise NotCoveredError(self.pressed[0].path, "friction by reactions that may lock")

    def _pressing(self, bearing: Bearing, solved: Solved) -> float:
        """The force on a body at a joint, or across the axis that it slides along."""
        across = bearing.point == axis_label(bearing.body)
        for constraint, effort in solved.efforts:
            if across and (constraint.kind, constraint.label) == ("axis", bearing.body):
                return abs(effort[0])
            own = constraint.kind, constraint.label, constraint.second
            if own == ("pin", bearing.point, bearing.body):
                return float(np.hypot(*effort))
        raise NotCoveredError(
            (bearing.body, bearing.point), "a reaction of the first body at a joint"
        )

    def _solved(self, state: State, pressing: Mapping[Bearing, float]) -> Solved:
        matrix, bias = inertia(self.mechanism, state)
        phi = self.jacobian(state)
        gamma = np.concatenate(
            [c.prescribed(state.time)[2] - c.measure(state).bias for c in self.constraints]
        )
        forces = weight(self.mechanism, state) + loads(self.mechanism, state, pressing)
        zero = np.zeros((len(phi), len(phi)))
        system = np.block([[matrix, phi.T], [phi, zero]])
        solution = refined_solve(system, np.concatenate([forces - bias, gamma]), self.redundant)
        multipliers = iter(-solution[self.layout.size :])
        efforts = [
            (c, np.array([next(multipliers) for _ in range(c.size)])) for c in self.constraints
        ]
        return Solved(state, solution[: self.layout.size], efforts)

    def coordinate_values(self, solved: Solved, slider: str) -> tuple[float, float, float]:
        """Displacement of a slider along its axis and its two derivatives."""
        value, jacobian, bias = along_axis(self.layout, slider)(solved.state)
        rate, second = jacobian @ solved.state.rates, jacobian @ solved.accelerations + bias
        return value[0], rate[0], second[0]


def refined_solve(matrix: np.ndarray, right: np.ndarray, redundant: bool = False) -> np.ndarray:
    """Solution of a linear system with two refinements by residuals in extended precision.

    Rows and columns are scaled first: a link of 0.1 mm and a bar of 1 m stand in one matrix. With
    redundant constraints it is the one with the least sum of (scaled) squares.
    """
    rows = 1 / np.abs(matrix).max(axis=1)
    columns = 1 / np.abs(rows[:, None] * matrix).max(axis=0)
    scaled, wanted = rows[:, None] * matrix * columns, rows * right
    exact, target = scaled.astype(np.longdouble), wanted.astype(np.longdouble)
    inverse = np.linalg.pinv(scaled, rcond=1e-10) if redundant else np.linalg.inv(scaled)
    found = inverse @ wanted
    for _ in range(2):
        found = found + inverse @ (target - exact @ found).astype(float)
    return columns * found
