"""Follows branches through solutions, and those that leave them, each once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from linkages.errors import ComputationError
from linkages.options.analysis_options import FollowOptions
from linkages.orbits.arclength import PREFIXES, Branch, Continuation, End, Limits, Point
from linkages.orbits.equations import Orbit, Problem, Solution, along
from linkages.orbits.search import Found, at_start, nodes_for, orbit_near, same_orbit

Floats = NDArray[np.float64]

FIRST_STEP = 0.01
"""Length of the first step of a branch."""

ASIDE = 2e-3
"""Amplitudes by which a branch that leaves another one begins beside it."""

MOST_BRANCHES = 200
"""Of one call."""

SAME, SAME_STATE = 1e-6, 1e-3
"""Differences of places and of states, in amplitudes, of special points that are the same."""


@dataclass(eq=False)
class Beginning:
    """Where a branch begins: a solution, a direction, and the label of the point it leaves."""

    problem: Problem
    solution: Solution
    direction: Floats | None = None
    parent: str = ""
    sense: float = 1.0
    step: float = FIRST_STEP


@dataclass(eq=False)
class Following:
    """Follows a branch and what leaves it."""

    run: FollowOptions
    solver: Callable[..., Solution]
    watch: Callable[[Branch, Point], None] | None = None
    branches: list[Branch] = field(default_factory=list)  # followed so far
    notes: list[str] = field(default_factory=list)  # what could not be done, as sentences
    labels: Counter[str] = field(default_factory=Counter)
    _special: list[Point] = field(default_factory=list)
    _left: set[str] = field(default_factory=set)
    _met: set[str] = field(default_factory=set)

    def everything(self, starts: Iterable[Found]) -> None:
        """Follow the branches through solutions both ways, and those that leave them, each once."""
        for start in starts:
            if not self._passed(start):
                self._from(start)

    def _passed(self, found: Found) -> bool:
        """Whether a branch leads through an orbit."""
        known = [branch for branch in self.branches if branch.periods == found.periods]
        points = at_start(found)[0] if known else np.zeros((0, 0))
        place, shooting = found.solution.places, found.problem.shooting

        for one, other in (pair for branch in known for pair in pairwise(branch.points)):
            low, high = sorted([one.place, other.place])
            if not low - SAME <= place[0] <= high + SAME:
                continue
            step = shooting.within_turn(other.at.beginning - one.at.beginning)
            part = (place[0] - one.place) / ((other.place - one.place) or 1.0)
            between = one.at.beginning + part * step
            away = float(shooting.distances(points - between).min())
            if away < SAME_STATE:
                return True
            if away < shooting.distances(step):  # the branch bends there
                with suppress(ComputationError):
                    count = found.periods
                    there = orbit_near(shooting, place, between, count, solver=self.solver)
                    if same_orbit(there, found):
                        return True
        return False

    def _from(self, start: Found) -> None:
        """Follow the branch through a solution both ways, then those that leave it."""
        waiting = [Beginning(start.problem, start.solution)]
        while waiting:
            beginning = waiting.pop(0)
            if beginning.parent in self._met:
                continue  # another branch has come from there
            branch = self.both_ways(beginning) if not beginning.parent else self._one(beginning)
            self.branches.append(branch)
            if self.run.switch:
                for point in branch.points:
                    if point.label and point.label not in self._left:
                        self._left.add(point.label)
                        waiting += self._leaving(point, branch)
            if len(self.branches) >= MOST_BRANCHES and waiting:
                self.notes.append(f"{len(waiting)} further branches were not followed")
                break

    def _known(self, point: Point) -> Point | None:
        """A special point of another branch that is the same, if there is one."""
        for other in self._special:
            if other.kind == point.kind and abs(other.place - point.place) < SAME:
                shooting, states = point.problem.shooting, point.at.beginning[None]
                if isinstance(point.problem, Orbit):  # it may begin at another of its periods
                    states = at_start(Found(point.problem, point.solution))[0]
                if shooting.distances(states - other.at.beginning).min() < SAME_STATE:
                    return other
        return None

    def _limits(self, problem: Problem) -> Limits:
        periods = getattr(problem, "periods", None) or 1
        return Limits(
            points=self.run.points,
            longest_step=self.run.largest_step * periods**-1.5,
            unstable=self.run.unstable,
        )

    def _one(self, beginning: Beginning) -> Branch:
        """A branch from its beginning on, in one direction."""
        branch = Branch(beginning.problem, parent=beginning.parent)
        if not 0.0 <= beginning.solution.places[0] <= 1.0:
            branch.ends.append(End("range", "the branch begins outside of the range"))
            return branch
        walk = Continuation(beginning.problem, self._limits(beginning.problem), self.solver)
        try:
            walk.follow(
                beginning.solution,
                beginning.sense,
                beginning.step,
                self._labelled,
                beginning.direction,
                branch,
            )
        except KeyboardInterrupt:
            branch.ends.append(End("interrupted", "somebody stopped it here"))
            self.branches.append(branch)
            raise
        except ComputationError as error:
            if not branch.points:
                raise
            branch.ends.append(End("no way on", str(error)))
        return branch

    def both_ways(self, beginning: Beginning) -> Branch:
        """A branch through a solution inside the range, or from its end inwards."""
        place = float(beginning.solution.places[0])
        senses = [1.0, -1.0] if 0.0 < place < 1.0 else [1.0 if place <= 0.0 else -1.0]
        parts = [self._one(replace(beginning, sense=sense)) for sense in senses]
        if len(parts) == 1 or parts[0].ends[-1].reason == "closed":
            return parts[0]
        forward, backward = parts
        result = Branch(beginning.problem, parent=beginning.parent)
        turned = [replace(point, tangent=-point.tangent) for point in reversed(backward.points)]
        result.points = turned[:-1] + forward.points
        result.ends = [*backward.ends, *forward.ends]
        return result

    def _labelled(self, branch: Branch, point: Point) -> None:
        """Give special points their labels, in the order in which they are found."""
        if point.kind and not point.label:
            known = self._known(point)
            if known is None:
                prefix = PREFIXES[point.kind]
                self.labels[prefix] += 1
                branch.points[-1] = replace(point, label=f"{prefix}{self.labels[prefix]}")
                self._special.append(branch.points[-1])
            else:  # from the side of another branch
                branch.points[-1] = replace(point, label=known.label)
                self._met.add(known.label)
        if self.watch:
            self.watch(branch, branch.points[-1])

    def _leaving(self, point: Point, branch: Branch) -> Iterator[Beginning]:
        """Beginnings of the branches that leave a special point of a branch."""
        try:
            match point.kind:
                case "period doubling" if (
                    Found(point.problem, point.solution).periods != branch.periods
                ):
                    yield Beginning(point.problem, point.solution)  # which this one ends at
                case "period doubling":
                    yield from self._doubled(point)
                case "branch point" | "symmetry breaking":
                    yield from self._crossing(point)
                case "hopf":
                    yield from self._cycle(point)
        except ComputationError as error:
            self.notes.append(f"the branch that leaves {point.label} was not found: {error}")

    def _doubled(self, point: Point) -> Iterator[Beginning]:
        """The orbit of twice the period that leaves a period doubling."""
        old = point.problem
        assert isinstance(old, Orbit)
        periods = None if old.periods is None else 2 * old.periods
        if periods is not None and periods > self.run.longest:
            self.notes.append(
                f"the branch of {periods} periods at {point.label} was not followed: "
                f"longest is {self.run.longest}"
            )
            return
        spectrum = old.decisive(point.at.spectrum)
        value = spectrum[np.argmin(np.abs(spectrum + 1.0))]
        if value.real > 0.0:
            return  # met from the side of twice the period
        column = int(np.argmin(np.abs(point.at.spectrum - value)))
        vector = point.at.vectors[:, column].real
        vector = vector / np.abs(vector / old.shooting.scale).max()
        nodes = max(2 * old.nodes, nodes_for(periods)) if periods else 2 * old.nodes
        problem = old.doubled(nodes)
        states, aside = self._twice(old, problem, point, vector)
        amplitude = ASIDE / (problem.periods or 1)
        ends = (2.0 * point.solution.unknowns[-1:],) if problem.free else ()
        base = np.concatenate([states.ravel(), *ends])
        away = np.concatenate([aside.ravel(), *(np.zeros(1) for _ in ends)])
        yield self._beside(problem, base, away, amplitude, point, problem.periods or 1)

    def _twice(
        self, old: Orbit, problem: Orbit, point: Point, vector: Floats
    ) -> tuple[Floats, Floats]:
        """States of an orbit run through twice, at the nodes of another, and a direction there."""
        shooting, solution = old.shooting, point.solution
        unit = old.period(solution.unknowns, solution.places) / (old.periods or 1)
        span = problem.fractions()[1] - problem.fractions()[0]
        if problem.free:
            span = 2.0 / problem.nodes
        state, states, aside = old.state(solution.unknowns), [], []
        held = solution.at.shots[-1].held or None
        for node in range(problem.nodes):
            states.append(state)
            aside.append(vector)
            shot = shooting.shoot(
                solution.places,
                state,
                span * unit,
                start=0.0 if old.free else float(unit * problem.fractions()[node]),
                held=held,
            )
            state, held = shooting.within_turn(shot.end), shot.held
            vector = shot.by_state @ vector
        return np.array(states), np.array(aside)

    def _beside(
        self,
        problem: Problem,
        base: Floats,
        away: Floats,
        amplitude: float,
        point: Point,
        periods: int,
    ) -> Beginning:
        """The beginning of a branch that leaves a point in a direction."""
        scaled = np.append(away / problem.scale, 0.0)
        length = float(np.linalg.norm(scaled))
        direction = scaled / length
        guess = np.append(base / problem.scale, point.solution.places) + amplitude * direction
        solution = self.solver(
            problem,
            guess[:-1] * problem.scale,
            guess[-1:],
            [along(problem, guess, direction)],
        )
        return Beginning(problem, solution, direction, point.label, step=FIRST_STEP * periods**-1.5)

    def _crossing(self, point: Point) -> Iterator[Beginning]:
        """Both directions of the other branch through a branch point."""
        walk = Continuation(point.problem, self._limits(point.problem), self.solver)
        vectors = np.linalg.svd(walk.matrix(point.at))[2][-2:]
        # in the plane of both tangents, normal to that of the branch
        inside = vectors.T @ (vectors @ point.tangent)
        inside /= np.linalg.norm(inside)
        other = vectors[0] - (vectors[0] @ inside) * inside
        if np.linalg.norm(other) < 0.1:
            other = vectors[1] - (vectors[1] @ inside) * inside
        other /= np.linalg.norm(other)
        for side in (1.0, -1.0):
            guess = walk.vector(point.solution) + side * ASIDE * other
            solution = walk.corrected(guess, side * other, point.at)
            yield Beginning(point.problem, solution, side * other, point.label)

    def _cycle(self, point: Point) -> Iterator[Beginning]:
        """The limit cycle that leaves an equilibrium at a Hopf point."""
        old = point.problem
        spectrum = point.at.spectrum
        turning = np.where(np.abs(spectrum.imag) > 0.0, np.abs(spectrum.real), np.inf)
        which = int(np.argmin(turning))
        frequency = abs(spectrum[which].imag)
        vector = point.at.vectors[:, which]
        shooting = old.shooting
        vector = vector / np.abs(vector / shooting.scale).max()
        start = old.state(point.solution.unknowns)
        flow = (spectrum[which] * vector).real
        reference = (start + ASIDE * vector.real, ASIDE * flow)
        problem = Orbit(shooting, None, 1, reference=reference)
        base = np.append(start, 2 * np.pi / frequency)
        yield self._beside(problem, base, np.append(vector.real, 0.0), ASIDE, point, 1)
