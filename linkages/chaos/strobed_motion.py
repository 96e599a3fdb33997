"""A motion that is looked at once a period, until it is decided what it settles to."""

from __future__ import annotations

import math
from dataclasses import replace
from enum import IntEnum
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.diagram import free_names_of_angles, touchable
from linkages.chaos.free_states import circular, state_tolerances
from linkages.chaos.recurrence import (
    Cycle,
    approached_cycle,
    find_cycle,
    points_left,
    separates,
)
from linkages.chaos.sections import stroboscopic_period
from linkages.errors import ComputationError
from linkages.kernel.system import System
from linkages.options.analysis_options import MapOptions
from linkages.solution.contact_episodes import touch_counts, touches_so_far
from linkages.solution.guards import free_vectors
from linkages.solution.many import Going
from linkages.solution.march import March
from linkages.solution.motion import Motion
from linkages.sweeps.engine import Answer, Field

Floats = NDArray[np.float64]

FIRST_LOOK, LEAST_MORE, MOST_MORE = 16, 1.5, 2.0
"""Points after which a motion is first looked at, and how many times as many at the next look."""

WORTH = 1000
"""Steps that take about as long as a look."""

BLOCK = 8
"""Looks come after multiples of this: motions that last equally long share their set-up."""

COARSEST = 1e-7
"""Tolerance up to which cycles are found to so many errors of a step. With a looser one the same
distances count, for chaotic motions come near to each other by chance."""


class Regime(IntEnum):
    """What was found of a motion."""

    NOT_COMPUTED = 0
    PERIODIC = 1
    CHAOTIC = 2
    UNDECIDED = 3


REGIMES = {
    "flag_values": np.array([*Regime], dtype=np.int8),
    "flag_meanings": " ".join(each.name.lower() for each in Regime),
}


class Followed:
    """A motion that is looked at once a period, until it is decided what it settles to.

    `system`: where it starts.
    `run`: how it is integrated.
    `states`: whether its last state is wanted.
    """

    def __init__(self, system: System, run: MapOptions, states: bool = False) -> None:
        self.system, self._run, self._states = system, run, states
        self.march = March(system, run)
        self.period = stroboscopic_period(system)
        self.motions: list[Motion] = []
        self.angles = circular(system)
        self.points = np.zeros((0, len(self.angles)))

    def going(self) -> Going[Cycle | None]:
        """Follow it; returns the cycle that it has reached, if it has."""
        skip, most, wanted = self._run.skip, self._run.periods, FIRST_LOOK
        while True:
            # a rest that is short beside what is there is not worth a look of its own
            wanted = most if LEAST_MORE * wanted > most else wanted
            times = self.period * (skip + np.arange(self.count + 1.0, wanted + 1.0))
            motion = yield from self.march.advancing(times)
            if motion.failure is not None:
                raise ComputationError(motion.failure, time=motion.stop_time)
            self.motions.append(motion)
            new = free_vectors(self.system, motion, turns=False)
            self.points = np.concatenate([self.points, new])
            section = self.points, self.angles, self._unit
            if (found := find_cycle(*section)) is not None:
                return found
            if self.count == most:
                return None if self.chaotic else approached_cycle(*section)
            further = min(self.count + points_left(*section) + 1, MOST_MORE * self.count)
            worth = self.count + WORTH * (skip + self.count) / self.march.cost["steps"]
            wanted = BLOCK * math.ceil(max(further, LEAST_MORE * self.count, worth) / BLOCK)

    @property
    def count(self) -> int:
        """Number of points so far."""
        return len(self.points)

    @cached_property
    def chaotic(self) -> bool:
        """Whether its points come apart, once all have been seen."""
        return separates(self.points, self.angles)

    @cached_property
    def _taken_as(self) -> MapOptions:
        """Its tolerances, no looser than points can be told apart with."""
        rtol, atol = self._run.rtol, self._run.atol
        atol = None if atol is None else min(atol, COARSEST)
        return replace(self._run, rtol=min(rtol, COARSEST), atol=atol)

    @cached_property
    def _tolerances(self) -> Floats:
        return state_tolerances(self.system, self._taken_as)

    @property
    def _unit(self) -> Floats:
        """Error that a step may have, shape (x,)."""
        return self._tolerances + self._taken_as.rtol * np.abs(self.points).max(axis=0)

    def touches(self, last: int) -> Floats:
        """Touches of each contact over the last so many periods; nan where not all were kept."""
        counts, before = [], np.zeros(len(touchable(self.system)))
        for motion in self.motions:
            counts.append(before + touches_so_far(motion))  # a copy
            before += [*touch_counts(motion).values()]
        whole = np.concatenate(counts)
        return np.asarray(before - whole[-1 - last])

    def turns(self, last: int) -> Floats:
        """Turns of each free angle over the last so many periods."""
        free, names = self.system.topology.free, free_names_of_angles(self.system)
        columns = [free.index(name) for name in names]
        angles = [free_vectors(self.system, motion)[:, columns] for motion in self.motions]
        whole = np.concatenate(angles)
        return np.asarray((whole[-1] - whole[-1 - last]) / (2 * np.pi))

    def answer(self, cycle: Cycle | None) -> Answer:
        """What was found, as `plane_fields` has it."""
        system, last = self.system, self.count // 2 if cycle is None else cycle.count
        values: dict[str, Any] = {"lasted": self.count + self._run.skip}
        if cycle is not None:
            values |= {"regime": Regime.PERIODIC, "indicator": cycle.count}
            values["contraction"] = cycle.contraction
        else:
            values["regime"] = Regime.CHAOTIC if self.chaotic else Regime.UNDECIDED
        if touchable(system):
            values["touches"] = self.touches(last) / last
        if free_names_of_angles(system):
            turns = self.turns(last)
            # angles repeat in a cycle, so that what they have moved are whole turns and errors
            values["rotation_number"] = (turns if cycle is None else np.round(turns)) / last
        if self._states:
            values["state"] = self.points[-1]
        return Answer(values, evaluations=self.march.cost["evaluations"])


def plane_fields(system: System, states: bool = False) -> dict[str, Field]:
    """What is found at a point, with its last state if that is wanted."""
    angles, contacts = len(free_names_of_angles(system)), len(touchable(system))
    return {
        "indicator": Field(), "regime": Field("i1"), "contraction": Field(), "lasted": Field("i8"),
        **({"touches": Field(shape=(contacts,))} if contacts else {}),
        **({"rotation_number": Field(shape=(angles,))} if angles else {}),
        **({"state": Field(shape=(system.layout.directions,))} if states else {}),
    }  # fmt: skip
