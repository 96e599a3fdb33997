"""Poincaré sections: stroboscopic at the period of the drives, or where a function is crossed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.sections.common_period import NoPeriodError, common_period
from linkages.chaos.sections.contact import LinkForce
from linkages.chaos.sections.contact_log import (
    contact_values,
    contact_variables,
)
from linkages.chaos.sections.crossed import Met, crossed
from linkages.chaos.sections.free_states import free_values, labelled_states, require_free
from linkages.chaos.sections.strobe import strobe
from linkages.chaos.sections.touches import touch_values, touch_variables
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import Interrupted, UnfinishedError
from linkages.kernel.system import System
from linkages.options.sections import SectionKeywords, SectionOptions
from linkages.options.signature import takes
from linkages.solution.moving.motion import Motion, Watch
from linkages.solution.options import options_of
from linkages.solution.values.surface import DIRECTIONS, example_section, parse_section

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

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
        found = strobe(system, options, watch)
        period = common_period(system.mechanism)
        attributes = {"period": period, "phase": options.phase, "warning": ""}
        points = _Points(
            found.motion, found.failure, found.time, found.values(options.wrap), attributes,
            found.contacts, found.interval,
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
    """Whether there can be such points, before anything is computed.

    Raises
    ------
    InputError
        If nothing is free, or the section names nothing.
    NoPeriodError
        If drives have no common period, and points are to be taken once a period.
    """
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
    found = len(motion.time)
    if motion.failure is not None or found >= points:
        return ""
    return (
        f"{found} of {points} points: the section is not crossed more often within {end:.6g} s; "
        "a later end may give more"
    )
