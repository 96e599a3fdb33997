"""Poincaré sections: stroboscopic, or at a surface."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.common_period import NoPeriodError, common_period
from linkages.chaos.contact_log import (
    MOST_TIMES,
    PER_PERIOD,
    ContactLog,
    LinkForce,
    check_interval,
    contact_values,
    contact_variables,
    contacts_in,
    looks_in,
    touch_values,
    touch_variables,
)
from linkages.chaos.free_states import free_values, labelled_states, require_free
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError, Interrupted, UnfinishedError
from linkages.kernel.outputs import links
from linkages.kernel.system import System
from linkages.options.analysis_options import SectionKeywords, SectionOptions
from linkages.options.option import takes
from linkages.options.run import RunOptions
from linkages.solution.guards import DIRECTIONS, Guard, Surface, example_section, parse_section
from linkages.solution.march import March, compute_motion
from linkages.solution.motion import Motion, Settings, Watch
from linkages.solution.run_options import options_of

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]


class NeverCrossedError(ComputationError):
    """A motion does not reach the section at which points were to be taken."""


@dataclass(frozen=True, eq=False)
class Met:
    """Crossings of a section, and the forces in clearances from the first to the last."""

    motion: Motion
    contacts: tuple[LinkForce, ...]
    interval: float


@dataclass(frozen=True, eq=False)
class Crossing:
    """What a motion is to watch until enough crossings of a section are found, or its end.

    `march`, `times`, `guard`: what moves, when it is sampled, and what is watched.
    `surface`, `skip`: the section, and how many of its crossings come before those that count.
    """

    march: March
    times: Floats
    guard: Guard
    surface: Surface
    skip: int
    log: ContactLog | None  # what looks at forces in clearances, if there are any

    def met(self, followed: Motion) -> Met:
        """The crossings of the motion."""
        (met,) = followed.crossings.values()
        count, skip, end = len(met.time), self.skip, float(self.times[-1])
        motion = replace(followed, pieces=met.part(skip).pieces)
        if motion.failure is None and count <= skip:
            raise NeverCrossedError(
                f"the section {self.surface.series.name} = {self.surface.level:g} is crossed "
                f"{count} times within {end:.6g} s"
                + (f", and {skip} are skipped" if count else "")
                + "; expected a value that the motion reaches",
                time=end,
            )
        if self.log is None or count <= skip:
            return Met(motion, (), 0.0)
        self.log.restart(since=motion.time[0])
        self.log.note(followed)
        return Met(motion, self.log.contacts, self.log.interval)


def crossing(
    system: System, options: SectionOptions, end: float, run: RunOptions | None = None
) -> Crossing:
    """How a motion is followed until enough crossings are found, or a time in seconds is over.

    With options of a `run`, forces are looked at as `check_interval` says.
    """
    assert options.section is not None
    surface, skip = parse_section(system, options.section), options.skip
    interval = check_interval(system, end, run)
    log = None if interval is None else ContactLog(interval)
    looks = 1 if log is None else log.looks(end - system.time)
    return Crossing(
        march=March(system, options),
        times=np.linspace(system.time, end, looks + 1)[1:],
        guard=surface.guard(DIRECTIONS[options.direction], wanted=options.periods + skip),
        surface=surface,
        skip=skip,
        log=log,
    )


def crossed(
    system: System,
    options: SectionOptions,
    end: float,
    watch: Watch | None = None,
) -> Met:
    """Integrate until enough crossings of a section are found, or a time in seconds is over."""
    plan = crossing(system, options, end, options)
    return plan.met(plan.march.advance(plan.times, guards=[plan.guard], watch=watch))


Places = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Strobe:
    """Points of a motion, one a period.

    `system`, `motion`: what moves, and how; sampled at more times than those of the points.
    `points`, `checked`: places of the samples that are points, and of those at which forces are
    looked at.
    """

    system: System
    motion: Motion
    points: Places
    checked: Places
    interval: float  # time between two of these in seconds
    wanted: int  # how many points were asked for

    @property
    def time(self) -> Floats:
        """Times of the points in seconds."""
        return np.asarray(self.motion.time[self.points])

    def values(self, wrap: bool = True) -> dict[str, Floats]:
        """Free coordinates at the points, as `free_values` has them."""
        result = free_values(self.system, self.motion, wrap)
        return {name: array[self.points] for name, array in result.items()}

    @property
    def contacts(self) -> tuple[LinkForce, ...]:
        """Forces in clearances from the first point to the last."""
        if len(self.checked) < 2:
            return ()
        lasted = self.motion.time[-1] - self.system.time
        rate = self.motion.cost.get("steps", 0) / lasted
        return contacts_in(self.motion, rate, self.checked)

    @property
    def failure(self) -> str | None:
        """Why there are fewer points than asked for; None if there are not."""
        return None if len(self.points) == self.wanted else self.motion.failure

    def place(self, time: float) -> int | None:
        """The sample at a time that was asked for; None if the motion did not come so far."""
        result = int(np.searchsorted(self.motion.time, time))
        return result if result < len(self.motion.time) else None


@dataclass(frozen=True, eq=False)
class Strobing:
    """At which times a motion is wanted for the points of a stroboscopic section.

    `system`, `options`: what moves, and at which points it is wanted.
    `wanted`, `checked`: those of points, and those at which forces are looked at.
    """

    system: System
    options: SectionOptions
    times: Floats  # all of them in seconds, shape (samples,)
    wanted: Floats
    checked: Floats
    interval: float  # time between two of the latter

    def taken(self, motion: Motion) -> Strobe:
        """The points of a motion that was sampled at these times."""
        points, looks = (
            np.searchsorted(self.times, asked) for asked in (self.wanted, self.checked)
        )
        reached = len(motion.time)
        return Strobe(
            system=self.system,
            motion=motion,
            points=points[points < reached],
            checked=looks[looks < reached] if len(self.checked) > 1 else looks[:0],
            interval=self.interval,
            wanted=len(self.wanted),
        )


def strobing(
    system: System,
    options: SectionOptions,
    further: tuple[float, ...] = (),
    looks: Callable[[float], int] = lambda _: PER_PERIOD,
) -> Strobing:
    """The times of a stroboscopic section; arguments as `strobe` has them.

    `looks` is how often forces are looked at in a period in seconds.
    """
    period = common_period(system.mechanism)
    periods, first = options.periods, options.phase + options.skip
    parts, lasting = 1, 0
    if links(system.model):
        lasting = max(1, periods - 1)  # contact is looked at over a period at least
        parts = max(1, min(looks(period), MOST_TIMES // lasting))
    wanted = period * (first + np.arange(periods, dtype=np.float64))
    checked = period * (first + np.arange(lasting * parts + 1) / parts)
    times = np.unique(np.concatenate([wanted, checked, further]))
    return Strobing(system, options, times, wanted, checked, period / parts)


def strobe(
    system: System,
    options: SectionOptions,
    watch: Watch | None = None,
    further: tuple[float, ...] = (),
) -> Strobe:
    """Follow a motion to the last point of a stroboscopic section.

    `further`: times in seconds at which the motion is wanted as well.
    """
    plan = strobing(system, options, further, partial(looks_in, system, options))
    settings = Settings(times=plan.times, run=options, watch=watch)
    return plan.taken(compute_motion(system, settings))


ROOM = 2
"""Periods beyond the points asked for until which crossings are looked for."""


@takes(SectionOptions)
def poincare(
    mechanism: Mechanism,
    *,
    watch: Callable[[float], None] | None = None,
    **options: Unpack[SectionKeywords],
) -> xr.Dataset:
    """Points of a Poincaré section.

    Parameters
    ----------
    mechanism
        With at least one free coordinate.
    watch
        Called about 20 times a second with the fraction of simulated time done.
    options
        As `SectionOptions` describes them.

    Returns
    -------
    Dataset with `time` (crossing) and, for each kind of free coordinate, value and rate, such as
    `clearance_angle` and `clearance_speed` (crossing, clearance); of a section at touches also
    `touch_phase`, `touch_direction` and `touch_rate` (crossing, touch). The attribute ``warning``
    says if there are fewer points than asked for, since the time was over. With clearances,
    `contact_lost` and `least_force` (clearance) say for which share of the time from the first
    point to the last the massless link would have to push, and the least force in newtons along it;
    forces are looked at every ``interval`` seconds, an attribute of both: 128 times a period, or as
    often as `simulate` takes samples where drives have no period.

    Raises
    ------
    InputError
        If nothing is free, or the section names nothing.
    ValueError
        For arguments that make no sense; `NoPeriodError` where drives have no common period.
    UnfinishedError
        If the motion cannot go on; ``kept["poincare"]`` has the points so far.
    Interrupted
        After Ctrl-C, with the same.
    ComputationError
        If the motion never crosses the section.
    """
    given = options_of(SectionOptions, mechanism, options)
    return section_points(System(mechanism), given, watch)


def section_points(
    system: System, options: SectionOptions, watch: Watch | None = None
) -> xr.Dataset:
    """What `poincare` returns."""
    require_section(system, options)
    if options.section is None:
        result = strobe(system, options, watch)
        period = common_period(system.mechanism)
        attributes = {"period": period, "phase": options.phase, "warning": ""}
        points = _Points(
            result.motion, result.failure, result.time, result.values(options.wrap), attributes,
            result.contacts, result.interval,
        )  # fmt: skip
        return _labelled(system, options, points)
    return met_points(system, options, crossed(system, options, last_time(system, options), watch))


def last_time(system: System, options: SectionOptions) -> float:
    """The time in seconds until which crossings of a section are looked for."""
    return options.end or _limit(system, options.periods + options.skip)


def met_points(system: System, options: SectionOptions, met: Met) -> xr.Dataset:
    """What `poincare` returns of crossings of a section."""
    assert options.section is not None
    motion = met.motion
    attributes = {
        "section": options.section,
        "direction": options.direction,
        "warning": _shortage(motion, options.periods, last_time(system, options)),
    }
    values = free_values(system, motion, options.wrap)
    touches = touch_values(system, motion, parse_section(system, options.section))
    points = _Points(
        motion, motion.failure, motion.time, values, attributes, met.contacts, met.interval, touches
    )
    return _labelled(system, options, points)


@dataclass(frozen=True)
class _Points:
    """Points of a section, of either kind."""

    motion: Motion
    failure: str | None
    time: Floats
    values: dict[str, Floats]
    attributes: dict[str, Any]
    contacts: tuple[LinkForce, ...]
    interval: float
    touches: dict[str, Floats] = field(default_factory=dict)


def _labelled(system: System, options: SectionOptions, points: _Points) -> xr.Dataset:
    motion, failure = points.motion, points.failure
    data = labelled_states(
        system,
        points.values,
        "crossing",
        {"time": ("crossing", points.time, {"units": "s", "long_name": "time"})},
        {**points.attributes, "skip": options.skip, **options.how},
    )
    data = data.assign(touch_variables(points.touches, options.section or ""))
    if "clearance" in data.coords:
        names = [str(name) for name in data["clearance"].to_numpy()]
        contacts = contact_values(points.contacts, names)
        data = data.assign(contact_variables(contacts, points.interval))
    if motion.interrupted:
        raise Interrupted(str(motion.failure), time=motion.stop_time, kept={"poincare": data})
    if failure is not None:
        raise UnfinishedError(failure, {"poincare": data}, time=motion.stop_time)
    return data


def require_section(system: System, options: SectionOptions) -> None:
    """Whether there can be such points, before anything is computed."""
    require_free(system)
    if options.section is None:
        stroboscopic_period(system)
    else:
        parse_section(system, options.section).guard(DIRECTIONS[options.direction])


def stroboscopic_period(system: System) -> float:
    """The common period, or an error that says what to do without one."""
    try:
        return common_period(system.mechanism)
    except NoPeriodError as error:
        example = example_section(system)
        message = f"{error}; take a geometric section instead, such as {example!r}"
        raise NoPeriodError(message) from None


def _limit(system: System, points: int) -> float:
    """The default end: time for all points of a section that is crossed once a period."""
    try:
        period = common_period(system.mechanism)
    except NoPeriodError:
        period = system.mechanism.simulation.end
    return (points + ROOM) * period


def _shortage(motion: Motion, points: int, end: float) -> str:
    """What to say of a motion that met too few points until the end."""
    result = len(motion.time)
    if motion.failure is not None or result >= points:
        return ""
    return (
        f"{result} of {points} points: the section is not crossed more often within {end:.6g} s; "
        "a later end may give more"
    )
