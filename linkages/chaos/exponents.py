"""Lyapunov exponents of any system: spectrum, convergence, standard errors.

After DynamicalSystemsBase.jl: an analysis that asks for no more than `TangentSystem` serves
linkages, ordinary differential equations and maps alike.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.averages import drift, mean_error, slow_error
from linkages.errors import ComputationError, Interrupted, UnfinishedError

if TYPE_CHECKING:
    import xarray as xr

BEYOND = 3.0
"""Standard errors beyond which an exponent differs from zero."""


@dataclass(frozen=True, kw_only=True)
class Invariant:
    """A combination of exponents whose value is known, all numbers in 1/s.

    `found`, `expected`: from the exponents, and what is known.
    `tolerance`: how much the two may differ: four standard errors of the difference, or a tenth of
    the largest standard error of the exponents where the two must agree along every motion.
    """

    name: str  # what it is, such as ``"sum of all exponents"``
    reason: str  # why it is known
    found: float
    expected: float
    tolerance: float

    @property
    def holds(self) -> bool:
        """Whether the two agree within the tolerance."""
        return abs(self.found - self.expected) <= self.tolerance

    @property
    def violation(self) -> str:
        """What is wrong, as a sentence; empty if it holds."""
        if self.holds:
            return ""
        return (
            f"The {self.name} must be {self.expected:.4g} ± {self.tolerance:.2g} 1/s "
            f"({self.reason}), and {self.found:.4g} 1/s was found: the exponents cannot be right. "
            "Take a smaller step or tolerance, or a longer run."
        )

    def to_dict(self) -> dict[str, Any]:
        """As plain data for JSON."""
        return {**asdict(self), "holds": self.holds}


Floats = NDArray[np.float64]

_SEED = 20240501


Watch = Callable[[float], None]
"""Is called now and then with the fraction done."""


@dataclass(frozen=True, eq=False)
class Growth:
    """What some intervals of a motion with tangents show.

    `states`, `times`: at the ends of intervals, shape (intervals, d) and (intervals,).
    """

    rates: Floats  # mean rates at which tangents grew within each interval, shape (intervals, k)
    states: Floats
    times: Floats
    tangents: Floats  # there, brought back to length one, shape (intervals, d, k)
    # Whether sticking and contacts that close may take tangents away: those are zero, and their
    # rates −∞
    loses: bool = False


class TangentSystem(Protocol):
    """A motion together with tangents to it.

    `state` is a copy of shape (d,), `tangents` of shape (d, k); d and the meaning of the entries
    of `state` never change. A system may fix k when it is built, then setting another number is an
    error.
    """

    @property
    def state(self) -> Floats:
        """Copy of the state, shape (d,), angles within one turn."""

    @property
    def tangents(self) -> Floats:
        """Copy of the tangents, shape (d, k)."""

    @tangents.setter
    def tangents(self, values: Floats) -> None: ...

    @property
    def furthest(self) -> float:
        """Ratio of lengths of tangents after one interval beyond which the shortest is but error.

        Infinite for a system that brings them back in time by itself.
        """

    @property
    def time(self) -> float:
        """Seconds for a flow, steps for a map."""

    @property
    def angles(self) -> NDArray[np.bool_]:
        """Which entries of the state are angles kept within one turn, shape (d,)."""

    def advance(self, interval: float) -> None:
        """Move the state along the motion and the tangents along its variational equations."""

    def grow(
        self,
        intervals: int,
        interval: float,
        *,
        orthogonal: bool = True,
        watch: Watch | None = None,
    ) -> Iterator[Growth]:
        """Move on, with tangents brought back to length one after every interval.

        `intervals`, `interval`: how many, and their length in seconds or steps.
        Yields: what the next intervals show, as many at once as suits the system. An error is
        raised after what came before it.
        """


def random_directions(size: int, columns: int) -> Floats:
    """Orthonormal directions, always the same ones, shape (size, columns).

    Axes of the state space may lie in invariant subspaces; these almost surely do not.
    """
    return _random_directions(size, columns).copy()


@lru_cache(maxsize=64)
def _random_directions(size: int, columns: int) -> Floats:
    return np.linalg.qr(np.random.default_rng(_SEED).normal(size=(size, columns)))[0]


def start_tangents(system: TangentSystem, columns: int) -> None:
    """Give a system that many random directions."""
    size = len(system.state)
    if not 1 <= columns <= size:
        raise ValueError(f"count must be from 1 to {size}, not {columns}")
    tangents = random_directions(size, columns)
    with contextlib.suppress(ValueError):  # NumPy's message on shapes would not help
        system.tangents = tangents
    carried = system.tangents.shape
    if carried != tangents.shape:
        raise ValueError(
            f"the system carries {carried[1]} tangents, {columns} are needed: build it with as many"
        )


def replace_lost(system: TangentSystem) -> None:
    """Give a system new directions for those that it has lost, orthonormal to all others.

    The growth of tangents is that of neighbours from here on: what was lost before does not count.
    """
    tangents = system.tangents
    lost = ~tangents.any(axis=0)
    if lost.any():
        kept = tangents[:, ~lost]
        more = random_directions(len(tangents), len(tangents))
        whole = np.linalg.qr(np.hstack([kept, more]))[0]
        tangents[:, lost] = whole[:, kept.shape[1] : tangents.shape[1]]
        system.tangents = tangents


def part_of(watch: Watch | None, first: float, count: float, whole: float) -> Watch | None:
    """What watches a part of a computation, if the whole is watched: where it begins, its size."""
    return None if watch is None else lambda done: watch((first + count * done) / whole)


FEWEST_INTERVALS = 64
"""Four parts of a history are compared, each with an error of its own."""

DRIFTS = 6.0
"""Drift, in standard errors, from which on a history has not settled."""


@dataclass(frozen=True, eq=False)
class Exponents:
    """Lyapunov exponents in 1/s (of a map: per step), the largest first.

    `lost`: how many more there are of −∞: a rigid contact that closes leaves no neighbours off its
    wall, nor does dry friction that sticks leave any that slip; these directions are lost.
    `touch`: rate, time and contact of the touch at the smallest rate behind `skip`; None if nothing
    touches. Where it tends to zero, tangents jump without bound and exponents converge slowly [1]_.

    References
    ----------
    .. [1] A. B. Nordmark, J. Sound Vib. 145 (1991) 279: grazing.
    """

    # Mean growth rate of each direction over each interval, shape (intervals, count)
    growth: Floats
    states: Floats  # states at the ends of intervals, the start included, shape (intervals + 1, d)
    times: Floats  # their times, shape (intervals + 1,), in seconds or steps
    furthest: float = math.inf  # as `TangentSystem` has it
    # What is known of them otherwise; empty where nothing is, or the spectrum is not whole
    certificate: tuple[Invariant, ...] = ()
    lost: int = 0
    touch: tuple[float, float, str] | None = None

    @property
    def lengths(self) -> Floats:
        """Lengths of intervals, shape (intervals,)."""
        return np.diff(self.times)

    @cached_property
    def values(self) -> Floats:
        """The exponents, shape (count,)."""
        return self.growth.mean(axis=0)

    @cached_property
    def errors(self) -> Floats:
        """Standard errors, shape (count,): of order 1/T along regular motions.

        They are those of `mean_error`, or of `slow_error` where these are larger.
        """
        if not self.some:
            return np.empty(0)
        slow = slow_error(self.growth, float(self.lengths.mean()))
        return np.maximum(mean_error(self.growth)[0], slow)

    @property
    def some(self) -> bool:
        """Whether any is finite: contacts that close and friction may take all neighbours away."""
        return self.growth.shape[1] > 0

    @property
    def largest(self) -> tuple[float, float]:
        """The largest exponent, and its standard error."""
        return (float(self.values[0]), float(self.errors[0])) if self.some else (-math.inf, 0.0)

    @cached_property
    def history(self) -> Floats:
        """Exponents after each interval, shape (intervals, count); belongs to ``times[1:]``."""
        number = np.arange(1, len(self.growth) + 1)[:, None]
        return np.cumsum(self.growth, axis=0) / number

    @property
    def sum(self) -> tuple[float, float]:
        """Sum of all exponents and its standard error: the mean rate of change of volumes."""
        total = self.growth.sum(axis=1)
        return float(total.mean()), float(mean_error(total)[0][0])

    @cached_property
    def apart(self) -> float:
        """Largest ratio of lengths that tangents come to within one interval, as a logarithm."""
        if not self.some:
            return 0.0
        return float((np.ptp(self.growth, axis=1) * self.lengths).max())

    @cached_property
    def unsettled(self) -> str:
        """Why the values cannot be trusted yet; empty if they can."""
        if not self.some:
            return ""
        if self.apart > math.log(self.furthest):
            return (
                f"Tangents differ by a factor of {np.exp(min(self.apart, 700)):.0e} after an "
                "interval, more than numbers resolve: take shorter intervals."
            )
        drifts, found = drift(self.growth), mean_error(self.growth)[1]
        if (drifts > DRIFTS).any():
            worst = int(np.argmax(drifts > DRIFTS))
            quarters = [part[:, worst].mean() for part in np.array_split(self.growth, 4)]
            text = ", ".join(f"{value:.4g}" for value in quarters)
            falls = abs(quarters[-1]) < 0.5 * abs(quarters[0])
            return (
                f"Exponent {worst + 1} drifts: the quarters of the run give {text}. The motion "
                + ("is regular" if falls else "stays long in one region after the other")
                + ", or has not reached its attractor: skip more or run longer."
            )
        if not found.all():
            return (
                f"Exponent {int(np.argmin(found)) + 1}: growth is correlated over times as long as "
                "the run, so its error is too small. Run longer."
            )
        return ""

    @property
    def settled(self) -> bool:
        """Whether no exponent drifts beyond its error; `unsettled` says why."""
        return not self.unsettled


def lyapunov_spectrum(
    system: TangentSystem,
    *,
    intervals: int,
    interval: float,
    count: int | None = None,
    skip: int = 0,
    certify: Callable[[Exponents], tuple[Invariant, ...]] | None = None,
    watch: Callable[[float], None] | None = None,
) -> Exponents:
    """Lyapunov exponents from tangents that are made orthonormal again after every interval.

    `interval`: length of one in seconds or steps. A whole part or multiple of the drive period
    makes the history smooth.
    `skip`: intervals before the average begins: motion and tangents find their attractor in them.
    Directions that are lost in them alone count as others.
    Raises ValueError for numbers out of range, or if the system carries another number of tangents.
    Raises ComputationError if the motion cannot go on, or tangents become parallel within an
    interval; an `UnfinishedError` with the exponents up to there if that was long enough.
    Raises Interrupted after Ctrl-C; ``kept["exponents"]`` has the same then.

    References
    ----------
    .. [1] G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15 (1980) 9 and 21.
    .. [2] I. Shimada, T. Nagashima, Prog. Theor. Phys. 61 (1979) 1605.
    """
    size = len(system.state)
    columns = size if count is None else count
    if intervals < FEWEST_INTERVALS:
        raise ValueError(f"intervals must be at least {FEWEST_INTERVALS}, not {intervals}")
    if not interval > 0 or skip < 0:
        raise ValueError("interval must be > 0 and skip must be ≥ 0")
    start_tangents(system, columns)
    growth, states, times = [np.empty((0, columns))], [np.empty((0, size))], [np.empty(0)]
    done, whole = 0, skip + intervals

    def found() -> Exponents:
        joined = [np.concatenate(parts) for parts in (growth, states, times)]
        left = ~np.isneginf(joined[0]).any(axis=0)
        part = Exponents(
            growth=joined[0][:, left],
            states=joined[1],
            times=joined[2],
            furthest=system.furthest,
            lost=columns - int(left.sum()),
        )
        return part if certify is None else replace(part, certificate=certify(part))

    try:
        for grown in system.grow(skip, interval, watch=part_of(watch, 0, skip, whole)):
            _require_length(grown)
        replace_lost(system)
        states.append(system.state[None])
        times.append(np.array([system.time]))
        for grown in system.grow(intervals, interval, watch=part_of(watch, skip, intervals, whole)):
            _require_length(grown)
            growth.append(grown.rates)
            states.append(grown.states)
            times.append(grown.times)
            done += len(grown.times)
    except (ComputationError, KeyboardInterrupt) as error:
        kept = {"exponents": found()} if done >= FEWEST_INTERVALS else {}
        if isinstance(error, KeyboardInterrupt):
            text = f"at t = {system.time:.9g} s: interrupted"
            raise Interrupted(text, time=system.time, kept=kept) from None
        if not kept:
            raise
        raise UnfinishedError(str(error), kept, time=error.time) from None
    return found()


def _require_length(grown: Growth) -> None:
    """Tangents that vanish have no direction to go on with, but where contacts took them."""
    taken = np.isneginf(grown.rates) & grown.loses
    lost = ~(np.isfinite(grown.rates) | taken).all(axis=1)
    if lost.any():
        time = float(grown.times[np.argmax(lost)])
        raise ComputationError(
            f"A tangent vanished within the interval before time {time:g}; "
            "take shorter intervals or fewer exponents.",
            time=time,
        )


def exponent_rows(data: xr.Dataset) -> list[dict[str, Any]]:
    """Each exponent with its error and what can be said about its sign."""
    rows = []
    for index in data["index"].to_numpy():
        value, error = (float(data[key].sel(index=index)) for key in ("exponent", "error"))
        sign = "zero within its error"
        if abs(value) > BEYOND * error:
            sign = "positive" if value > 0 else "negative"
        rows.append({"index": int(index), "value": value, "error": error, "sign": sign})
    return rows


def certificate_rows(data: xr.Dataset) -> list[dict[str, Any]]:
    """What is known of the exponents, and whether it holds."""
    rows = []
    for place, name in enumerate(data["invariant"].to_numpy()):
        row = {key: float(data[key][place]) for key in ("found", "expected", "tolerance")}
        holds = abs(row["found"] - row["expected"]) <= row["tolerance"]
        rows.append({"name": str(name), **row, "holds": holds})
    return rows
