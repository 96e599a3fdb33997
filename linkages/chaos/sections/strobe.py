"""A motion at the times of a stroboscope, and at those at which contact is looked at."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.sections.common_period import common_period
from linkages.chaos.sections.contact import LinkForce
from linkages.chaos.sections.contact_log import MOST_TIMES, PER_PERIOD, contacts_in, looks_in
from linkages.chaos.sections.free_states import free_values
from linkages.kernel.outputs import links
from linkages.kernel.system import System
from linkages.options.sections import SectionOptions
from linkages.solution.moving.march import compute_motion
from linkages.solution.moving.motion import Motion, Settings, Watch

Floats = NDArray[np.float64]
Places = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Strobe:
    """Points of a motion, one a period.

    Parameters
    ----------
    system, motion
        What moves, and how; sampled at more times than those of the points.
    points, checked
        Places of the samples that are points, and of those at which forces are looked at.
    interval
        Time between two of these in seconds.
    wanted
        How many points were asked for.
    """

    system: System
    motion: Motion
    points: Places
    checked: Places
    interval: float
    wanted: int

    @property
    def time(self) -> Floats:
        """Times of the points in seconds."""
        return np.asarray(self.motion.time[self.points])

    def values(self, wrap: bool = True) -> dict[str, Floats]:
        """Free coordinates at the points, as `free_values` has them."""
        found = free_values(self.system, self.motion, wrap)
        return {name: array[self.points] for name, array in found.items()}

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
        found = int(np.searchsorted(self.motion.time, time))
        return found if found < len(self.motion.time) else None


@dataclass(frozen=True, eq=False)
class Strobing:
    """At which times a motion is wanted for the points of a stroboscopic section.

    Parameters
    ----------
    system, options
        What moves, and at which points it is wanted.
    times
        All of them in seconds, shape (samples,).
    wanted, checked
        Those of points, and those at which forces are looked at.
    interval
        Time between two of the latter.
    """

    system: System
    options: SectionOptions
    times: Floats
    wanted: Floats
    checked: Floats
    interval: float

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

    Parameters
    ----------
    system, options
        What moves, and at which points it is wanted.
    watch
        Called now and then with the fraction done.
    further
        Times in seconds at which the motion is wanted as well.
    """
    plan = strobing(system, options, further, partial(looks_in, system, options))
    settings = Settings(times=plan.times, run=options, watch=watch)
    return plan.taken(compute_motion(system, settings))
