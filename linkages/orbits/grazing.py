"""Branches of orbits where a rigid contact begins: impacts at a rate that tends to zero.

The map of a period has a square root there, and its derivative grows without bound as the rate v of
the impact tends to zero. Orbits are smooth functions of v on one side, and of the gap that is left
on the other. Points are placed so that these quantities fall geometrically, the grazing orbit is
extrapolated from the side without the impact, and the other side begins at a given small v, where
Newton's method converges as v² is an equation of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BarycentricInterpolator

from linkages.errors import ComputationError
from linkages.orbits.contact_events import (
    misses,
    switch_named,
    touch_rates,
    watched_function,
    watched_rate,
)
from linkages.orbits.equations import Evaluated, NotConvergedError, Orbit, Solution
from linkages.orbits.shooting import Shot

if TYPE_CHECKING:
    from linkages.orbits.arclength import Continuation, Point

Floats = NDArray[np.float64]

AIM = 0.75
"""Part of the way to a grazing orbit of the next step."""

FINE_GAP, FINE_RATE = 1e-5, 1e-3
"""Parts of the usual gap and rate at which a grazing orbit is extrapolated."""

MOST, FEWEST = 7, 4
"""Points from which it is extrapolated."""

ASIDE = 1e-6
"""Amplitudes by which states are moved to lose an impact."""

FIRST_RATE = 1e-3
"""Part of the usual rate of the first impact behind a grazing orbit."""


@dataclass(frozen=True)
class Near:
    """The impact or the near miss of an orbit that is closest to grazing."""

    name: str  # of the switch
    time: float  # in seconds
    touches: bool  # whether it is an impact
    value: float  # its rate in m/s or rad/s, or the gap that is left in m or rad
    part: float  # the same in parts of what is usual in the orbit
    # Second derivative of the indentation at a near miss, which is negative
    curvature: float = np.nan

    def continues(self, before: Near, period: float) -> bool:
        """Whether this is what was near at the point before."""
        apart = (self.time - before.time + 0.5 * period) % period - 0.5 * period
        same = self.name == before.name and self.touches == before.touches
        return same and abs(apart) < 0.1 * period


def nearest(problem: Orbit, at: Evaluated, period: float) -> Near | None:
    """What is closest to grazing; None if nothing rigid is near."""
    touches = touch_rates(at.shots, problem.rigid)
    result: list[Near] = []
    for name in problem.rigid:
        own = [(time, rate) for other, time, rate in touches if other == name]
        found = misses(at.shots, name)
        size = max((abs(miss.value) for miss in found), default=0.0)
        usual = max([size * 2 * np.pi / period, *(rate for _, rate in own)])
        result += [Near(name, time, True, rate, rate / usual) for time, rate in own]
        result += [
            Near(name, miss.time, False, -miss.value, -miss.value / size, miss.second)
            for miss in found
            if miss.highest
            and miss.value < 0.0
            and all(abs(miss.time - time) > 1e-9 * period for time, _ in own)
        ]
    return min(result, key=lambda near: near.part, default=None)


class Track:
    """Points of a branch that come closer to grazing, one after the other."""

    def __init__(self, walk: Continuation) -> None:
        self._walk = walk
        self.points: list[tuple[Near, Point]] = []

    def add(self, point: Point) -> None:
        """Take the next point of the branch."""
        problem = point.problem
        if not isinstance(problem, Orbit) or not problem.rigid:
            return
        period = problem.period(point.solution.unknowns, point.solution.places)
        near = nearest(problem, point.at, period)
        if near is None:
            self.points = []
            return
        if self.points:
            before, last = self.points[-1]
            if (
                last.problem is not problem
                or not near.continues(before, period)
                or near.value >= before.value
            ):
                self.points = []
        self.points.append((near, point))

    @property
    def near(self) -> Near:
        """What is near at the last point."""
        return self.points[-1][0]

    def longest(self) -> float:
        """Length of the next step that does not lead beyond grazing."""
        if len(self.points) < 2:
            return np.inf
        (first, before), (last, here) = self.points[-2:]
        length = np.linalg.norm(
            self._walk.vector(here.solution) - self._walk.vector(before.solution)
        )
        return float(AIM * last.value * length / (first.value - last.value))

    @property
    def arrived(self) -> bool:
        """Whether the grazing orbit can be extrapolated."""
        fine = FINE_RATE if self.points and self.near.touches else FINE_GAP
        return len(self.points) >= FEWEST and self.near.part < fine

    def limit(self) -> tuple[Floats, Floats]:
        """Scaled unknowns and place of the grazing orbit, and the tangent there."""
        last = self.points[-MOST:]
        values = np.array([near.value for near, _ in last])
        rows = np.array([[*self._walk.vector(p.solution), *p.tangent] for _, p in last])
        row = interpolant(values / values[0], rows)(0.0)
        count = rows.shape[1] // 2
        return row[:count], row[count:]

    def _part(self, near: Near) -> float:
        """Time of what is near as a part of the period."""
        solution, problem = self.points[-1][1].solution, self.points[-1][1].problem
        return near.time / (problem.period(solution.unknowns, solution.places) or 1.0)

    def orbit(self) -> Point:
        """The grazing orbit, with the equations of the last point."""
        near, here = self.points[-1]
        vector, tangent = self.limit()
        unknowns = vector[:-1] * here.problem.scale
        before = np.concatenate([unknowns, vector[-1:]])
        solution = Solution(unknowns, vector[-1:], here.at, 0, before)
        return replace(
            here,
            solution=solution,
            tangent=tangent / np.linalg.norm(tangent),
            kind="grazing",
            about=near.name,
            time=self._part(near),
        )


def passed(walk: Continuation, track: Track) -> tuple[Point, Point | None]:
    """The grazing orbit that a track comes to, and a point of the branch on its other side."""
    if not track.near.touches:
        orbit = track.orbit()
        try:
            return orbit, _touching(walk, track)
        except ComputationError:
            return orbit, None
    orbit = track.orbit()
    try:
        free = _missing(walk, track, orbit)
        own = _approached(walk, free)
    except ComputationError:
        return orbit, None
    precise = own.orbit()
    away = own.points[0][1]
    return replace(precise, tangent=-away.tangent), replace(away, tangent=-away.tangent)


def _approached(walk: Continuation, start: Point) -> Track:
    """A track from a point without the impact to the grazing orbit."""
    track = Track(walk)
    track.add(start)
    here, step = start, 0.1 * abs(track.near.part)
    for _ in range(40):
        there = walk.next_point([here], min(step, track.longest()))
        track.add(there)
        here = there
        if track.arrived:
            return track
    raise NotConvergedError("the grazing orbit was not reached", time=0.0)


def _missing(walk: Continuation, track: Track, orbit: Point) -> Point:
    """An orbit without the impact near a grazing one, with its tangent towards that."""
    problem, last = track.points[-1][1].problem, track.points[-1][1]
    assert isinstance(problem, Orbit)
    count = len(last.at.changes)
    vector = walk.vector(orbit.solution)
    free = None
    for k in range(2 * len(vector)):
        moved = vector.copy()
        moved[k // 2] += ASIDE if k % 2 else -ASIDE
        at = problem.evaluate(moved[:-1] * problem.scale, moved[-1:], last.at)
        if len(at.changes) < count:
            free = at
            break
    if free is None:
        raise NotConvergedError("no motion near misses the contact", time=0.0)
    matrix = walk.matrix(free)
    towards = np.linalg.svd(matrix)[2][-1]
    for side in (1.0, -1.0):
        direction = side * towards
        for length in (1e-3, 1e-2):
            try:
                solution = walk.corrected(vector - length * direction, direction, free)
            except NotConvergedError:
                continue
            if len(solution.at.changes) < count:
                return walk.point(solution, direction)
    raise NotConvergedError("no orbit without the impact was found", time=0.0)


def _touching(walk: Continuation, track: Track) -> Point:
    """An orbit with a slow impact beside the grazing one, with its tangent away from that."""
    near, last = track.points[-1]
    problem = last.problem
    assert isinstance(problem, Orbit)
    if problem.nodes > 1:
        raise NotConvergedError("orbits of several parts end at grazing", time=0.0)
    orbit = track.orbit()
    linear = _Linear(problem, last, near)  # at the grazing orbit itself the contact may close
    usual = (
        near.value
        / near.part
        * 2
        * np.pi
        / problem.period(orbit.solution.unknowns, orbit.solution.places)
    )
    vector = walk.vector(orbit.solution)
    first, second = (linear.solved(walk, k * FIRST_RATE * usual, vector) for k in (1, 2))
    direction = walk.vector(second) - walk.vector(first)
    return walk.point(second, direction / np.linalg.norm(direction))


class _Linear:
    """Orbits with an impact at a small rate v beside a grazing one, to first order in v.

    The end of a period is that of the motion without the impact, and the jump of the impact carried
    along; the highest indentation of the motion without the wall is v²/(2a), a being the
    deceleration there.
    """

    def __init__(self, problem: Orbit, point: Point, near: Near) -> None:
        self._problem, self._near, self._grazing = problem, near, point.at
        solution, shooting = point.solution, problem.shooting
        places, state = solution.places, problem.state(solution.unknowns)
        period = problem.period(solution.unknowns, places)
        start = 0.0 if problem.free else problem.phase * period / (problem.periods or 1)
        self._delay = (near.time - start) % period
        shot = shooting.shoot(
            places, state, self._delay * (1.0 - 1e-9), start=start, held=point.at.shots[-1].held
        )
        gap, jump = self._at_the_wall(shot, places, start)
        whole = point.at.shots[0].by_state
        scale = np.append(problem.scale, 1.0)
        both = np.hstack([shot.by_state, shot.by_place])
        self.row = gap @ both * scale[: both.shape[1]]
        carried = whole @ np.linalg.solve(shot.by_state, jump)
        self._carried = np.zeros(len(problem.scale))
        self._carried[: shooting.size] = carried / shooting.scale
        self.deceleration = -near.curvature

    def _at_the_wall(self, shot: Shot, places: Floats, start: float) -> tuple[Floats, Floats]:
        """Gradient of the indentation, and the jump of the state for a rate of one."""
        shooting = self._problem.shooting
        base, size = shot.end, shooting.size
        system = shooting.system_at(places, base)
        time = start + self._delay
        switch = switch_named(system.model, self._near.name)
        name = self._near.name
        own = watched_function(system.model, name), watched_rate(system.model, name)
        nodes = [*own, *switch.jump]
        names = system.model.switches.names
        held = np.array([shot.held[name][0] for name in names])
        step = 1e-7 * shooting.scale

        def values(states: Floats) -> Floats:
            """Of the nodes, shape (nodes, k), for states as columns."""
            moving = np.array([shooting.system_at(places, s).state for s in states.T]).T
            columns = np.repeat(held[:, None], states.shape[1], axis=1)
            times = np.full(states.shape[1], time)
            return np.asarray(system.evaluate(nodes, times, moving, held=columns))

        rows = values(base[:, None] + np.hstack([np.zeros((size, 1)), np.diag(step)]))
        slopes = (rows[:2, 1:] - rows[:2, :1]) / step
        n = len(shooting.system.topology.free)
        towards = np.zeros(size)
        towards[n : 2 * n] = slopes[1, n : 2 * n] * shooting.scale[n : 2 * n] ** 2
        towards /= slopes[1] @ towards
        fast = 1e-3 * float(np.abs(slopes[1] * shooting.scale).max())
        moved = base + fast * towards
        after = values(moved[:, None])[2:, 0]
        jump = np.zeros(size)
        jump[n : n + len(after)] = (after - moved[n : n + len(after)]) / fast
        return slopes[0], jump

    def solved(self, walk: Continuation, rate: float, vector: Floats) -> Solution:
        """The orbit whose impact has a rate, beside the grazing one."""
        problem = self._problem
        matrix = np.vstack([walk.matrix(self._grazing), self.row])
        target = rate**2 / (2 * self.deceleration)
        sides = np.linalg.solve(
            matrix, np.column_stack([np.append(-rate * self._carried, target),
                                     np.append(np.zeros(len(vector) - 1), 1.0)])
        )  # fmt: skip
        guess = self._adjusted(vector + sides[:, 0], sides[:, 1], target)

        row, known = self.row.copy(), None

        def condition(unknowns: Floats, places: Floats, at: Evaluated) -> tuple[float, Floats]:
            nonlocal row, known
            here = np.concatenate([unknowns / problem.scale, places])
            value = self._indentation(at.shots) - target
            if known is not None:  # the gradient of the grazing orbit, corrected by Broyden's rule
                moved = here - known[0]
                row = row + (value - known[1] - row @ moved) / (moved @ moved) * moved
            known = here, value
            return value, row

        return walk.solver(problem, guess[:-1] * problem.scale, guess[-1:], [condition])

    def _adjusted(self, guess: Floats, direction: Floats, target: float) -> Floats:
        """A guess with the indentation that is wanted, within a factor, along a direction."""
        for _ in range(20):
            shots = self._problem.shots(
                guess[:-1] * self._problem.scale,
                guess[-1:],
                tangents=False,
                guards=self._problem.guards,
            )
            apart = target - self._indentation(shots)
            if abs(apart) < 0.1 * target:
                return guess
            guess = guess + apart * direction
        raise NotConvergedError("no impact of a small rate was found", time=0.0)

    def _indentation(self, shots: Sequence[Shot]) -> float:
        """v²/(2a) of the impact, or the highest indentation of the near miss, which is negative."""
        touches = [
            (abs(time - self._near.time), rate**2 / (2 * self.deceleration))
            for name, time, rate in touch_rates(shots, [self._near.name])
        ]
        passes = [
            (abs(miss.time - self._near.time), miss.value)
            for miss in misses(shots, self._near.name)
            if miss.highest and miss.value < 0.0
        ]
        if not touches and not passes:
            raise NotConvergedError("the contact was lost", time=0.0)
        return min([*touches, *passes])[1]


def interpolant(nodes: Floats, rows: Floats) -> BarycentricInterpolator:
    """The polynomial through rows at nodes.

    Its weights are given, because SciPy multiplies their factors in a random order.
    """
    apart = np.subtract.outer(nodes, nodes) * (4.0 / np.ptp(nodes))
    np.fill_diagonal(apart, 1.0)
    return BarycentricInterpolator(nodes, rows, wi=1.0 / apart.prod(axis=1))
