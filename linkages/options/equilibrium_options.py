"""How equilibria are searched for."""

from __future__ import annotations

from dataclasses import dataclass

from linkages.options.run import RunKeywords, RunOptions
from linkages.spec.quantities import PositiveInteger, SkippedPeriods


@dataclass(frozen=True, kw_only=True)
class EquilibriumOptions(RunOptions):
    """From where equilibria are searched for.

    Parameters
    ----------
    starts
        Number of positions from which Newton's method starts: that of the definition, and others
        within reach of it, drawn at random where more than one coordinate is free.
    seed
        Of the random positions.
    moving
        Vibration about the moving mechanism at that time, with coefficients frozen there, instead
        of equilibria with drives that stand still.
    """

    starts: PositiveInteger = 100
    seed: SkippedPeriods = 0
    moving: bool = False


class EquilibriumKeywords(RunKeywords, total=False):
    """`EquilibriumOptions` as keyword arguments."""

    starts: int
    seed: int
    moving: bool
