"""A search as functions of places in the box of bounds: one motion at a time, with derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.design.optimising.goals import Constraint, Goal
from linkages.design.optimising.record import Tried
from linkages.design.sensitivity.differentiated import Differentiated
from linkages.design.varied.ranges import Ranges
from linkages.errors import ComputationError, InputError, LinkagesError
from linkages.kernel.reaching import unreached
from linkages.options.run import SimulationOptions
from linkages.solution.options import options_of
from linkages.sweeps.answers import Code
from linkages.sweeps.running import reason_of

Floats = NDArray[np.float64]

NOT_ASSEMBLED, INVALID = 2.0, 3.0


@dataclass(frozen=True, eq=False)
class Problem:
    """What is varied, what is sought, and how motions are computed.

    Parameters
    ----------
    mechanism, ranges
        What is varied, and within which bounds.
    goal, constraints
        What is sought.
    given
        Options of the simulation that are given.
    """

    mechanism: Mechanism
    ranges: Ranges
    goal: Goal
    constraints: Sequence[Constraint]
    given: Mapping[str, Any]

    @cached_property
    def run(self) -> SimulationOptions:
        """How motions are computed."""
        return options_of(SimulationOptions, self.mechanism, self.given)

    @property
    def texts(self) -> list[str]:
        """Measures that tell how good a point is: of the goal, and two of each constraint."""
        measured = [each.measured.text for each in self.constraints]
        excesses = [each.excess.text for each in self.constraints]
        return [self.goal.measure.text, *measured, *excesses]

    @cached_property
    def start(self) -> Floats:
        """The numbers of the definition in SI."""
        own = Differentiated(self.mechanism, [], self.ranges.paths, run=self.given)
        return np.array(own.values, dtype=float)

    def tried(self, places: Floats, values: Floats) -> Tried:
        """What came of some places where a motion has all values of `texts`."""
        count = len(self.constraints)
        return Tried(places, float(values[0]), values[1 : 1 + count], values[1 + count :])

    def failed(self, places: Floats, missing: float, reason: str) -> Tried:
        """What came of some places where it has not."""
        nothing = np.full(len(self.constraints), np.nan)
        return Tried(places, float("nan"), nothing, nothing, missing, reason)

    def refused(self, places: Floats, error: LinkagesError) -> Tried:
        """What came of some places where something is wrong."""
        match error:
            case ComputationError(time=float(time)):
                return self.failed(places, self.missing(Code.STOPPED, time), reason_of(error))
            case _:
                return self.failed(places, self.unassembled(places), reason_of(error))

    def unassembled(self, places: Floats) -> float:
        """How far from assembly some places are, as `Tried` has it."""
        overrides = self.ranges.overrides(self.ranges.numbers(places))
        try:
            return NOT_ASSEMBLED + unreached(self.mechanism.with_values(overrides))
        except InputError:
            return INVALID

    def missing(self, code: int, time: float) -> float:
        """How much of a motion there is not, as `Tried` has it."""
        match code:
            case Code.COMPUTED:
                return 0.0
            case Code.STOPPED | Code.OVER_BUDGET if time == time:
                return 1.0 - min(time / self.run.end, 1.0 - 1e-9)
            case Code.INVALID:
                return INVALID
            case _:
                return NOT_ASSEMBLED
