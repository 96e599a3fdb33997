"""Equations that orbits and equilibria solve, and Newton's method for them."""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from linkages.errors import ComputationError, InputError
from linkages.options.run import RunOptions
from linkages.orbits.contact_events import extremum_guard, rigid_touches
from linkages.orbits.shooting import Change, Shooting, Shot
from linkages.solution.guards import Guard
from linkages.solution.rhs import Equations

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

CONVERGED = 1e-10
"""Scaled step of Newton's method below which it has converged."""

STAGNATED = 1e4
"""The same, over the tolerance of motions, of steps that shrink no more."""

MOST_STEPS = 12
"""Of Newton's method."""

FARTHEST = 3.0
"""Scaled step of Newton's method beyond which the solution is another one, or none."""

NEAR = 0.1
"""Part of the longest time without a change of contacts by which nodes are away from changes."""

TINY = 1e-300

CHATTER = 60
"""Changes of contacts on an orbit beyond which round-off may be amplified beyond tolerances."""

CONSERVED = 1e-6
"""How far the product of all multipliers is from 1 where energy is conserved."""


class NotConvergedError(ComputationError):
    """Newton's method found no solution near its start."""


@dataclass(frozen=True, eq=False)
class Evaluated:
    """The equations at some unknowns and places.

    `by_unknowns`, `by_places`: its derivatives, shapes (N, N) and (N, P).
    """

    residual: Floats  # in units of the unknowns, shape (N,)
    by_unknowns: Floats
    by_places: Floats
    # Multipliers of an orbit, or eigenvalues of an equilibrium in 1/s, the largest first
    spectrum: Complex
    vectors: Complex  # eigenvectors of the state at the beginning, as columns, shape (x, x)
    beginning: Floats  # state at the beginning of a period of the drives, shape (x,)
    shots: tuple[Shot, ...] = ()  # motions between the nodes; none of an equilibrium
    # Whether solutions form a family: those of a motion without drives that conserves energy
    family: bool = False

    @property
    def changes(self) -> tuple[Change, ...]:
        """Changes of contact modes on the whole orbit, in the order of time."""
        return tuple(change for shot in self.shots for change in shot.changes)


@dataclass(frozen=True, eq=False)
class Solution:
    """Unknowns and places that solve the equations.

    The equations were evaluated last at unknowns and places `before`, which differ by the last step
    of Newton's method, that is by less than `CONVERGED` or by round-off.
    """

    unknowns: Floats
    places: Floats
    at: Evaluated
    iterations: int
    before: Floats


class Problem(ABC):
    """Equations for unknowns u at places along rays of parameters.

    `shooting`: the mechanism and its parameters.
    `scale`: sizes of the unknowns, shape (N,).
    """

    shooting: Shooting
    scale: Floats

    @abstractmethod
    def evaluate(self, unknowns: Floats, places: Floats, near: Evaluated | None) -> Evaluated:
        """The equations, with modes of contacts at nodes as in the evaluation before."""

    def where(self, _unknowns: Floats, places: Floats) -> Floats:
        """Places along all rays."""
        return places

    @abstractmethod
    def state(self, unknowns: Floats) -> Floats:
        """State of the mechanism at the beginning, shape (x,)."""

    @abstractmethod
    def period(self, unknowns: Floats, places: Floats) -> float | None:
        """In seconds; None of an equilibrium."""

    @abstractmethod
    def with_run(self, run: RunOptions) -> Problem:
        """The same equations, integrated in another way."""

    def with_shooting(self, shooting: Shooting) -> Self:
        """The same equations of other motions."""
        result = copy.copy(self)
        result.shooting = shooting
        return result

    def stable(self, spectrum: Complex) -> bool:
        """Whether neighbours stay near."""
        return bool((np.abs(self.decisive(spectrum)) < 1.0).all())

    def decisive(self, spectrum: Complex) -> Complex:
        """Multipliers or eigenvalues that decide on stability."""
        return spectrum


class Orbit(Problem):
    """A motion that returns after some periods of the drives, or after an unknown period.

    `shooting`: the mechanism and its parameters.
    `periods`: number of periods of the drives; None for a mechanism that does not depend on time.
    `nodes`: number of equal parts of the orbit, whose first states are unknowns (multiple
    shooting).
    `phase`: where in a period of the drives the orbit begins, from 0 to 1.
    `reference`: a state, and the rate of change there, of the phase condition without drives.
    """

    def __init__(
        self,
        shooting: Shooting,
        periods: int | None,
        nodes: int = 1,
        *,
        phase: float = 0.0,
        reference: tuple[Floats, Floats] | None = None,
    ) -> None:
        self.shooting, self.periods, self.nodes, self.phase = shooting, periods, nodes, phase
        self._reference = reference
        self.free = periods is None
        self.rigid = rigid_touches(shooting.system.model)
        self.guards = [extremum_guard(name) for name in self.rigid]
        self.scale = np.tile(shooting.scale, nodes)
        if self.free:
            self.scale = np.append(self.scale, 1.0)

    def state(self, unknowns: Floats) -> Floats:
        """State at the first node, shape (x,)."""
        return unknowns[: self.shooting.size]

    def period(self, unknowns: Floats, places: Floats) -> float:
        """Of the orbit, in seconds."""
        if self.periods is None:
            return float(unknowns[-1])
        period = self.shooting.period(places)
        if period is None:
            raise ComputationError("the drives have no period here", time=0.0)
        return self.periods * period

    def with_run(self, run: RunOptions) -> Orbit:
        """The same orbits, integrated in another way."""
        return self.with_shooting(self.shooting.with_run(run))

    def starts(self, unknowns: Floats) -> Floats:
        """States at the nodes, shape (nodes, x)."""
        return unknowns[: self.nodes * self.shooting.size].reshape(self.nodes, -1)

    def doubled(self, nodes: int) -> Orbit:
        """Orbits of twice the period."""
        periods = None if self.periods is None else 2 * self.periods
        return Orbit(self.shooting, periods, nodes, phase=self.phase, reference=self._reference)

    def fractions(self) -> Floats:
        """Times of the nodes and of the end, in periods of the drives, or in orbits without any."""
        lasting = self.periods or 1
        return self.phase + lasting * np.arange(self.nodes + 1) / self.nodes

    def shots(
        self,
        unknowns: Floats,
        places: Floats,
        near: Evaluated | None = None,
        *,
        tangents: bool = True,
        guards: Sequence[Guard] = (),
        samples: int = 0,
    ) -> tuple[Shot, ...]:
        """Motions from node to node, each with samples at equal distances if they are wanted.

        Otherwise samples are the ends, and where a period of the drives begins.
        """
        unit = self.period(unknowns, places) / (self.periods or 1)
        if unit <= 0.0:
            raise ComputationError("the period has become negative", time=0.0)
        times = unit * self.fractions()
        span = float(times[1] - times[0])
        result: list[Shot] = []
        for node, start in enumerate(self.starts(unknowns)):
            first = None
            if self.phase and times[node] < unit < times[node + 1]:
                first = np.array([unit - times[node], span])
            held = None
            if result:
                held = result[-1].held
            elif near is not None and near.shots:
                held = near.shots[-1].held
            shot = self.shooting.shoot(
                places,
                start,
                span,
                start=float(times[node]),
                tangents=tangents,
                held=held or None,
                guards=guards,
                samples=span * np.arange(1, samples + 1) / samples if samples else first,
            )
            result.append(shot)
        return tuple(result)

    def evaluate(self, unknowns: Floats, places: Floats, near: Evaluated | None) -> Evaluated:
        """How far each part of the orbit ends from the beginning of the next one."""
        shots = self.shots(unknowns, places, near, guards=self.guards)
        x, nodes, size = self.shooting.size, self.nodes, len(unknowns)
        starts = self.starts(unknowns)
        residual = np.zeros(size)
        by_unknowns, by_places = np.zeros((size, size)), np.zeros((size, len(places)))
        slower = np.zeros(len(places)) if self.free else self.shooting.period_slopes(places)
        moved = np.outer(self.fractions(), slower)
        for node, shot in enumerate(shots):
            rows, following = slice(node * x, (node + 1) * x), (node + 1) % nodes
            residual[rows] = self.shooting.within_turn(shot.end - starts[following])
            by_unknowns[rows, rows] += shot.by_state
            by_unknowns[rows, following * x : (following + 1) * x] -= np.eye(x)
            by_places[rows] = shot.by_place
            if moved.any():
                before = shot.by_state @ shots[node - 1].flow
                by_places[rows] += np.outer(shot.flow, moved[node + 1])
                by_places[rows] -= np.outer(before, moved[node])
            if self.free:
                by_unknowns[rows, -1] = shot.flow / nodes
        if self.free:
            state, flow = self._reference or (starts[0], shots[-1].flow)
            weights = flow / self.shooting.scale**2
            norm = np.linalg.norm(flow / self.shooting.scale)
            residual[-1] = weights @ (starts[0] - state) / norm
            by_unknowns[-1, :x] = weights / norm
        spectrum, vectors = multipliers([shot.by_state for shot in shots], self.shooting.scale)
        beginning = starts[0]
        for shot in shots:
            if len(shot.motion.time) > 1:
                beginning = self.shooting.within_turn(self.shooting.states(shot.motion)[0])
        family = self.free and conserves(spectrum)
        return Evaluated(
            residual, by_unknowns, by_places, spectrum, vectors, beginning, shots, family
        )

    def later(self, solution: Solution, delay: float) -> tuple[Orbit, Floats, Floats]:
        """The same orbit with nodes a time in seconds later.

        Returns: its problem, its unknowns, and the derivatives of these by unknowns and place, of
        shape (N, N + P).
        """
        unknowns, places = solution.unknowns, solution.places
        unit = self.period(unknowns, places) / (self.periods or 1)
        x, starts = self.shooting.size, self.starts(unknowns)
        size = len(unknowns)
        result, moved = unknowns.copy(), np.eye(size, size + len(places))
        for node, start in enumerate(starts):
            shot = self.shooting.shoot(
                places,
                start,
                delay,
                start=float(unit * self.fractions()[node]),
                held=solution.at.shots[node - 1].held or None,
            )
            rows = slice(node * x, (node + 1) * x)
            result[rows], moved[rows] = self.shooting.within_turn(shot.end), 0.0
            moved[rows, rows], moved[rows, size:] = shot.by_state, shot.by_place
            if node == 0:
                reference = result[rows].copy(), shot.flow
        phase = 0.0 if self.free else (self.phase + delay / unit) % 1.0
        problem = Orbit(
            self.shooting, self.periods, self.nodes, phase=phase,
            reference=reference if self.free else None,
        )  # fmt: skip
        return problem, result, moved

    def clearest(self, solution: Solution) -> float:
        """Delay of nodes in seconds that takes them furthest away from changes of contacts.

        Zero where they are far enough away from any, for an orbit jumps where these pass a node.
        """
        span = self.period(solution.unknowns, solution.places) / self.nodes
        unit = span * self.nodes / (self.periods or 1)
        first = 0.0 if self.free else self.phase * unit
        times = np.sort([(change.time - first) % span for change in solution.at.changes])
        if not len(times):
            return 0.0
        gaps = np.diff(np.append(times, times[0] + span))
        widest = int(np.argmax(gaps))
        if min(times[0], span - times[-1]) > NEAR * gaps[widest]:
            return 0.0
        return float((times[widest] + 0.5 * gaps[widest]) % span)

    def decisive(self, spectrum: Complex) -> Complex:
        """Multipliers but for the one that belongs to a shift along the orbit without drives."""
        if not self.free or not len(spectrum):
            return spectrum
        return np.delete(spectrum, np.argmin(np.abs(spectrum - 1.0)))


class Equilibrium(Problem):
    """A state in which nothing moves, of a mechanism that does not depend on time."""

    periods = None

    def __init__(self, shooting: Shooting) -> None:
        self.shooting = shooting
        topology = shooting.system.topology
        n, inner = len(topology.free), len(topology.internal)
        # coordinates and internal states; rates are zero
        self._rows = np.array([*range(n), *range(2 * n, 2 * n + inner)])
        self.scale = shooting.scale[self._rows]

    def state(self, unknowns: Floats) -> Floats:
        """With rates of zero, shape (x,)."""
        result = np.zeros(self.shooting.size)
        result[self._rows] = unknowns
        return result

    def unknowns(self, state: Floats) -> Floats:
        """Coordinates and internal states of a state."""
        return state[self._rows]

    def period(self, _unknowns: Floats, _places: Floats) -> None:
        """None."""

    def with_run(self, _run: RunOptions) -> Equilibrium:
        """Itself: nothing is integrated."""
        return self

    def evaluate(self, unknowns: Floats, places: Floats, _near: Evaluated | None) -> Evaluated:
        """Accelerations and rates of internal states, which vanish."""
        state = self.state(unknowns)
        forces, jacobian = self._forces(state, places, slopes=True)
        by_places = np.zeros((len(self._rows), len(places)))
        for k in range(len(places)):
            move = np.zeros(len(places))
            move[k] = 1e-5
            after, before = (self._forces(state, places + s * move)[0] for s in (1.0, -1.0))
            by_places[:, k] = (after - before) / 2e-5
        n = len(self.shooting.system.topology.free)
        values, vectors = np.linalg.eig(jacobian)
        order = np.argsort(-values.real)
        return Evaluated(
            residual=forces / self._size,
            by_unknowns=jacobian[n:][:, self._rows] / self._size,
            by_places=by_places / self._size,
            spectrum=values[order],
            vectors=vectors[:, order],
            beginning=state,
        )

    _size = 1.0

    def _forces(self, state: Floats, places: Floats, slopes: bool = False) -> tuple[Floats, Floats]:
        """Accelerations and rates of internal states, and the Jacobian of all rates of change."""
        equations = Equations(self.shooting.system_at(places, state))
        n = len(equations.system.topology.free)
        kept = np.delete(np.arange(len(equations.state)), self.shooting.carried_rows)
        rates = equations(0.0, equations.state)[kept]
        jacobian = equations.jacobian(0.0, equations.state)[np.ix_(kept, kept)] if slopes else rates
        return rates[n:], jacobian

    def stable(self, spectrum: Complex) -> bool:
        """Whether all eigenvalues have negative real parts."""
        return bool((spectrum.real < 0.0).all())


def multipliers(parts: Sequence[Floats], scale: Floats) -> tuple[Complex, Complex]:
    """Eigenvalues of the product of the parts, the last one at the left, and its eigenvectors.

    With several parts they are powers of eigenvalues of the cyclic matrix of all parts, which does
    not lose the small ones in the large ones, as the product does.
    """
    x, count = len(scale), len(parts)
    scaled = [part * scale / scale[:, None] for part in parts]
    if count == 1:
        values, vectors = np.linalg.eig(scaled[0])
    else:
        cyclic = np.zeros((count * x, count * x))
        for k, part in enumerate(scaled):
            row = (k + 1) % count
            cyclic[row * x : (row + 1) * x, k * x : (k + 1) * x] = part
        roots, columns = np.linalg.eig(cyclic)
        # each multiplier has as many roots as there are parts
        powers, left = roots**count, list(np.argsort(-np.abs(roots)))
        values, vectors = np.empty(x, dtype=complex), np.empty((x, x), dtype=complex)
        for place in range(x):
            first = powers[left[0]]
            own = sorted(left, key=lambda k: abs(powers[k] - first))[:count]
            values[place], vectors[:, place] = powers[own].mean(), columns[:x, own[0]]
            left = [k for k in left if k not in own]
        real = np.abs(values.imag) < 1e-13 * np.abs(values)
        values[real] = values[real].real
    order = np.lexsort((-values.imag, -np.abs(values).round(12)))
    return values[order].astype(complex), (vectors[:, order] * scale[:, None]).astype(complex)


def with_energy(problem: Orbit, places: Floats, energy: float) -> Condition:
    """That orbits of a family, without drives or losses, have an energy in joules."""
    shooting = problem.shooting
    steps = 1e-6 * np.concatenate([np.zeros((1, shooting.size)), np.diag(shooting.scale)])
    steps = np.concatenate([steps, -steps[1:]])
    size = max(abs(energy), float(np.ptp([shooting.energy(places, s) for s in steps])), 1e-300)

    def of(unknowns: Floats, _places: Floats, _at: Evaluated) -> tuple[float, Floats]:
        state = problem.state(unknowns)
        values = np.array([shooting.energy(places, state + step) for step in steps])
        row = np.zeros(len(unknowns) + len(places))
        row[: shooting.size] = (values[1 : 1 + shooting.size] - values[1 + shooting.size :]) / 2e-6
        return (values[0] - energy) / size, row / size

    return of


def pair_product(spectrum: Complex, sums: bool) -> float:
    """Product over all pairs of 1 − ab, or of their sums; 1 where there are none."""
    values = []
    for i, a in enumerate(spectrum.tolist()):
        for b in spectrum[i + 1 :].tolist():
            scale = abs(a) + abs(b) + TINY if sums else 1.0 + abs(a * b)
            values.append((a + b if sums else 1.0 - a * b) / scale)
    return float(np.prod(values).real) if values else 1.0


def conserves(spectrum: Complex) -> bool:
    """Whether multipliers come in pairs μ, 1/μ."""
    return len(spectrum) > 1 and bool(abs(abs(complex(np.prod(spectrum))) - 1.0) < CONSERVED)


Condition = Callable[[Floats, Floats, Evaluated], tuple[float, Floats]]
"""A further equation: unknowns, places and the equations there → its value, and its derivatives by
scaled unknowns and places."""


def along(problem: Problem, point: Floats, direction: Floats) -> Condition:
    """That scaled unknowns and places lie in a plane through a point, normal to a direction."""

    def of(unknowns: Floats, places: Floats, _: Evaluated) -> tuple[float, Floats]:
        here = np.concatenate([unknowns / problem.scale, places])
        return float(direction @ (here - point)), direction

    return of


def solve(
    problem: Problem,
    unknowns: Floats,
    places: Floats,
    conditions: Sequence[Condition] = (),
    *,
    near: Evaluated | None = None,
    patient: bool = False,
) -> Solution:
    """Solve the equations, with as many further conditions as there are free places.

    Without conditions, places stay as they are.

    `near`: the equations near the solution, which know the modes of contacts.
    `patient`: whether to shorten steps that lead away from the solution.
    Raises NotConvergedError if there is no solution near.
    """
    u, s = unknowns.copy(), np.array(places, dtype=float)
    count, scale = len(u), problem.scale
    stagnated = STAGNATED * max(problem.shooting.run.rtol, 1e-11)
    previous, damping, step = np.inf, 1.0, np.zeros(count)
    last: tuple[Floats, Floats, Evaluated, float] | None = None
    for iteration in range(1, MOST_STEPS * (3 if patient else 1) + 1):
        try:
            at = problem.evaluate(u, s, near)
        except (ComputationError, InputError) as error:  # or parameters without a meaning
            if last is None or not patient or damping < 1e-3:
                raise NotConvergedError(f"no solution near: {error}", time=0.0) from error
            at = None
        if at is not None:
            near = at
            matrix = at.by_unknowns * scale / scale[:, None]
            right = at.residual / scale
            size = float(np.linalg.norm(right))
        if patient and last is not None and (at is None or size > 1.5 * last[3]):
            damping *= 0.3
            if damping < 1e-3:
                break
            u = last[0] + damping * step[:count] * scale
            continue
        assert at is not None
        if conditions:
            pairs = [condition(u, s, at) for condition in conditions]
            matrix = np.vstack(
                [np.hstack([matrix, at.by_places / scale[:, None]]), *[row for _, row in pairs]]
            )
            right = np.concatenate([right, [value for value, _ in pairs]])
        step = _step(matrix, right, at.family)
        length = float(np.abs(step).max())
        if not np.isfinite(length) or (length > FARTHEST and not patient):
            break
        if length < CONVERGED or (length < stagnated and length > 0.1 * previous):
            before = np.concatenate([u, s])
            after = s + step[count:] if conditions else s
            return Solution(u + step[:count] * scale, after, at, iteration, before)
        previous, last = length, (u, s, at, size)
        damping = min(1.0, FARTHEST / length) if patient else 1.0
        u = u + damping * step[:count] * scale
        s = s + damping * step[count:] if conditions else s
    changes = 0 if near is None else len(near.changes)
    chatter = f"; contacts change {changes} times on it (chatter)" if changes > CHATTER else ""
    raise NotConvergedError(
        f"Newton's method found no solution within {iteration} steps; the last one was "
        f"{length:.2g} amplitudes long{chatter}",
        time=0.0,
    )


def _step(matrix: Floats, right: Floats, family: bool) -> Floats:
    """The step of Newton's method; the shortest one where solutions are a family."""
    count = min(matrix.shape)
    if matrix.shape[0] == count == matrix.shape[1] and not family:
        try:
            return np.asarray(np.linalg.solve(matrix, -right))
        except np.linalg.LinAlgError:
            raise NotConvergedError("equations are singular here", time=0.0) from None
    left, sizes, columns = np.linalg.svd(matrix, full_matrices=False)
    kept = count - 1 if family and matrix.shape[0] == matrix.shape[1] else count
    parts = (left.T[:kept] @ -right) / sizes[:kept]
    return np.asarray(columns[:kept].T @ parts)
