"""Options of analyses: sections, exponents, maps, basins, wear, orbits, branches and equilibria."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Literal

from linkages.options.option import OptionError
from linkages.options.run import FORM, RunKeywords, RunOptions
from linkages.spec.quantities import (
    Bound,
    Duration,
    Harmonics,
    Instant,
    Periods,
    PositiveInteger,
    Quantity,
    SkippedPeriods,
    Tolerance,
)
from linkages.spec.units import NUMBER

Indicator = Literal["exponent", "fli", "gali", "period"]
Start = Literal["same", "forward", "backward"]

FEWEST_MAP_PERIODS = 4
FEWEST_LOOKED_AT = 12
"""Periods that show whether a motion repeats."""

FEWEST_BASIN_PERIODS = 64
"""Fewer show neither contraction nor that a motion does not repeat."""

MOST_LEFT = 1e-2
"""More, and a motion that is only near an attractor would count as there."""


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
        Indicator to map. ``exponent`` is in 1/s, ``fli`` grows in proportion to time if the motion
        is chaotic, and ``gali`` shrinks to zero then, for motions that conserve energy.
        ``period`` is the number of periods of the drives after which the motion repeats.
    periods
        Length of each run in periods; for ``period`` the greatest, since a run ends as soon as it
        repeats.
    skip
        Periods before it, in which motions and tangents find their attractor.
    start
        For ``period``: start every point from the state of the definition (``same``), or from the
        last state of its neighbour along `x`: the one before (``forward``) or behind it
        (``backward``).
    refine
        For ``period``: compute every so many-th row and column first, a power of two, and points in
        between only if the corners of a cell differ. 1 computes all points.
    """

    indicator: Indicator = "exponent"
    periods: Periods = 100
    skip: SkippedPeriods = 0
    start: Start = "same"
    refine: PositiveInteger = 1

    def __post_init__(self) -> None:
        sections = self.indicator == "period"
        fewest = FEWEST_LOOKED_AT if sections else FEWEST_MAP_PERIODS
        if self.periods < fewest:
            what = " of 'period'" if sections else ""
            message = f"a map{what} needs at least {fewest} periods, found {self.periods}"
            raise OptionError("periods", message)
        if not sections:
            for name, usual in (("start", "same"), ("refine", 1)):
                if (found := getattr(self, name)) != usual:
                    message = f"{name} = {found} goes with the indicator 'period'"
                    raise OptionError(name, f"{message}, and it is {self.indicator!r}")
        if self.refine & (self.refine - 1):
            message = f"refine must be a power of two, found {self.refine}"
            raise OptionError("refine", message)
        if self.refine > 1 and self.start != "same":
            message = f"refine = {self.refine} goes with start = 'same', and it is {self.start!r}"
            raise OptionError("refine", message)


@dataclass(frozen=True, kw_only=True)
class VerdictOptions(RunOptions):
    """A verdict on a motion.

    Parameters
    ----------
    periods
        Length of the motion in periods, at least 200: common ones of the drives or, if there is
        none, mean returns to a section.
    skip
        Periods before it is judged; default: the transient, found automatically. Without friction
        there is none.
    """

    periods: Periods = 300
    skip: SkippedPeriods | None = None


@dataclass(frozen=True, kw_only=True)
class BasinOptions(RunOptions):
    """How motions are followed to their attractors.

    Parameters
    ----------
    periods
        Longest that a motion is followed, in periods: common ones of the drives, or units of
        `interval`. It ends as soon as its attractor is known.
    longest
        Most section points of a periodic motion: periods of the drives, or crossings.
    settled
        Distance to an attractor, over the range of the motion, below which the motion has reached
        it. The distance follows from the contraction of its section points.
    interval
        Length in s of what counts as a period if nothing depends on time; default: simulate.end.
    """

    periods: Periods = 1000
    longest: PositiveInteger = 32
    settled: Annotated[float, Quantity(NUMBER, Bound.POSITIVE)] = 1e-5
    interval: Duration | None = None

    def __post_init__(self) -> None:
        if self.periods < FEWEST_BASIN_PERIODS:
            message = f"expected at least {FEWEST_BASIN_PERIODS} periods, found {self.periods}"
            raise OptionError("periods", message)
        if not self.settled <= MOST_LEFT:
            message = f"settled must be at most {MOST_LEFT:g}, found {self.settled:g}"
            raise OptionError("settled", message)


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
    start: str
    refine: int


class BasinKeywords(RunKeywords, total=False):
    """`BasinOptions` as keyword arguments."""

    periods: int
    longest: int
    settled: float
    interval: float | None


class VerdictKeywords(RunKeywords, total=False):
    """`VerdictOptions` as keyword arguments."""

    periods: int
    skip: int | None


Direction = Literal["up", "down", "both"]


@dataclass(frozen=True, kw_only=True)
class SectionOptions(RunOptions):
    """Points of a motion: once a period of its drives, or where a quantity has a value.

    Parameters
    ----------
    periods
        Number of points: one per common period of the drives, or one per crossing of `section`.
    skip
        Points left out before.
    phase
        Phase in the period of the drives at which points are taken, from 0 to 1. Not with
        `section`.
    section
        Take points at crossings of this surface instead, e.g. ``slider9.velocity=0``. It is an
        element, a quantity of position or velocity (angle, speed, position, velocity) and a value
        in SI; or ``gap.touch``, where the pin of a clearance that opens touches its hole, or
        ``stops[0].lower.touch``, where a body touches a stop with restitution.
    direction
        How the section is crossed; ``down`` is where a pin that touches leaves its hole.
    end
        Time in s until which crossings of a section are looked for. If not given, ``periods + skip
        + 2`` times the common period of the drives (or the file's end time, if there is none).
    wrap
        Wrap angles to one turn.
    """

    periods: Periods = 500
    skip: SkippedPeriods = 0
    phase: Annotated[float, Quantity(NUMBER)] = 0.0
    section: str | None = field(default=None, metadata={FORM: "ELEMENT.QUANTITY=VALUE"})
    direction: Direction = "up"
    end: Instant | None = None
    wrap: bool = True

    def __post_init__(self) -> None:
        if not 0.0 <= self.phase < 1.0:
            message = f"phase must be from 0 to below 1, found {self.phase:g}"
            raise OptionError("phase", message)
        if self.section is None and self.direction != "up":
            raise OptionError("direction", f"direction {self.direction!r} {_NEEDED}")
        if self.section is not None and self.phase:
            raise OptionError(
                "phase",
                f"phase {self.phase:g} goes with points once a period; a section where a quantity "
                "has a value has none",
            )
        if self.end is not None and self.section is None:
            what = f"end = {self.end:g} s {_NEEDED}; points once a period end with their number"
            raise OptionError("end", what)
        if self.end is not None and not self.end > 0.0:
            raise OptionError("end", f"end must be a time in s > 0, found {self.end:g}")


@dataclass(frozen=True, kw_only=True)
class BifurcationOptions(SectionOptions):
    """Points at each value of a parameter.

    Parameters
    ----------
    periods
        Points at each value.
    skip
        Points left out before, at each value.
    start
        From the file's state, or from the last state of the value before. With ``same`` each value
        starts from the state of the definition; with ``forward`` or ``backward`` from the last
        state of the value before or behind it, in the same assembly mode and at the start of a
        period of the drives, which shows hysteresis.
    exponent
        Compute the largest Lyapunov exponent as well. It belongs to the motion of the
        points, over 100 periods that begin 10 after the first point.
    """

    periods: Periods = 200
    skip: SkippedPeriods = 100
    start: Start = "same"
    exponent: bool = False


_NEEDED = "goes with a section where a quantity has a value, and none is given"


class SectionKeywords(RunKeywords, total=False):
    """`SectionOptions` as keyword arguments."""

    periods: int
    skip: int
    phase: float
    section: str | None
    direction: str
    end: float | None
    wrap: bool


class BifurcationKeywords(SectionKeywords, total=False):
    """`BifurcationOptions` as keyword arguments."""

    start: str
    exponent: bool


Feedback = Literal["uniform", "profile"]


@dataclass(frozen=True, kw_only=True)
class WearOptions(RunOptions):
    """How far wear is followed, and how well.

    Parameters
    ----------
    revolutions
        Most revolutions, each of them a common period of drives and loads; default: until the
        limit.
    accuracy
        Allowed error of the growth of each clearance, over that growth.
    largest_jump
        Most growth of a clearance in one jump, over its size.
    feedback
        How a bearing grows: all around (``uniform``), or where wear arises (``profile``).
    harmonics
        Of a profile: motions do not see what is narrower than about 180° over their number.
    skip
        Revolutions in which the motion settles before the first mean; later ones continue from the
        last motion.
    longest
        Most revolutions that are computed for one mean; its remaining error counts.
    confirm
        Jump once more, half as far each time, and report how much that changes.
    """

    revolutions: PositiveInteger | None = None
    accuracy: Tolerance = 1e-2
    largest_jump: Tolerance = 0.25
    feedback: Feedback = "uniform"
    harmonics: Harmonics = 8
    skip: SkippedPeriods = 100
    longest: PositiveInteger = 2048
    confirm: bool = False


class WearKeywords(RunKeywords, total=False):
    """`WearOptions` as keyword arguments."""

    revolutions: int | None
    accuracy: float
    largest_jump: float
    feedback: str
    harmonics: int
    skip: int
    longest: int
    confirm: bool


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
