"""Motions until a section has been crossed often enough."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from linkages.chaos.sections.contact import LinkForce
from linkages.chaos.sections.contact_log import ContactLog, check_interval
from linkages.errors import ComputationError
from linkages.kernel.system import System
from linkages.options.sections import SectionOptions
from linkages.solution.moving.march import March
from linkages.solution.moving.motion import Motion, Watch
from linkages.solution.values.surface import DIRECTIONS, parse_section


class NeverCrossedError(ComputationError):
    """A motion does not reach the section at which points were to be taken."""


@dataclass(frozen=True, eq=False)
class Met:
    """Crossings of a section, and the forces in clearances from the first to the last."""

    motion: Motion
    contacts: tuple[LinkForce, ...]
    interval: float


def crossed(
    system: System,
    options: SectionOptions,
    end: float,
    watch: Watch | None = None,
) -> Met:
    """Integrate until enough crossings of a section are found, or a time in seconds is over."""
    assert options.section is not None
    surface, skip = parse_section(system, options.section), options.skip
    interval = check_interval(system, end)
    log = None if interval is None else ContactLog(interval)
    looks = 1 if log is None else log.looks(end - system.time)
    guard = surface.guard(DIRECTIONS[options.direction], wanted=options.periods + skip)
    times = np.linspace(system.time, end, looks + 1)[1:]
    followed = March(system, options).advance(times, guards=[guard], watch=watch)
    (met,) = followed.crossings.values()
    count = len(met.time)
    motion = replace(followed, pieces=met.part(skip).pieces)
    if motion.failure is None and count <= skip:
        raise NeverCrossedError(
            f"the section {surface.series.name} = {surface.level:g} is crossed "
            f"{count} times within {end:.6g} s"
            + (f", and {skip} are skipped" if count else "")
            + "; expected a value that the motion reaches",
            time=float(end),
        )
    if log is None or count <= skip:
        return Met(motion, (), 0.0)
    log.restart(since=motion.time[0])
    log.note(followed)
    return Met(motion, log.contacts, log.interval)
