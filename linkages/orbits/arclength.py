"""Pseudo-arclength continuation of orbits and equilibria, with special points on the way."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import KroghInterpolator
from scipy.optimize import brentq

from linkages.errors import ComputationError
from linkages.orbits.contact_events import (
    Difference,
    contacts,
    difference,
    extremum_guard,
    misses,
    sequence,
)
from linkages.orbits.equations import (
    Equilibrium,
    Evaluated,
    NotConvergedError,
    Orbit,
    Problem,
    Solution,
    along,
    pair_product,
    solve,
)
from linkages.orbits.grazing import Track, interpolant, passed
from linkages.orbits.loci import Locus

Floats = NDArray[np.float64]

LONGER, SHORTER = 1.5, 1.5
"""Factors of the step after few and many iterations of Newton's method."""

LOOKED_BACK = 3
"""Points from which the next one is extrapolated."""

FEW, MANY = 3, 6
"""Iterations after which the next step is longer, and shorter."""

MOST_TURN = math.cos(math.radians(18))
"""Cosine of the largest angle between tangents of neighbouring points."""

SHORTEST = 1e-9
"""Scaled length of a step below which a branch ends."""

OVER, SHORTEST_TO_EDGE = 1.01, 1e-6
"""Part of the way to the end of the range of a step that crosses it, and its least length."""

MOST_CONTACTS = 4
"""Contacts by which neighbouring points may differ."""

NOISE = 1e-2
"""Part of a step, over the tolerance of motions, to which special points are bracketed."""

ROUND_OFF = 1e-10
"""Test functions that are zero but for round-off."""

DEGENERATE = 1e-5
"""Test function of a point of codimension two that is located."""

MERGING = "merging"
"""Kind, before it is named, of a point at which a branch meets that of half its period."""

BESIDE = 1e-3
"""Length of the steps to both sides of a period doubling within which it is located again."""

ALIKE = 1e-3
"""Amplitudes within which halves of an orbit are alike: branch points are not round-off apart."""

CROSSINGS = ("branch point", "symmetry breaking", MERGING)
"""Kinds of points at which branches cross."""

COINCIDENT = 0.02
"""Part of a step within which a fold and a branch point are one."""

BEHIND = 1e-3
"""Part of the rest of a step behind a change of contacts at which the next one is looked for."""

CLOSE, SIDES = 8, 10
"""Parts of a step in which a branch point is looked for, and points that locate it."""

ON_CIRCLE = 1e-4
"""How close to −1, +1 or the unit circle a multiplier is at a bifurcation that is located."""

PREFIXES = {
    "fold": "F",
    "period doubling": "PD",
    "neimark-sacker": "NS",
    "hopf": "H",
    "branch point": "BP",
    "symmetry breaking": "SB",
    "grazing": "G",
    "contact loss": "CL",
    "sticking": "ST",
    "contact sequence": "CS",
    "cusp": "C",
    "fold-flip": "FF",
    "resonance 1:1": "R1",
    "resonance 1:2": "R2",
    "resonance 1:3": "R3",
    "resonance 1:4": "R4",
    "grazing-fold": "GF",
    "grazing-flip": "GP",
}
"""Kind of a special point → beginning of its label."""


class End(NamedTuple):
    """Why a branch ended, as a word and as a sentence."""

    reason: str
    text: str


@dataclass(frozen=True, eq=False)
class Point:
    """A point of a branch.

    `about`, `time`: name of the switch whose contact changes there, and when, as a part of the
    period.
    """

    solution: Solution  # unknowns and places, and the equations there
    problem: Problem  # the equations
    tangent: Floats  # unit vector along the branch in scaled unknowns and places, shape (N + 1,)
    kind: str = ""  # of a special point; empty for others
    label: str = ""  # of a special point, such as PD1
    about: str = ""
    time: float = math.nan

    @property
    def place(self) -> float:
        """Along the ray of parameters."""
        return float(self.solution.places[0])

    @property
    def where(self) -> Floats:
        """Places along all rays."""
        if isinstance(self.problem, Locus):
            return self.problem.settled(self.solution)
        return self.solution.places

    @property
    def solved(self) -> Floats:
        """Those that solve the equations, of a rigid contact with the gap that is left."""
        return self.problem.where(self.solution.unknowns, self.solution.places)

    @property
    def period(self) -> float | None:
        """In seconds; None of an equilibrium."""
        return self.problem.period(self.solution.unknowns, self.solution.places)

    @property
    def inside(self) -> bool:
        """Whether all parameters are in their ranges."""
        return bool(((self.solved >= 0.0) & (self.solved <= 1.0)).all())

    @property
    def at(self) -> Evaluated:
        """The equations at the point."""
        return self.solution.at


@dataclass(eq=False)
class Branch:
    """Points of a branch, in its order."""

    problem: Problem  # the equations that they solve
    points: list[Point] = field(default_factory=list)  # with special points among them
    # Why the branch ended at its first and at its last point
    ends: list[End] = field(default_factory=list)
    parent: str = ""  # label of the special point at which it begins; empty if it begins elsewhere

    @property
    def periods(self) -> int:
        """Periods of the drives that an orbit lasts; 0 of equilibria and without drives."""
        return getattr(self.problem, "periods", None) or 0


@dataclass(frozen=True)
class Limits:
    """Where a branch ends."""

    points: int = 500  # most points in each direction
    longest_step: float = 0.1  # in scaled unknowns and places
    unstable: bool = True  # whether to go on where stability is lost


Watch = Callable[[Branch, Point], None]


class Continuation:
    """Follows branches of a problem.

    `problem`: the equations.
    `limits`: where branches end.
    `solver`: what solves equations: `solve`, or one that remembers.
    """

    def __init__(
        self, problem: Problem, limits: Limits, solver: Callable[..., Solution] = solve
    ) -> None:
        self.problem, self.limits, self.solver = problem, limits, solver

    def vector(self, solution: Solution) -> Floats:
        """Scaled unknowns and places, shape (N + 1,)."""
        return np.concatenate([solution.unknowns / self.problem.scale, solution.places])

    def corrected(
        self, guess: Floats, direction: Floats, near: Evaluated | None = None
    ) -> Solution:
        """The solution in the plane through a guess that is normal to a direction."""
        count = len(guess) - 1
        return self.solver(
            self.problem,
            guess[:count] * self.problem.scale,
            guess[count:],
            [along(self.problem, guess, direction)],
            near=near,
        )

    def matrix(self, at: Evaluated) -> Floats:
        """Scaled derivatives of the equations by unknowns and place, shape (N, N + 1)."""
        scale = self.problem.scale
        both = np.hstack([at.by_unknowns * scale, at.by_places])
        return np.asarray(both / scale[:, None])

    def point(self, solution: Solution, direction: Floats) -> Point:
        """A point with the tangent that has a component along a direction."""
        tangent = np.linalg.svd(self.matrix(solution.at))[2][-1]
        if direction @ tangent < 0.0:
            tangent = -tangent
        return Point(solution, self.problem, tangent)

    def tests(self, point: Point) -> dict[str, float]:
        """Functions that change sign where bifurcations are."""
        problem = self.problem
        if isinstance(problem, Locus):
            return problem.degenerate(point.solution, point.at)
        spectrum = problem.decisive(point.at.spectrum)
        result = {"fold": float(point.tangent[-1])}
        bordered = np.vstack([self.matrix(point.at), point.tangent])
        # the least singular value with a sign: smooth, of any size of the equations
        least = np.linalg.svd(bordered, compute_uv=False)[-1]
        result["branch point"] = float(np.linalg.slogdet(bordered)[0] * least)
        if isinstance(problem, Equilibrium):
            result["hopf"] = pair_product(spectrum, True)
        else:
            terms = (1.0 + spectrum) / (1.0 + np.abs(spectrum))
            result["period doubling"] = float(np.prod(terms).real)
            result["neimark-sacker"] = pair_product(spectrum, False)
        return result

    def _test(self, kind: str, point: Point) -> float:
        return self.tests(point)[kind]

    def follow(
        self,
        start: Solution,
        sense: float,
        first: float,
        watch: Watch | None = None,
        direction: Floats | None = None,
        branch: Branch | None = None,
    ) -> Branch:
        """Follow a branch from a solution.

        `sense`: 1 to greater places at first, −1 to smaller ones; of no account with a direction.
        `first`: length of the first step.
        `watch`: told of each point, as soon as it is one of the branch.
        `direction`: of the first step, in scaled unknowns and places.
        `branch`: what gets the points; another one if not given.
        """
        branch = Branch(self.problem) if branch is None else branch

        def add(point: Point) -> None:
            branch.points.append(point)
            if watch:
                watch(branch, point)

        def end(reason: str, text: str) -> Branch:
            branch.ends.append(End(reason, text))
            return branch

        if direction is None:
            direction = np.zeros(len(start.unknowns) + 1)
            direction[-1] = sense
        here = self.clear(self.point(start, direction))
        branch.points.append(here)
        track = Track(self)
        track.add(here)
        trail = [here]
        step, count = min(first, self.limits.longest_step), 0
        while count < self.limits.points:
            if step < SHORTEST:
                return end("no way on", "steps became too short")
            step = min(step, self._to_the_edge(here))
            ahead = self._ahead(trail, step)
            if ahead is None:
                step /= 2.0
                continue
            there, specials = ahead
            for special in specials:
                if special.kind == MERGING:
                    add(self._doubling(special))
                    return end("merging", "the branch meets an orbit of half its period")
                add(special)
                if isinstance(self.problem, Locus):
                    what = f"the locus ends at a point of codimension two: {special.kind}"
                    return end("codimension two", what)
            if not there.inside:
                branch.points.append(self._edge(here, there))
                return end("range", "the end of the range is reached")
            add(there)
            count += 1
            if not self.limits.unstable and not self.problem.stable(there.at.spectrum):
                return end("stability", "the branch has lost its stability")
            if self._closed(branch, count):
                return end("closed", "the branch has returned to its beginning")
            if there.solution.iterations <= FEW:
                step = min(step * LONGER, self.limits.longest_step)
            elif there.solution.iterations >= MANY:
                step /= SHORTER
            here = self.clear(there)
            trail = [*trail[1 - LOOKED_BACK :], here] if here is there else [here]
            track.add(here)
            step = min(step, track.longest())
            if track.arrived:
                special, beyond = passed(self, track)
                add(special)
                if beyond is None:
                    return end("grazing", "no orbit was found on the other side of grazing")
                here, step = self.clear(beyond), first
                trail = [here]
                branch.points.append(here)
                track = Track(self)
        return end("points", f"{self.limits.points} points are computed")

    def _ahead(self, trail: Sequence[Point], step: float) -> tuple[Point, list[Point]] | None:
        """The next point and the special ones before it; None if the step is too long for that."""
        here = trail[-1]
        try:
            there = self.next_point(trail, step)
            more = abs(contacts(there.at.changes) - contacts(here.at.changes))
            if there.tangent @ here.tangent < MOST_TURN or more > MOST_CONTACTS:
                return None
            return there, self._between(here, there)
        except NotConvergedError:
            return None

    def _to_the_edge(self, point: Point) -> float:
        """Length of a step just over the end of the range; far beyond, parameters may be wrong."""
        places = point.solved
        moves = point.tangent[-len(places) :]
        with np.errstate(divide="ignore"):
            steps = np.where(moves > 0.0, 1.0 - places, -places) / moves
        return max(float(np.min(steps[moves != 0.0], initial=np.inf)) * OVER, SHORTEST_TO_EDGE)

    def clear(self, point: Point) -> Point:
        """The same point with nodes that are away from changes of contacts."""
        problem = self.problem
        if not isinstance(problem, Orbit | Locus):
            return point
        delay = problem.clearest(point.solution)
        if not delay:
            return point
        later, unknowns, moved = problem.later(point.solution, delay)
        scaled = np.append(problem.scale, 1.0)
        direction = np.append(moved @ (scaled * point.tangent) / later.scale, point.tangent[-1])
        self.problem = later
        guess = np.concatenate([unknowns / later.scale, point.solution.places])
        return self.point(self.corrected(guess, direction / np.linalg.norm(direction)), direction)

    def next_point(self, trail: Sequence[Point], step: float) -> Point:
        """The point at a distance along the branch, whose last points are known, from the last."""
        here = trail[-1]
        guess = _hermite([(self.vector(p.solution), p.tangent) for p in trail], step)
        solution = self.corrected(guess, here.tangent, here.at)
        return self.point(solution, here.tangent)

    def _closed(self, branch: Branch, count: int) -> bool:
        """Whether the last step led past the first point of this direction."""
        points = [p for p in branch.points if p.problem is self.problem and not p.kind]
        if count < 5 or points[0] is not branch.points[0]:
            return False
        first, before, last = (self.vector(p.solution) for p in (points[0], *points[-2:]))
        chord = last - before
        part = (first - before) @ chord / (chord @ chord)
        return bool(0.0 <= part <= 1.0) and bool(
            np.abs(before + part * chord - first).max() < 1e-3 * np.linalg.norm(chord) + 1e-6
        )

    def _between(self, here: Point, there: Point) -> list[Point]:
        """Special points between two neighbouring ones, in their order."""
        result: list[tuple[float, Point]] = []
        before, after = self.tests(here), self.tests(there)
        for kind, value in before.items():
            # with energy conserved some vanish everywhere, but for round-off
            if value * after[kind] < 0.0 and min(abs(value), abs(after[kind])) > ROUND_OFF:
                locate = self._near_singular if kind == "branch point" else self.located
                place, point = locate(here, there, partial(self._test, kind))
                if self._confirmed(kind, point, here):
                    result.append((place, replace(point, kind=self._kind(kind, point))))
        # where a symmetric branch crosses, the other one turns round: one point, located as a fold
        crossings = [place for place, point in result if point.kind in CROSSINGS]
        folds = [pair for pair in result if pair[1].kind == "fold"]
        for pair in folds:
            if any(abs(pair[0] - place) < COINCIDENT for place in crossings):
                kind = next(p.kind for _, p in result if p.kind in CROSSINGS)
                result = [other for other in result if other[1].kind not in (*CROSSINGS, "fold")]
                result.append((pair[0], replace(pair[1], kind=kind)))
        result += self._contact_changes(here, there)
        return [point for _, point in sorted(result, key=lambda pair: pair[0])]

    def between(self, here: Point, there: Point, part: float) -> Point:
        """The point of a branch between two of its points, at a part of the way."""
        ends = [(self.vector(point.solution), point.tangent) for point in (here, there)]
        chord = ends[1][0] - ends[0][0]
        length = float(np.linalg.norm(chord))
        guess = _hermite(ends, (part - 1.0) * length)
        near = here if part < 0.5 else there
        return self.point(self.corrected(guess, chord / length, near.at), chord)

    def located(
        self, here: Point, there: Point, test: Callable[[Point], float]
    ) -> tuple[float, Point]:
        """Where a function of the points between two of them is zero, as a part of the way."""
        known: dict[float, Point] = {0.0: here, 1.0: there}

        def at(part: float) -> float:
            if part not in known:
                known[part] = self.between(here, there, part)
            return test(known[part])

        # errors of the integration would let a closer bracket be halved again and again
        xtol = max(NOISE * self.problem.shooting.run.rtol, 1e-15)
        part = float(brentq(at, 0.0, 1.0, xtol=xtol, rtol=4 * np.finfo(float).eps, maxiter=60))
        if part not in known:
            known[part] = self.between(here, there, part)
        return part, known[part]

    def _near_singular(
        self, here: Point, there: Point, test: Callable[[Point], float]
    ) -> tuple[float, Point]:
        """As `located`, where equations are singular at the zero: from points on both sides.

        Branches and functions are interpolated by polynomials, which is as precise as Newton's
        method is away from the zero.
        """
        low, high = 0.0, 1.0
        first = test(here)
        for part in np.linspace(0.0, 1.0, CLOSE)[1:-1]:
            if test(self.between(here, there, float(part))) * first > 0.0:
                low = float(part)
            else:
                high = float(part)
                break
        middle, half = 0.5 * (low + high), high - low
        nodes = np.cos(np.pi * (np.arange(SIDES) + 0.5) / SIDES)
        points = [self.between(here, there, float(middle + half * node)) for node in nodes]
        rows = np.array([[test(p), *self.vector(p.solution), *p.tangent] for p in points])
        polynomial = interpolant(nodes, rows)
        place = float(brentq(lambda x: polynomial(x)[0], -1.0, 1.0, xtol=1e-15))
        count = len(here.tangent)
        row = polynomial(place)
        vector, tangent = row[1 : 1 + count], row[1 + count :]
        unknowns, places = vector[:-1] * self.problem.scale, vector[-1:]
        at = self.problem.evaluate(unknowns, places, points[0].at)
        solution = Solution(unknowns, places, at, 0, np.concatenate([unknowns, places]))
        tangent /= np.linalg.norm(tangent)
        return middle + half * place, Point(solution, self.problem, tangent)

    def _confirmed(self, kind: str, point: Point, before: Point) -> bool:
        """Whether a sign of a test function changed at a bifurcation, not at a pole."""
        if isinstance(self.problem, Locus):
            return abs(self.tests(point)[kind]) < DEGENERATE
        spectrum = self.problem.decisive(point.at.spectrum)
        if not len(spectrum):
            return False
        if kind == "period doubling":
            return bool(np.abs(spectrum + 1.0).min() < ON_CIRCLE)
        if kind == "neimark-sacker":
            complex_ones = spectrum[np.abs(spectrum.imag) > ON_CIRCLE]
            near = np.abs(np.abs(complex_ones) - 1.0)
            return bool(len(near) and near.min() < ON_CIRCLE)
        if kind == "hopf":
            turning = spectrum[np.abs(spectrum.imag) > ON_CIRCLE * np.abs(spectrum).max()]
            return bool(len(turning) and np.abs(turning.real / turning.imag).min() < ON_CIRCLE)
        singular = np.linalg.svd(self.matrix(point.at), compute_uv=False)
        if kind == "branch point":
            return bool(singular[-1] < 1e-5 * np.linalg.norm(self.matrix(before.at)))
        return bool(abs(point.tangent[-1]) < 1e-6)

    def _kind(self, kind: str, point: Point) -> str:
        """A branch point at which a symmetric orbit loses its symmetry has a name of its own."""
        problem = self.problem
        if kind != "branch point" or not isinstance(problem, Orbit):
            return kind
        states = _states(problem, point)
        if _repeats(problem, states):
            return MERGING
        return "symmetry breaking" if _symmetric(problem, states) else kind

    def _doubling(self, point: Point) -> Point:
        """The period doubling at which a branch ends, located on the orbits of half its period.

        Its own equations are singular there.
        """
        problem, places = self.problem, point.solution.places
        assert isinstance(problem, Orbit)
        result = replace(point, kind="period doubling")
        if not problem.periods or problem.periods % 2:
            return result
        half = Orbit(problem.shooting, problem.periods // 2, problem.nodes, phase=problem.phase)
        unit = problem.period(point.solution.unknowns, places) / problem.periods
        states = [problem.state(point.solution.unknowns)]
        for first, last in pairwise(unit * half.fractions()[:-1]):
            shot = half.shooting.shoot(places, states[-1], last - first, start=first)
            states.append(half.shooting.within_turn(shot.end))
        walk = Continuation(half, self.limits, self.solver)
        try:
            middle = walk.solver(half, np.concatenate(states), places, near=None)
            along_place = np.append(np.zeros(len(middle.unknowns)), 1.0)
            here = walk.point(middle, along_place)
            before, after = (walk.next_point([here], side * BESIDE) for side in (-1.0, 1.0))
            test = partial(walk._test, "period doubling")
            return replace(walk.located(before, after, test)[1], kind="period doubling")
        except (ValueError, ComputationError):  # the sign does not change, or no orbit is there
            return result

    def _edge(self, here: Point, there: Point) -> Point:
        """Where the branch leaves the range."""
        which = int(np.argmax(np.abs(there.solved - 0.5)))
        edge = 1.0 if there.solved[which] > 1.0 else 0.0
        return self.located(here, there, lambda point: float(point.solved[which] - edge))[1]

    def _contact_changes(self, here: Point, there: Point) -> list[tuple[float, Point]]:
        """Where contacts change between two points, each with its part of the way."""
        problem = self.problem
        result: list[tuple[float, Point]] = []
        if not isinstance(problem, Orbit):
            return result
        period = problem.period(here.solution.unknowns, here.solution.places)
        first, done = here, 0.0
        while len(result) < MOST_CONTACTS:
            found = difference(first.at.changes, there.at.changes, period, problem.rigid)
            if found is None:
                break
            try:
                if not np.isfinite(found.time):
                    raise ValueError(found.kind)
                part, point = self.located(first, there, partial(self._miss, found))
            except (ValueError, ComputationError):
                part, point = self._halved(first, there)
            done += part * (1.0 - done)
            time = found.time / period
            own = replace(point, kind=found.kind, about=found.name, time=time)
            result.append((done, own))
            if point is there:
                break
            try:
                behind = self.between(point, there, BEHIND)
            except ComputationError:
                break
            if sequence(behind.at.changes) == sequence(first.at.changes):
                break
            first = behind
        return result

    def _miss(self, found: Difference, point: Point) -> float:
        """Extremum of what a switch watches, the one that a new contact or a gap grows out of."""
        problem = self.problem
        assert isinstance(problem, Orbit)
        shots = problem.shots(
            point.solution.unknowns,
            point.solution.places,
            point.at,
            tangents=False,
            guards=[extremum_guard(found.name)],
        )
        period = problem.period(point.solution.unknowns, point.solution.places)
        wanted = [m for m in misses(shots, found.name) if m.highest == (found.kind == "grazing")]
        if not wanted:
            raise ValueError("no extremum there")

        def apart(time: float) -> float:
            return abs((time - found.time + 0.5 * period) % period - 0.5 * period)

        return min(wanted, key=lambda miss: apart(miss.time)).value

    def _halved(self, here: Point, there: Point) -> tuple[float, Point]:
        """Where contacts change, by halving the way between two points."""
        own, low, high = sequence(here.at.changes), 0.0, 1.0
        best = there
        while high - low > 1e-12:
            middle = 0.5 * (low + high)
            try:
                point = self.between(here, there, middle)
            except NotConvergedError:
                break
            if sequence(point.at.changes) == own:
                low = middle
            else:
                high, best = middle, point
        return high, best


def _hermite(trail: Sequence[tuple[Floats, Floats]], beyond: float) -> Floats:
    """Hermite's interpolation of points with unit tangents, at a distance beyond the last one."""
    points = np.array([point for point, _ in trail])
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    places = np.concatenate([[0.0], np.cumsum(lengths)])
    both = np.array(trail).reshape(2 * len(trail), -1)
    return np.asarray(KroghInterpolator(np.repeat(places, 2), both)(places[-1] + beyond))


def _states(problem: Orbit, point: Point) -> Floats:
    """States at equal distances on an orbit, an even number of them, shape (…, x)."""
    shots = problem.shots(
        point.solution.unknowns, point.solution.places, point.at, tangents=False, samples=16
    )
    return np.concatenate([problem.shooting.states(shot.motion) for shot in shots])


def _repeats(problem: Orbit, states: Floats) -> bool:
    """Whether the second half of an orbit is the first one again."""
    half = len(states) // 2
    return _same(problem, states[half:] - states[:half])


def _symmetric(problem: Orbit, states: Floats) -> bool:
    """Whether the second half of an orbit is the mirror image of the first."""
    half = len(states) // 2
    sums = states[:half] + states[half:]
    still = np.ptp(states, axis=0) < 1e-6 * problem.shooting.scale
    return _same(problem, sums - sums[0]) and not still.all()


def _same(problem: Orbit, apart: Floats) -> bool:
    """Whether differences of states vanish, but for whole turns and what is far from round-off."""
    return bool(problem.shooting.distances(apart).max() < ALIKE)
