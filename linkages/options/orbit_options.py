"""How orbits and equilibria are searched for, and how far branches of them are followed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from linkages.options.run import RunKeywords, RunOptions
from linkages.spec.quantities import Bound, Periods, PositiveInteger, Quantity, SkippedPeriods
from linkages.spec.units import NUMBER

What = Literal["auto", "orbits", "equilibria"]


@dataclass(frozen=True, kw_only=True)
class OrbitOptions(RunOptions):
    """Where a search for an orbit begins.

    Parameters
    ----------
    periods
        Periods of the drives until the orbit closes; default: those of the settled motion.
    skip
        Periods of the drives in which the motion settles first; without drives, tenths of
        ``simulate.end``. With 0 Newton's method starts from the state of the definition.
    longest
        Most periods of the drives until an orbit closes.
    starts
        Number of initial states: that of the definition, and others drawn at random from a box of
        three times the size of the settled motion. All orbits that are found are returned; branches
        are followed from all, each start at another value of the parameter.
    seed
        Seed of the random states.
    """

    periods: Periods | None = None
    skip: SkippedPeriods = 100
    longest: PositiveInteger = 16
    starts: PositiveInteger = 1
    seed: SkippedPeriods = 0


@dataclass(frozen=True, kw_only=True)
class FollowOptions(OrbitOptions):
    """How branches are followed.

    Parameters
    ----------
    what
        Follow orbits or equilibria; ``auto``: those to which the motion settles.
    points
        Most points of a branch in each direction.
    largest_step
        Largest distance of neighbouring points: parameters are measured in their range, states in
        their amplitudes.
    switch
        Follow the branches that leave at period doublings, branch points and Hopf points as well,
        up to `longest` periods of the drives.
    unstable
        Continue beyond a loss of stability; if not, a branch ends there.
    """

    what: What = "auto"
    points: PositiveInteger = 500
    largest_step: Annotated[float, Quantity(NUMBER, Bound.POSITIVE)] = 0.1
    switch: bool = False
    unstable: bool = True


class OrbitKeywords(RunKeywords, total=False):
    """`OrbitOptions` as keyword arguments."""

    periods: int | None
    skip: int
    longest: int
    starts: int
    seed: int


class FollowKeywords(OrbitKeywords, total=False):
    """`FollowOptions` as keyword arguments."""

    what: str
    points: int
    largest_step: float
    switch: bool
    unstable: bool


@dataclass(frozen=True, kw_only=True)
class EquilibriumOptions(RunOptions):
    """From where equilibria are searched for.

    Parameters
    ----------
    starts
        Number of positions from which Newton's method starts: that of the definition, and others
        within reach of it, drawn at random if more than one coordinate is free.
    seed
        Seed of the random positions.
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
