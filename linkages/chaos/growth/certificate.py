"""A certificate for exponents: what is known of them from inertia and loads, and whether it holds.

References
----------
.. [1] U. Dressler, Phys. Rev. A 38 (1988) 2103: pairs of exponents under uniform damping.
.. [2] H. Haken, Phys. Lett. A 94 (1983) 71: a zero exponent along motions that do not end in rest.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.growth.exponents import Exponents
from linkages.chaos.growth.invariants import Invariant
from linkages.chaos.growth.tangents import LinkageTangents
from linkages.chaos.growth.volumes import Volumes
from linkages.chaos.series.averages import mean_error
from linkages.solution.moving.free_coordinates import free_vectors
from linkages.solution.moving.motion import Motion, Piece
from linkages.solvers.renormalisation import MOST_DOUBT

Floats = NDArray[np.float64]

MOST_SAMPLES = 2**20
"""States that are kept of a run."""

SAMPLES = 16
"""States within an interval over which the rate of damping is averaged, a power of two."""

ERRORS = 4.0
"""Standard errors beyond which what is known does not hold."""

SMALL = 0.1
"""Part of the standard error of exponents that errors of integration may reach."""

STEPS = 10.0
"""Errors of a step that may add up within an interval."""

GOES_ON = 0.5
"""Part of the speed at the beginning that a motion keeps which does not come to rest."""


def samples_within(intervals: int) -> int:
    """How many states to keep of each interval: a power of two. One is enough without damping."""
    return int(min(SAMPLES, 2 ** max(1, int(np.log2(MOST_SAMPLES / intervals)))))


def certificate(
    tangents: LinkageTangents, exponents: Exponents, skip: int
) -> tuple[Invariant, ...]:
    """Invariants that a whole spectrum must show.

    - The sum of all exponents is the mean rate at which volumes of states change. It is computed
      from the mass matrix and the loads, along the same motion.
    - Where no force depends on velocities, exponents come in pairs λ and −λ; where momenta decay at
      the same rate γ in all directions, in pairs whose sum is −γ [1]_. Forces that follow from no
      energy part the pairs.
    - Where accelerations do not depend on time, an exponent is zero unless the motion comes to rest
      [2]_; a second one if energy is conserved.

    Where forces may jump as a speed changes its sign, volumes and momenta change at once there, and
    nothing is said of the sum and of pairs.

    Parameters
    ----------
    tangents
        What was integrated, and kept its `motion`.
    exponents
        The whole spectrum.
    skip
        Intervals before its average began.
    """
    if not exponents.some:
        return ()
    volumes, intervals = Volumes(tangents.system), len(exponents.growth)
    parts = 1 if volumes.conservative else min(tangents.parts, samples_within(intervals))
    between = tangents.parts // parts
    first, last = skip * tangents.parts, (skip + intervals) * tangents.parts + 1
    passed = tangents.motion.part(first, last, between)
    damping = _joined(passed, Volumes.damping_rates)
    logarithms = _joined(passed.part(each=parts), Volumes.logarithm)
    if tangents.metric.exchanged:  # which measures volumes of momenta
        logarithms = np.zeros_like(logarithms)
    numeric = _numeric(tangents.tolerance, exponents)
    floor = max(SMALL * float(exponents.errors.max()), numeric)
    traces = np.trace(damping, axis1=1, axis2=2) + _joined(passed, Volumes.relaxation)
    found = [_sum(exponents, traces, logarithms, parts, floor)] if volumes.told else []
    rate = volumes.uniform(damping) if volumes.told else None
    if rate is not None and volumes.potential:
        found += _pairs(exponents, rate, floor)
    count = len(tangents.system.topology.free)
    rates = free_vectors(tangents.system, passed)[:, count : 2 * count]
    if volumes.autonomous and _goes_on(rates, numeric):
        found += _zeros(exponents, volumes.conservative and volumes.potential, floor)
    return tuple(found)


def _numeric(tolerance: float, exponents: Exponents) -> float:
    """Errors of integration that growth rates may have.

    Those of as many steps as may add up in an interval, or in each of the stretches within it after
    which tangents that come apart are brought back.
    """
    stretch = max(1.0, math.log(MOST_DOUBT / tolerance))
    stretches = int(np.ptp(exponents.values) * exponents.lengths.mean() / stretch)
    return STEPS * max(tolerance, stretches * MOST_DOUBT) / float(exponents.lengths.min())


def _joined(motion: Motion, values: Callable[[Volumes, Piece], Floats]) -> Floats:
    """Values along a motion, in whatever coordinates it was integrated."""
    of_system = {piece.system: Volumes(piece.system) for piece in motion.pieces}
    return np.concatenate([values(of_system[piece.system], piece) for piece in motion.pieces])


def _sum(
    exponents: Exponents, damping: Floats, logarithms: Floats, parts: int, floor: float
) -> Invariant:
    """Every interval has its own sum, so that only errors of integration are left."""
    moved = np.diff(logarithms) / exponents.lengths
    expected = -moved - _means(damping, parts)
    coarse = expected if parts == 1 else -moved - _means(damping[::2], parts // 2)
    found, mean = float(exponents.growth.sum(axis=1).mean()), float(expected.mean())
    return Invariant(
        name="sum of all exponents",
        reason="the mean rate of change of volumes, from inertia and loads",
        found=found,
        expected=mean,
        tolerance=max(floor, abs(float(coarse.mean()) - mean)),
    )


def _means(values: Floats, parts: int) -> Floats:
    """Means over intervals of so many parts, by the trapezoidal rule."""
    between = 0.5 * (values[:-1] + values[1:])
    return np.asarray(between.reshape(-1, parts).mean(axis=1))


def pair_sums(exponents: Exponents) -> tuple[Floats, Floats]:
    """Sums λ_i + λ_{d+1-i} and their standard errors, shape (d/2,) each.

    Raises
    ------
    ValueError
        If the spectrum is not whole, or of an odd number.
    """
    whole, size = exponents.growth.shape[1], exponents.states.shape[1]
    if whole != size or whole % 2:
        raise ValueError(f"pairs need the whole spectrum of an even number, not {whole} of {size}")
    half = whole // 2
    sums = exponents.growth[:, :half] + exponents.growth[:, : -half - 1 : -1]
    return sums.mean(axis=0), mean_error(sums)[0]


def _pairs(exponents: Exponents, rate: float, floor: float) -> list[Invariant]:
    """One pair alone would be the sum of all."""
    size = exponents.states.shape[1]
    sums, errors = pair_sums(exponents)
    reason = "momenta decay at one rate" if rate else "no force depends on velocities"
    return [
        Invariant(
            name=f"sum of exponents {first + 1} and {size - first}",
            reason=reason,
            found=float(sums[first]),
            expected=0.0 - rate,
            tolerance=max(ERRORS * float(errors[first]), floor),
        )
        for first in range(len(sums) if len(sums) > 1 else 0)
    ]


def _goes_on(rates: Floats, least: float) -> bool:
    """Whether the last quarter of a motion is about as fast as the first, and does not rest.

    Slower than `least` is what moves within an interval by errors of integration only. `rates` has
    shape (samples, n).
    """
    quarter = len(rates) // 4
    first, last = (np.sqrt(np.mean(part**2)) for part in (rates[:quarter], rates[-quarter:]))
    return bool(last > max(GOES_ON * first, least))


def _zeros(exponents: Exponents, conservative: bool, floor: float) -> list[Invariant]:
    """The exponents nearest to zero."""
    count = 2 if conservative else 1
    nearest = sorted(np.argsort(np.abs(exponents.values), kind="stable")[:count].tolist())
    reason = "along the motion itself, since nothing depends on time"
    return [
        Invariant(
            name=f"exponent {index + 1}",
            reason=reason if number == 0 else "towards motions of other energy",
            found=float(exponents.values[index]),
            expected=0.0,
            tolerance=max(ERRORS * float(exponents.errors[index]), floor),
        )
        for number, index in enumerate(nearest)
    ]


def certified(
    verdict: str, reasons: Sequence[str], invariants: Sequence[Invariant]
) -> tuple[str, list[str]]:
    """A verdict and its reasons: none where something that must hold does not."""
    violations = [found.violation for found in invariants if not found.holds]
    if not violations:
        return verdict, list(reasons)
    return "undecided", [*violations, *reasons]
