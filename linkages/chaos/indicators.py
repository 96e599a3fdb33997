"""Fast indicators of chaos: FLI and GALI."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.exponents import TangentSystem, start_tangents

Floats = NDArray[np.float64]

ROUND_OFF = 1e-14
"""GALI below this says no more: tangents are parallel to double precision."""

REGULAR_POWER, CHAOTIC_POWER = 2.5, 8.0
"""Powers of time below which growth is that of regular motions, and above which that of chaos."""


class Verdict(StrEnum):
    """What an indicator says about a motion."""

    REGULAR = "regular"
    CHAOTIC = "chaotic"
    UNDECIDED = "undecided"


@dataclass(frozen=True, eq=False)
class Indicators:
    """Fast Lyapunov indicator and generalised alignment index over time.

    FLI says of every kind of system whether tangents grow exponentially, GALI only of those that
    conserve energy: with friction tangents also become parallel along regular motions. `classify`
    judges FLI, or minus the logarithm of GALI down to `ROUND_OFF`.

    Parameters
    ----------
    times
        Ends of intervals since the start, shape (n,), in seconds or steps.
    fli
        ln of the largest stretching of any tangent so far, shape (n,).
    gali
        Volume spanned by the k tangents of unit length, shape (n,); `ROUND_OFF` once it has
        reached that, for from then on it is that of round-off. 1 for a single tangent.
    """

    times: Floats
    fli: Floats
    gali: Floats


def fast_indicators(
    system: TangentSystem,
    *,
    intervals: int,
    interval: float,
    count: int = 2,
) -> Indicators:
    """FLI and GALI_k along a motion, from k tangents that are only brought back to length one.

    Parameters
    ----------
    intervals, interval
        How often, and after which time in seconds or steps, values are taken.
    count
        Number k of tangents: one is enough for FLI, GALI needs two. On an N-dimensional torus
        GALI_k stays constant for k ≤ N.

    References
    ----------
    .. [1] C. Froeschlé, E. Lega, R. Gonczi, Celest. Mech. Dyn. Astron. 67 (1997) 41.
    .. [2] Ch. Skokos, T. C. Bountis, Ch. Antonopoulos, Physica D 231 (2007) 30.
    """
    if intervals < 4 or not interval > 0 or count < 1:
        raise ValueError("intervals must be at least 4, interval > 0 and count at least 1")
    start_tangents(system, count)
    start = system.time
    parts = list(system.grow(intervals, interval, orthogonal=False))
    rates, tangents = (
        np.concatenate([getattr(p, n) for p in parts]) for n in ("rates", "tangents")
    )
    longest = np.cumsum(interval * rates, axis=0).max(axis=1)
    volumes = np.prod(np.linalg.svd(tangents, compute_uv=False), axis=1)
    parallel = np.logical_or.accumulate(volumes <= ROUND_OFF)
    return Indicators(
        times=np.concatenate([part.times for part in parts]) - start,
        fli=np.maximum.accumulate(np.maximum(longest, 0.0)),
        gali=np.where(parallel, ROUND_OFF, volumes),
    )


def last_power(times: Floats, logarithm: Floats) -> float:
    """The power of time that grows as much as a logarithm tells while time last doubled."""
    middle = int(np.searchsorted(times, 0.5 * times[-1]))
    return float(logarithm[-1] - logarithm[middle]) / math.log(2.0)


def classify(times: Floats, logarithm: Floats) -> Verdict:
    """Whether a logarithm grows like that of a power of time or like time itself.

    Along regular motions tangents grow, and volumes of tangents shrink, at most like a power p of
    time: the logarithm rises by p ln 2 while time doubles. Tangents grow with p = 1, volumes
    shrink with p ≤ 2 for k ≤ N + 1. Along chaotic motions the rise is λT/2 and passes any
    threshold.

    Parameters
    ----------
    times, logarithm
        Shape (n,) each; times count from the start.

    Returns
    -------
    Regular if the last doubling of time brings less than 2.5 ln 2, chaotic if it brings more than
    8 ln 2; undecided between: run longer.
    """
    power = last_power(times, logarithm)
    if power > CHAOTIC_POWER:
        return Verdict.CHAOTIC
    return Verdict.REGULAR if power < REGULAR_POWER else Verdict.UNDECIDED
