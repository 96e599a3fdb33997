"""How far exponents, indicators and verdicts follow a motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from linkages.options.option import OptionError
from linkages.options.run import RunKeywords, RunOptions
from linkages.spec.quantities import Duration, Periods, PositiveInteger, SkippedPeriods

Indicator = Literal["exponent", "fli", "gali"]

FEWEST_MAP_PERIODS = 4


@dataclass(frozen=True, kw_only=True)
class ExponentOptions(RunOptions):
    """Lyapunov exponents of a motion.

    Parameters
    ----------
    periods
        Length of the run in periods: common ones of the drives, or units of `interval`.
    skip
        Periods before the average begins.
    count
        How many exponents, the largest; default: all. The cost grows with it.
    interval
        Length in s of what counts as a period for `periods` and `skip`, so that the run lasts
        ``periods`` times as long; default: the period of the drives, or simulate.end.
    """

    periods: Periods = 300
    skip: SkippedPeriods = 0
    count: PositiveInteger | None = None
    interval: Duration | None = None


@dataclass(frozen=True, kw_only=True)
class MapOptions(RunOptions):
    """An indicator at each point of a map.

    Parameters
    ----------
    indicator
        What the map shows. ``exponent`` is in 1/s, ``fli`` grows in proportion to time where motion
        is chaotic, and ``gali`` shrinks to zero there, for motions that conserve energy.
    periods
        Length of each run in periods.
    skip
        Periods before it, in which motions and tangents find their attractor.
    """

    indicator: Indicator = "exponent"
    periods: Periods = 100
    skip: SkippedPeriods = 0

    def __post_init__(self) -> None:
        if self.periods < FEWEST_MAP_PERIODS:
            message = f"a map needs at least {FEWEST_MAP_PERIODS} periods, found {self.periods}"
            raise OptionError("periods", message)


@dataclass(frozen=True, kw_only=True)
class VerdictOptions(RunOptions):
    """A verdict on a motion.

    Parameters
    ----------
    periods
        Length of the motion in periods, at least 200: common ones of the drives or, where there is
        none, mean returns to a section where the motion comes back.
    skip
        Periods before it is judged; default: the transient, as it is found. Without friction there
        is none.
    """

    periods: Periods = 300
    skip: SkippedPeriods | None = None


class ExponentKeywords(RunKeywords, total=False):
    """`ExponentOptions` as keyword arguments."""

    periods: int
    skip: int
    count: int | None
    interval: float | None


class MapKeywords(RunKeywords, total=False):
    """`MapOptions` as keyword arguments."""

    indicator: str
    periods: int
    skip: int


class VerdictKeywords(RunKeywords, total=False):
    """`VerdictOptions` as keyword arguments."""

    periods: int
    skip: int | None
