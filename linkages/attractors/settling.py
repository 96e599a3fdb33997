"""A motion that is followed until its attractor is known."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from linkages.attractors.convergence import distances, recurrence, remaining
from linkages.chaos.common_period import NoPeriodError, common_period
from linkages.chaos.diagram import touchable
from linkages.chaos.free_states import circular, state_tolerances, wrapped
from linkages.chaos.lyapunov import exponents_of
from linkages.chaos.maps import sign_of
from linkages.chaos.periods import apart
from linkages.chaos.tori import FEWEST, closed_curves
from linkages.chaos.volume_contraction import Volumes
from linkages.errors import ComputationError
from linkages.kernel.outputs import VARIABLES, coordinate_of
from linkages.kernel.system import System
from linkages.options.analysis_options import BasinOptions, ExponentOptions
from linkages.solution.contact_episodes import touches_so_far
from linkages.solution.guards import Guard, Surface, free_vectors
from linkages.solution.many import Going
from linkages.solution.march import March
from linkages.solution.motion import Motion
from linkages.solution.series import Series

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

FIRST, LONGER = 32, 1.5
"""Periods of the first look at a driven motion; each further look is as much longer."""

SAMPLES, MOST_CROSSINGS = 64, 48
"""Samples of a look at a motion that nothing drives, and crossings at which the first one ends."""

BETWEEN = 0.5 * (math.sqrt(5.0) - 1.0)
"""Part of a period at which a motion at rest is looked at again; no simple period divides it."""

NOISE = 30.0
"""Tolerances of a step that errors of integration may add up to."""

AMPLITUDE = 10.0
"""Distances to its limit by which a cycle is larger, if it does not shrink to a point itself."""

EVEN = 1e-3
"""Relative difference of two cycles' durations that count as equal."""

EXPONENT_PERIODS, ALIGNING = 100, 10
"""Periods that tangents grow where no cycle was found, and before, in which they turn."""

FOLLOWED, ELSEWHERE = 60, 1e-2
"""Periods for which an attractor is followed on, and part of the range that it moves by then."""

LOOSE = 10.0
"""Units by which a driven motion at rest differs within a period."""


class Kind(IntEnum):
    """What a motion tends to."""

    FIXED_POINT = 0
    PERIODIC = 1
    QUASI_PERIODIC = 2
    CHAOTIC = 3
    UNDECIDED = 4

    @property
    def words(self) -> str:
        """As reports and files have it."""
        return ("fixed point", "periodic", "quasi-periodic", "chaotic", "undecided")[self]


@dataclass(frozen=True, eq=False)
class Settled:
    """Where a motion settles.

    `points`: of the section, angles within a turn, in the order of the motion, shape (k, x): a
    whole cycle, or the state at rest; the last ones of motions that do not repeat.
    """

    kind: Kind  # what it tends to
    period: float  # in seconds; nan for all but periodic motions
    points: Floats
    section: int  # which one: −1 for points at times, else the place in `sections`
    turns: Floats  # whole turns of free coordinates in a period, shape (n,)
    # How often each contact is touched in a period, shape (c,); nan where that is not known
    touches: Floats
    reach: Floats  # range of each entry since the start, shape (x,)
    left: float  # distance to the attractor in units of the tolerance; nan where there is none
    march: March  # the motion at its end


@dataclass(frozen=True, eq=False)
class Clock:
    """What gives a mechanism's motion its rhythm."""

    driven: bool  # whether drives or loads depend on time; their common period is `period` then
    # In seconds; where nothing depends on time the unit in which a motion is followed
    period: float

    @classmethod
    def of(cls, system: System, options: BasinOptions) -> Clock:
        """That of a system; NoPeriodError where drives have no common period."""
        mechanism = system.mechanism
        try:
            return cls(True, common_period(mechanism))
        except NoPeriodError:
            if mechanism.prescribed or not Volumes(system).autonomous:
                raise
            return cls(False, options.interval or mechanism.simulation.end)


def sections(system: System) -> tuple[Guard, ...]:
    """Surfaces that every motion crosses again and again which repeats and rests not.

    A free coordinate that moves on and on is an angle, and passes zero once a turn; another one has
    a maximum.
    """
    bodies = system.mechanism.bodies
    angles, rates = [], []
    for name in system.topology.free:
        output = coordinate_of(bodies[name].kind)
        place = {VARIABLES[output].dims[0]: name}
        value, rate = (
            Surface(Series(f"{name}.{variable}", variable, place), 0.0)
            for variable in (output, str(VARIABLES[output].rate))
        )
        if bodies[name].rotates:
            angles.append(_watching(value, 1))
        rates.append(_watching(rate, -1))
    return (*angles, *rates)


def _watching(surface: Surface, direction: int) -> Guard:
    """Crossings in one sense; of an angle once a turn, whichever way it turns."""
    return replace(
        surface.guard(direction, name=surface.series.name),
        counts=None,
        key=(*surface.key, "settling"),
    )


def require_attractors(system: System) -> None:
    """Raise where nothing dissipates: motions do not tend to anything then."""
    if Volumes(system).conservative:
        message = (
            "no force depends on a velocity: nothing dissipates, and no motion tends to an "
            "attractor; expected damping, friction or contact that takes energy"
        )
        raise system.mechanism.error([((), message)])


def settling(
    system: System, clock: Clock, options: BasinOptions, guards: Sequence[Guard] = ()
) -> Going[Settled]:
    """Follow a motion until its attractor is known, by integrations that it asks for.

    `guards`: the `sections` where nothing drives.
    Raises ComputationError if the motion cannot go on.
    """
    march = March(system, options)
    record = (_Strobed if clock.driven else _Crossed)(system, clock, options, march)
    while record.done < options.periods:
        looks = [replace(guard, wanted=record.most) for guard in guards]
        motion = yield from march.advancing(record.times(), guards=looks)
        if motion.failure is not None:
            raise ComputationError(motion.failure, time=motion.stop_time)
        record.add(motion)
        record.measure()
        found = record.found()
        if found is not None:
            return found
    asked = ExponentOptions.like(
        options, periods=EXPONENT_PERIODS, skip=ALIGNING, count=1, interval=clock.period
    )
    exponents = yield from exponents_of(march.here, asked)
    return record.endless(sign_of(exponents))


@dataclass(eq=False)
class _Record:
    """What was seen of a motion, in states with all turns; `times` says when to look next.

    `system`, `clock`, `options`, `march`: what moves, and how it is followed.
    """

    system: System
    clock: Clock
    options: BasinOptions
    march: March
    # Periods that were followed; where nothing drives, crossings of a section if there are more
    done: float = 0.0
    most: int = 0  # crossings of a section at which the next look ends
    unit: Floats = field(default_factory=lambda: np.zeros(0))
    noise: float = 0.0
    seen: list[Floats] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._angles = circular(self.system)
        self._size = len(self.system.topology.free)
        start = free_vectors(self.system, Motion(pieces=(self.march.sample,)))
        self._low, self._high = start[0].copy(), start[0].copy()
        self._atol = state_tolerances(self.system, self.march.run)
        self._begun = self.march.time
        self._contacts = len(touchable(self.system))
        self.touched: list[Floats] = []

    def _entered(self, motion: Motion) -> Floats:
        """States at the samples of a motion, shape (samples, x); their range is noted."""
        result = free_vectors(self.system, motion)
        if len(result):
            self._low = np.minimum(self._low, result.min(axis=0))
            self._high = np.maximum(self._high, result.max(axis=0))
        return result

    def _noted(self, motion: Motion) -> None:
        """Count touches up to each sample of a look."""
        if self._contacts:
            before = self.touched[-1][-1] if self.touched else np.zeros(self._contacts)
            self.touched.append(before + touches_so_far(motion))

    @property
    def reach(self) -> Floats:
        """Range of each entry since the start; of angles that repeat, a turn at most."""
        ranged = self._high - self._low
        return np.where(self._angles, np.minimum(ranged, 2 * np.pi), ranged)

    def measure(self) -> None:
        """Set the difference that counts as none, `unit`, and what errors are in units, `noise`."""
        largest = np.maximum(np.abs(self._low), np.abs(self._high))
        largest = np.where(self._angles, np.minimum(largest, 2 * np.pi), largest)
        errors = NOISE * (self._atol + self.march.run.rtol * largest)
        self.unit = np.maximum(self.options.settled * self.reach, 10.0 * errors)
        self.noise = float((errors / self.unit).max())

    def within(self, states: Floats) -> Floats:
        """The same with angles within a turn."""
        result = states.copy()
        result[:, self._angles] = wrapped(result[:, self._angles])
        return result

    def settled(
        self, kind: Kind, points: Floats, *, period: float = math.nan, section: int = -1,
        turned: Floats | None = None, touches: Floats | None = None, left: float = math.nan,
    ) -> Settled:  # fmt: skip
        turns = np.zeros(self._size)
        if turned is not None:
            turns = np.round(turned[: self._size] / (2 * np.pi)) * self._angles[: self._size]
        touches = np.full(self._contacts, np.nan) if touches is None else touches
        points = self.within(points)[-self.options.longest :]
        return Settled(kind, period, points, section, turns, touches, self.reach, left, self.march)

    def repeating(self, points: Floats) -> tuple[int, float] | None:
        """Points of a cycle that section points converge to, and what is left of the way."""
        found = recurrence(
            points, self._angles, self.unit, noise=self.noise, longest=self.options.longest
        )
        return None if found is None else (found.count, found.left)

    def without_cycle(self, points: Floats, sign: int, section: int) -> Settled:
        """What a motion is that does not repeat, by its exponent and where its points lie."""
        kind = Kind.CHAOTIC if sign > 0 else Kind.UNDECIDED
        if sign == 0 and len(points) >= 2 * FEWEST:
            later = self.within(points[len(points) // 2 :])
            if closed_curves(later, angles=self._angles).count:
                kind = Kind.QUASI_PERIODIC
        return self.settled(kind, points, section=section)


class _Strobed(_Record):
    """Of a motion that is driven: its states once a period, and once in between."""

    _points: Floats

    def times(self) -> Floats:
        """Of the next look, two in a period."""
        count = FIRST if not self.done else math.ceil((LONGER - 1.0) * self.done)
        count = min(count, self.options.periods - int(self.done))
        whole = self.done + np.arange(count, dtype=float)
        self.done += count
        both = np.column_stack([whole + BETWEEN, whole + 1.0]).ravel()
        return np.asarray(self._begun + self.clock.period * both)

    def add(self, motion: Motion) -> None:
        self.seen.append(self._entered(motion))
        self._noted(motion)

    def found(self) -> Settled | None:
        states = np.concatenate(self.seen)
        self.seen = [states]
        points = states[1::2]
        cycle = self.repeating(points)
        if cycle is None:
            return None
        count, left = cycle
        if count == 1:
            within = distances(states[-2:-1], points[-1:], self._angles, self.unit)
            if float(within[0]) <= LOOSE:
                return self.settled(Kind.FIXED_POINT, points[-1:], left=left)
        touched = np.concatenate(self.touched) if self._contacts else np.zeros((len(states), 0))
        return self.settled(
            Kind.PERIODIC,
            points[-count:],
            period=count * self.clock.period,
            touches=touched[-1] - touched[-1 - 2 * count],
            turned=points[-1] - points[-1 - count],
            left=left,
        )

    def endless(self, sign: int) -> Settled:
        """What it is if no cycle was found, by the sign of its largest exponent."""
        return self.without_cycle(self.seen[0][1::2], sign, -1)


class _Crossed(_Record):
    """Of a motion that nothing drives: its states at even times, and where it crosses sections."""

    def __post_init__(self) -> None:
        super().__post_init__()
        self._met: list[tuple[list[Floats], list[Floats]]] = []
        self._latest, self._times = np.zeros((0, 0)), np.zeros(0)
        self._lasts, self._last = self.clock.period, self._begun
        self.most = MOST_CROSSINGS

    def times(self) -> Floats:
        """Of the next look, evenly."""
        left = self._begun + self.options.periods * self.clock.period - self.march.time
        return self.march.time + min(self._lasts, left) * np.arange(1, SAMPLES + 1) / SAMPLES

    def add(self, motion: Motion) -> None:
        self._latest, self._times = self._entered(motion), motion.time
        self._noted(motion)
        for place, crossed in enumerate(motion.crossings.values()):
            if place == len(self._met):
                self._met.append(([], []))
            self._met[place][0].append(self._entered(crossed))
            self._met[place][1].append(crossed.time)
        # a look at fast motions ends early, so that its samples resolve them
        self._lasts = LONGER * (motion.stop_time - self._last)
        self._last, self.most = motion.stop_time, math.ceil(LONGER * self.most)
        counts = [sum(map(len, times)) for _, times in self._met]
        self.done = max((self._last - self._begun) / self.clock.period, *counts)

    def _crossings(self, section: int) -> tuple[Floats, Floats]:
        """States and times at all crossings of a section so far."""
        states, times = (np.concatenate(parts) for parts in self._met[section])
        self._met[section] = [states], [times]
        return states, times

    def found(self) -> Settled | None:
        return self._resting() or self._cycling()

    def _resting(self) -> Settled | None:
        """Whether states converge to one, by their ranges in two quarters of the last look."""
        part = len(self._latest) // 4
        end = self._latest[-1]
        ranges = [
            float((np.abs(self._latest[part * q : part * (q + 1) + 1] - end) / self.unit).max())
            for q in (2, 3)
        ]
        left = ranges[1] if ranges[1] <= self.noise else remaining(ranges[1], ranges[0], 1.0)
        if left > 1.0:
            return None
        return self.settled(Kind.FIXED_POINT, self._latest[-1:], left=left)

    def _cycling(self) -> Settled | None:
        """Whether the points of a section converge to a cycle, the first section for which."""
        for section in range(len(self._met)):
            states, times = self._crossings(section)
            if len(times) < 3:
                continue
            cycle = self.repeating(states)
            if cycle is None or len(times) <= 2 * cycle[0]:
                continue
            count, left = cycle
            period, before = (
                times[-1] - times[-1 - count],
                times[-1 - count] - times[-1 - 2 * count],
            )
            if abs(period - before) > EVEN * period:
                continue
            recent = self._latest[self._times >= self._times[-1] - period]
            both = np.concatenate([recent, states[-count:]])
            moved = float((np.abs(apart(both, both[-1:], self._angles)) / self.unit).max())
            if moved <= AMPLITUDE * max(left, self.noise):
                continue
            first, points = self._reported(times[-1] - period * (1.0 - 1e-6), times[-1])
            return self.settled(
                Kind.PERIODIC,
                points,
                period=float(period),
                touches=self._touches(float(period)),
                section=first,
                turned=states[-1] - states[-1 - count],
                left=left,
            )
        return None

    def _touches(self, period: float) -> Floats | None:
        """In a period, by the later half of the last look."""
        if not self._contacts or len(self._times) < 2:
            return None
        half = len(self._times) // 2
        count = self.touched[-1][-1] - self.touched[-1][half - 1]
        return np.asarray(np.round(count * period / (self._times[-1] - self._times[half - 1])))

    def _reported(self, since: float, until: float) -> tuple[int, Floats]:
        """The first section that is crossed within a cycle, and the points there.

        It depends on the attractor alone, and not on which section showed it.
        """
        for section in range(len(self._met)):
            states, times = self._crossings(section)
            inside = (times > since) & (times <= until)
            if inside.any():
                return section, states[inside]
        raise AssertionError("a cycle crosses a section")

    def endless(self, sign: int) -> Settled:
        """What it is if no cycle was found, by the sign of its largest exponent."""
        counts = [sum(map(len, times)) for _, times in self._met]
        section = next((s for s, count in enumerate(counts) if count >= FEWEST), -1)
        points = self._latest if section < 0 else self._crossings(section)[0]
        return self.without_cycle(points, sign, section)


def leaves(settled: Settled, clock: Clock, options: BasinOptions) -> Going[bool]:
    """Whether neighbours of a cycle or of a state at rest leave it: it attracts nothing then.

    Near an unstable one a motion converges for a while as well. So it is followed on, with a
    deviation vector: a positive exponent, or a motion that is elsewhere in the end.
    """
    system = settled.march.here
    start = free_vectors(system, Motion(pieces=(settled.march.sample,)))
    period = clock.period if np.isnan(settled.period) else settled.period
    asked = ExponentOptions.like(
        options, periods=FOLLOWED, skip=0, count=1, interval=period, max_steps=None
    )
    exponents = yield from exponents_of(system, asked)
    angles, scale = circular(system), np.where(settled.reach > 0.0, settled.reach, 1.0)
    moved = distances(exponents.states[-1:], start, angles, scale)
    return sign_of(exponents) > 0 or float(moved[0]) > ELSEWHERE
