"""Poincaré sections: stroboscopic, or at a surface."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
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
    contact_values,
    contact_variables,
    contacts_in,
    looks_in,
    touch_values,
    touch_variables,
)
from linkages.chaos.free_states import free_names, free_values, labelled_states, require_free
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError, Interrupted, UnfinishedError
from linkages.kernel.outputs import VARIABLES, links
from linkages.kernel.system import System
from linkages.options.analysis_options import SectionKeywords, SectionOptions
from linkages.options.option import takes
from linkages.options.run import RunOptions
from linkages.solution.guards import DIRECTIONS, Guard, example_section, parse_section
from linkages.solution.march import March
from linkages.solution.motion import Motion, Watch
from linkages.solution.run_options import options_of

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]


class NeverCrossedError(ComputationError):
    """A motion does not reach the section at which points were to be taken."""


@dataclass(frozen=True, eq=False)
class SectionPoints:
    """Points of a section, and the forces in clearances from the first to the last."""

    system: System
    options: SectionOptions
    motion: Motion
    points: Any  # places of those of its samples that are points
    contacts: tuple[LinkForce, ...] = ()
    interval: float = 0.0  # time between two looks at forces in seconds

    @property
    def time(self) -> Floats:
        """Times of the points in seconds."""
        return np.asarray(self.motion.time[self.points])

    @property
    def failure(self) -> str | None:
        """Why there are fewer points than asked for; None if there are not."""
        return self.motion.failure if len(self.time) < self.options.periods else None

    @property
    def warning(self) -> str:
        """What to say of a motion that met too few points until the end."""
        count, wanted = len(self.time), self.options.periods
        if self.motion.failure is not None or count >= wanted:
            return ""
        end = last_time(self.system, self.options)
        return (
            f"{count} of {wanted} points: the section is not crossed more often within {end:.6g} "
            "s; a later end may give more"
        )

    def values(self, names: Sequence[str]) -> dict[str, Floats]:
        """Free coordinates, touches, and contact in the clearances of some names, by variables."""
        system, options = self.system, self.options
        whole = free_values(system, self.motion, options.wrap)
        result = {name: array[self.points] for name, array in whole.items()}
        if options.section is not None:
            surface = parse_section(system, options.section)
            result |= touch_values(system, self.motion, surface)
        return result | (contact_values(self.contacts, names) if names else {})

    def require(self) -> None:
        """Raise that the motion was interrupted, or stopped before its first point."""
        if self.motion.interrupted:
            raise Interrupted(str(self.motion.failure), time=self.motion.stop_time)
        if self.failure is not None and not len(self.time):
            raise ComputationError(self.failure, time=self.motion.stop_time)


@dataclass(frozen=True, eq=False)
class SectionPlan:
    """When a motion is wanted for points of a section, what is watched, and what makes them."""

    times: Floats  # in seconds, shape (samples,)
    points: Callable[[Motion], SectionPoints]
    guards: tuple[Guard, ...] = ()


def crossing(
    system: System, options: SectionOptions, end: float, run: RunOptions | None = None
) -> SectionPlan:
    """How a motion is followed until enough crossings are found, or a time in seconds is over.

    With options of a `run`, forces are looked at as `check_interval` says.
    """
    assert options.section is not None
    surface, skip = parse_section(system, options.section), options.skip
    log = ContactLog.of(system, end, run)
    looks = 1 if log is None else log.looks(end - system.time)

    def met(followed: Motion) -> SectionPoints:
        (every,) = followed.crossings.values()
        count = len(every.time)
        motion = replace(followed, pieces=every.part(skip).pieces)
        if motion.failure is None and count <= skip:
            raise NeverCrossedError(
                f"the section {surface.series.name} = {surface.level:g} is crossed "
                f"{count} times within {end:.6g} s"
                + (f", and {skip} are skipped" if count else "")
                + "; expected a value that the motion reaches",
                time=end,
            )
        if log is None or count <= skip:
            return SectionPoints(system, options, motion, slice(None))
        log.restart(since=motion.time[0])
        log.note(followed)
        return SectionPoints(system, options, motion, slice(None), log.contacts, log.interval)

    times = np.linspace(system.time, end, looks + 1)[1:]
    guard = surface.guard(DIRECTIONS[options.direction], wanted=options.periods + skip)
    return SectionPlan(times, met, (guard,))


def strobing(
    system: System,
    options: SectionOptions,
    further: tuple[float, ...] = (),
    looks: Callable[[float], int] = lambda _: PER_PERIOD,
) -> SectionPlan:
    """How a motion is followed to the last point of a stroboscopic section.

    `further`: times in seconds at which it is wanted as well; `looks`: how often forces are looked
    at in a period in seconds.
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

    def taken(motion: Motion) -> SectionPoints:
        reached, contacts = len(motion.time), tuple[LinkForce, ...]()
        points, seen = (np.searchsorted(times, each) for each in (wanted, checked))
        points, seen = (each[each < reached] for each in (points, seen))
        if len(seen) > 1:
            rate = motion.cost.get("steps", 0) / (motion.time[-1] - system.time)
            contacts = contacts_in(motion, rate, seen)
        return SectionPoints(system, options, motion, points, contacts, period / parts)

    return SectionPlan(times, taken)


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
        plan = strobing(system, options, looks=partial(looks_in, system, options))
        attributes: dict[str, Any] = {
            "period": common_period(system.mechanism), "phase": options.phase,
        }  # fmt: skip
    else:
        plan = crossing(system, options, last_time(system, options), options)
        attributes = {"section": options.section, "direction": options.direction}
    march = March(system, options)
    points = plan.points(march.advance(plan.times, guards=plan.guards, watch=watch))
    attributes["warning"] = points.warning
    names = free_names(system).get("clearance", [])
    values = points.values(names)
    data = labelled_states(
        system,
        {name: array for name, array in values.items() if name in VARIABLES},
        "crossing",
        {"time": ("crossing", points.time, {"units": "s", "long_name": "time"})},
        {**attributes, "skip": options.skip, **options.how},
    )
    data = data.assign(touch_variables(values, options.section or ""))
    if names:
        data = data.assign(contact_variables(values, points.interval))
    motion = points.motion
    if motion.interrupted:
        raise Interrupted(str(motion.failure), time=motion.stop_time, kept={"poincare": data})
    if points.failure is not None:
        raise UnfinishedError(points.failure, {"poincare": data}, time=motion.stop_time)
    return data


def last_time(system: System, options: SectionOptions) -> float:
    """The time in seconds until which crossings of a section are looked for.

    By default that is for all points of a section that is crossed once a period.
    """
    if options.end:
        return options.end
    try:
        period = common_period(system.mechanism)
    except NoPeriodError:
        period = system.mechanism.simulation.end
    return (options.periods + options.skip + ROOM) * period


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
