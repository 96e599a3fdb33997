"""Motions until a section has been crossed often enough."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.sections.contact import LinkForce
from linkages.chaos.sections.contact_log import ContactLog, check_interval
from linkages.errors import ComputationError
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.options.sections import SectionOptions
from linkages.solution.moving.guards import Guard
from linkages.solution.moving.march import March
from linkages.solution.moving.motion import Motion, Watch
from linkages.solution.values.surface import DIRECTIONS, Surface, parse_section

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

    Parameters
    ----------
    march, times, guard
        What moves, when it is sampled, and what is watched.
    surface, skip
        The section, and how many of its crossings come before those that count.
    log
        What looks at forces in clearances, if there are any.
    """

    march: March
    times: Floats
    guard: Guard
    surface: Surface
    skip: int
    log: ContactLog | None

    def met(self, followed: Motion) -> Met:
        """The crossings of the motion.

        Raises
        ------
        NeverCrossedError
            There are none behind those that are skipped, although the motion went on to its end.
        """
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
