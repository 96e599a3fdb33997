"""How wear is followed over revolutions."""

from __future__ import annotations

from dataclasses import dataclass

from linkages.options.run import RunKeywords, RunOptions
from linkages.spec.quantities import PositiveInteger, SkippedPeriods, Tolerance


@dataclass(frozen=True, kw_only=True)
class WearOptions(RunOptions):
    """How far wear is followed, and how well.

    Parameters
    ----------
    revolutions
        Most revolutions, each of them a common period of drives and loads; default: until the
        limit.
    accuracy
        Error of the growth of each clearance that is asked for, over that growth.
    largest_jump
        Most growth of a clearance in one jump, over its size.
    skip
        Revolutions in which the motion settles before the first mean; later ones go on from the
        last motion.
    longest
        Most revolutions that are computed for one mean; what is left of its error counts.
    confirm
        Jump once more, half as far each time, and say how much that changes.
    """

    revolutions: PositiveInteger | None = None
    accuracy: Tolerance = 1e-2
    largest_jump: Tolerance = 0.25
    skip: SkippedPeriods = 100
    longest: PositiveInteger = 2048
    confirm: bool = False


class WearKeywords(RunKeywords, total=False):
    """`WearOptions` as keyword arguments."""

    revolutions: int | None
    accuracy: float
    largest_jump: float
    skip: int
    longest: int
    confirm: bool
