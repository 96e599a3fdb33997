"""Poincaré sections: stroboscopic at the period of the drives, or where a function is crossed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.common_period import NoPeriodError, common_period
from linkages.chaos.contact_log import (
    contact_values,
    contact_variables,
)
from linkages.chaos.crossed import DIRECTIONS, crossed
from linkages.chaos.free_states import free_values, labelled_states, require_free
from linkages.chaos.strobe import strobe
from linkages.chaos.unfinished import UnfinishedError
from linkages.components.mechanism import Mechanism
from linkages.errors import Interrupted
from linkages.kernel.system import System
from linkages.solution.arguments import whole_number
from linkages.solution.motion import Motion, Settings
from linkages.solution.surface import SECTION, parse_section
from linkages.solvers.integrate import MAX_STEPS
from linkages.solvers.methods import FIXED_STEP_METHODS

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

ROOM = 2
"""Periods beyond the points asked for until which crossings are looked for."""


def poincare(
    mechanism: Mechanism,
    *,
    periods: int = 500,
    skip: int = 0,
    phase: float = 0.0,
    section: str | None = None,
    direction: str = "up",
    end: float | None = None,
    wrap: bool = True,
    method: str | None = None,
    rtol: float | None = None,
    max_steps: int = MAX_STEPS,
    watch: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Points of a Poincaré section.

    Parameters
    ----------
    mechanism
        With at least one free coordinate.
    periods
        Number of points: one per common period of the drives, or one per crossing of `section`.
    skip
        Points left out before.
    phase
        Where in the period points are taken, from 0 to 1; not with `section`.
    section
        Where points are taken instead: ``"slider9.velocity=0"``, an element, a quantity of position
        or velocity (angle, speed, position, velocity) and a value in SI.
    direction
        ``"up"``, ``"down"`` or ``"both"``: how the quantity crosses the value of `section`.
    end
        Time until which crossings of a section are looked for; if not given, ``periods + skip + 2``
        times the common period of the drives (or the file's end time, if there is none).
    wrap
        Whether angles are taken within one turn.
    method, rtol, max_steps
        As `linkages.simulate` takes them; method and tolerance of the file if not given.
    watch
        Called about 20 times a second with the fraction of simulated time done.

    Returns
    -------
    Dataset with `time` (crossing) and, for each kind of free coordinate, value and rate, such as
    `clearance_angle` and `clearance_speed` (crossing, clearance). The attribute ``warning`` says if
    there are fewer points than asked for, since the time was over. With clearances, `contact_lost`
    and `least_force` (clearance) say for which share of the time from the first point to the last
    the massless link would have to push, and the least force in newtons along it; forces are looked
    at every ``interval`` seconds, an attribute of both: 128 times a period, or as often as
    `simulate` takes samples where drives have no period.

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
    periods, skip = whole_number("periods", periods), whole_number("skip", skip)
    system = System(mechanism)
    require_section(system, periods, skip, phase, section, direction, end)
    settings = replace(section_settings(mechanism, method, rtol, max_steps), watch=watch)
    attributes: dict[str, object]
    if section is None:
        found = strobe(system, settings, periods=periods, skip=skip, phase=phase)
        motion, failure, time, values = found.motion, found.failure, found.time, found.values(wrap)
        contacts, interval = found.contacts, found.interval
        attributes = {"period": common_period(system.mechanism), "phase": phase, "warning": ""}
    else:
        surface = parse_section(system, section)
        last = _limit(system, periods + skip) if end is None else end
        met = crossed(system, settings, surface, periods, skip, direction, last)
        motion, failure, time = met.motion, met.motion.failure, met.motion.time
        values = free_values(system, motion, wrap)
        contacts, interval = met.contacts, met.interval
        attributes = {
            "section": section,
            "direction": direction,
            "warning": _shortage(motion, periods, last),
        }
    data = labelled_states(
        system,
        values,
        "crossing",
        {"time": ("crossing", time, {"units": "s", "long_name": "time"})},
        {**attributes, "skip": skip, **how(settings)},
    )
    if "clearance" in data.coords:
        names = [str(name) for name in data["clearance"].to_numpy()]
        data = data.assign(contact_variables(contact_values(contacts, names), interval))
    if motion.interrupted:
        raise Interrupted(str(motion.failure), time=motion.stop_time, kept={"poincare": data})
    if failure is not None:
        raise UnfinishedError(failure, {"poincare": data}, time=motion.stop_time)
    return data


def require_section(
    system: System,
    periods: int,
    skip: int,
    phase: float,
    section: str | None,
    direction: str,
    end: float | None = None,
) -> None:
    """Whether arguments of `poincare` make sense, before anything is computed.

    Raises
    ------
    InputError
        If nothing is free.
    ValueError
        If they do not.
    """
    require_free(system)
    if periods < 1 or skip < 0:
        raise ValueError(f"expected periods > 0 and skip >= 0, found {periods} and {skip}")
    if not 0.0 <= phase < 1.0:
        raise ValueError(f"phase must be from 0 to below 1, found {phase:g}")
    if direction not in DIRECTIONS:
        raise ValueError(f"direction must be up, down or both, found {direction!r}")
    if section is None:
        _require_stroboscopic(direction, end)
        stroboscopic_period(system.mechanism)
    else:
        _require_geometric(phase, end)
        parse_section(system, section)


def _require_stroboscopic(direction: str, end: float | None) -> None:
    """Points at times cross nothing, and are as many as are asked for."""
    needed = "goes with a section where a quantity has a value, and none is given"
    if direction != "up":
        raise ValueError(f"direction {direction!r} {needed}")
    if end is not None:
        raise ValueError(f"end = {end:g} s {needed}; points once a period end with their number")


def _require_geometric(phase: float, end: float | None) -> None:
    """Crossings have no phase, and are looked for after the start."""
    if phase:
        raise ValueError(
            f"phase {phase:g} goes with points once a period; a section where a quantity has a "
            "value has none"
        )
    if end is not None and not end > 0.0:
        raise ValueError(f"end must be a time in s > 0, found {end:g}")


def section_settings(
    mechanism: Mechanism, method: str | None, rtol: float | None, max_steps: int = MAX_STEPS
) -> Settings:
    """How a motion is integrated whose samples are chosen later."""
    if max_steps < 1:
        raise ValueError(f"max_steps must be at least 1, found {max_steps}")
    defaults = mechanism.simulation
    chosen = defaults.method if method is None else method
    return Settings(
        times=np.zeros(1),
        method=chosen,
        rtol=defaults.rtol if rtol is None else rtol,
        atol=defaults.atol,
        step=defaults.step if chosen in FIXED_STEP_METHODS else None,
        max_steps=max_steps,
    )


def how(settings: Settings) -> dict[str, object]:
    """How a motion is integrated, as attributes of a dataset; nan for what is not set."""
    atol = settings.rtol if settings.atol is None else settings.atol
    step = np.nan if settings.step is None else settings.step
    return {"method": settings.method, "rtol": settings.rtol, "atol": atol, "step": step}


def stroboscopic_period(mechanism: Mechanism) -> float:
    """The common period, or an error that says what to do without one."""
    try:
        return common_period(mechanism)
    except NoPeriodError as error:
        message = f"{error}; take a geometric section instead, such as {SECTION!r}"
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
