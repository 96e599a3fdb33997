"""Evidence from one stretch of a motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.averages import FEWEST as FEWEST_STEADY
from linkages.chaos.averages import steadiness
from linkages.chaos.exponents import Exponents
from linkages.chaos.indicators import FEWEST as FEWEST_TESTED
from linkages.chaos.indicators import Verdict, classify, last_power, zero_one
from linkages.chaos.periods import apart, differences, find_period
from linkages.chaos.tori import FEWEST as FEWEST_ON_CURVES
from linkages.chaos.tori import ClosedCurves, PhaseCurve, closed_curves, phase_curve

Floats = NDArray[np.float64]

TAILS = (1, 2, 8)
"""Whether all of a section repeats, its last half, or its last eighth."""

FEWEST_REPEATING = 24
"""Points of a tail below which it may repeat by chance."""

MOST_BANDS = 12
"""Bands of a chaotic motion that are told apart."""

REPEATING = 1e-6
"""Part of its range by which a series may differ from a periodic one and be that."""

RESTING = 10
"""One part of the stretch in so many, the last one, in which a motion at rest moves no more."""

SHRINKS = 0.9
"""Part of what an entry moved by in the part before, below which it moves less and less."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Evidence:
    """What a stretch of a motion shows."""

    points: Floats  # of the section, shape (points, d): the entries of the state
    times: Floats  # when they are met, shape (points,)
    angles: NDArray[np.bool_]  # which entries are angles, shape (d,)
    exponents: Exponents  # of the same stretch, with the growth of tangents in every interval
    autonomous: bool  # whether one exponent is zero because time does not matter
    rests: bool  # whether the motion is at rest at the end
    # Growth of the 0–1 test and its spread for each observed entry; empty for too few points
    tests: tuple[tuple[float, float], ...]
    period: int | None  # section points until the motion repeats at the end; None if it does not
    # Whether section points lie on closed curves; None where that was not looked for
    curves: ClosedCurves | None
    # Part of the stretch, from 0 to 1, from which on it repeats, rests, or lies on its curves
    settled: float
    # As `linkages.chaos.averages.steadiness` returns it; zeros for too few points
    steady: tuple[float, float]
    # How section points depend on the phase of each drive that has no period in common with the
    # stroboscope
    phases: tuple[PhaseCurve, ...] = ()

    @property
    def law(self) -> Verdict:
        """How tangents grow; those that shrink grow like a power of time, too, and so do none."""
        return self._law(1.0) if self.exponents.some else Verdict.REGULAR

    @property
    def shrinks(self) -> bool:
        """Whether all tangents shrink exponentially: the motion attracts its neighbours."""
        return not self.exponents.some or self._law(-1.0) is Verdict.CHAOTIC

    @property
    def neutral(self) -> int:
        """How many exponents, the largest first, cannot be told from zero."""
        told = [
            self._law(sign, index) is Verdict.REGULAR
            for index in range(self.exponents.growth.shape[1])
            for sign in (1.0, -1.0)
        ]
        alike = [one and other for one, other in zip(told[::2], told[1::2], strict=True)]
        return [*alike, False].index(False)

    @property
    def power(self) -> float:
        """Power of time with which tangents grew while time last doubled; −∞ if none is left."""
        return last_power(*self._lengths(0)) if self.exponents.some else -np.inf

    def _law(self, sign: float, index: int = 0) -> Verdict:
        times, lengths = self._lengths(index)
        return classify(times, sign * lengths)

    def _lengths(self, index: int) -> tuple[Floats, Floats]:
        """Times since the beginning, and logarithms of the lengths of a tangent."""
        times = self.exponents.times
        return times[1:] - times[0], np.cumsum(self.exponents.growth[:, index] * np.diff(times))


def gathered(
    points: Floats,
    times: Floats,
    angles: NDArray[np.bool_],
    exponents: Exponents,
    tolerance: Floats,
    *,
    autonomous: bool = False,
    rests: bool = False,
    observed: int | None = None,
    phases: tuple[Floats, ...] = (),
) -> Evidence:
    """Everything that section points and exponents of one stretch show.

    `tolerance`: difference of entries that counts as none, shape (d,).
    """
    count, points = len(points), _without_noise(points, angles, tolerance)
    period, curves, settled = None, None, 0.0
    if rests:
        settled = _part_before(exponents.states, exponents.states[-1:], angles, tolerance)
    elif count >= FEWEST_REPEATING:
        period, settled = _repetition(points, angles, tolerance)
    over: tuple[PhaseCurve, ...] = ()
    if phases and not rests and period is None:
        over, settled = _over_phases(points, phases, angles)
    elif phases:
        over = tuple(phase_curve(points, phase, angles=angles) for phase in phases)
    smooth = bool(over) and all(curve.smooth for curve in over)
    if not rests and period is None and not smooth and count >= 2 * FEWEST_ON_CURVES:
        curves, settled = _curves(points, angles)
    columns = list(zip(points.T, angles, strict=True))[:observed]
    enough = count >= FEWEST_TESTED
    return Evidence(
        points=points,
        times=times,
        angles=angles,
        exponents=exponents,
        autonomous=autonomous,
        rests=rests,
        tests=tuple(_zero_one(*column) for column in columns) if enough else (),
        period=period,
        curves=curves,
        settled=settled,
        steady=steadiness(points, angles=angles) if count >= FEWEST_STEADY else (0.0, 0.0),
        phases=over,
    )


def _without_noise(points: Floats, angles: NDArray[np.bool_], tolerance: Floats) -> Floats:
    """Points whose entries are constant where they are but for round-off, as on their section."""
    alike = np.abs(apart(points, points[:1], angles)) <= tolerance
    return np.where(alike.all(axis=0), points[:1], points)


def ends_alike(exponents: Exponents, angles: NDArray[np.bool_], tolerance: Floats) -> bool:
    """Whether the last states are all the same: the motion rests, or its interval is a period."""
    last = exponents.states[-max(2, len(exponents.states) // RESTING) :]
    return _part_before(last, last[-1:], angles, tolerance) == 0.0


def shrinking(states: Floats, angles: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which entries move less in the last part of a stretch than in the one before, shape (d,)."""
    length = max(2, len(states) // RESTING)
    moved = np.abs(apart(states[-2 * length :], states[-1:], angles))
    return np.asarray(moved[-length:].max(axis=0) < SHRINKS * moved[:-length].max(axis=0))


def _repetition(
    points: Floats, angles: NDArray[np.bool_], tolerance: Floats
) -> tuple[int | None, float]:
    """The period with which the section ends, and the part of it before."""
    best = None
    for parts in TAILS:
        tail = points[-(len(points) // parts) :]
        if len(tail) < FEWEST_REPEATING:
            break
        result = find_period(tail, angles=angles, tolerance=tolerance)
        # where a multiplier is near -1, twice the period repeats sooner than the period
        if result.count is not None and (best is None or result.count < len(best.cycle)):
            best = result
    if best is None:
        return None, 0.0
    return best.count, _part_before(points, best.cycle, angles, tolerance)


def _part_before(
    points: Floats, cycle: Floats, angles: NDArray[np.bool_], tolerance: Floats
) -> float:
    """Part of some points, the last of which are a cycle, before all are like those of it."""
    again = cycle[(np.arange(len(points)) - len(points)) % len(cycle)]
    other = np.flatnonzero(differences(points, again, angles, tolerance) > 1.0)
    return float(other[-1] + 1) / len(points) if len(other) else 0.0


def _curves(points: Floats, angles: NDArray[np.bool_]) -> tuple[ClosedCurves, float]:
    """Closed curves on which all points lie, or else those of the later half."""
    whole = closed_curves(points, angles=angles)
    later = whole if whole.count else closed_curves(points[len(points) // 2 :], angles=angles)
    return (later, 0.5) if later.count and not whole.count else (whole, 0.0)


def _over_phases(
    points: Floats, phases: tuple[Floats, ...], angles: NDArray[np.bool_]
) -> tuple[tuple[PhaseCurve, ...], float]:
    """Curves over phases on which all points lie, or else those of the later half."""
    whole = tuple(phase_curve(points, phase, angles=angles) for phase in phases)
    if all(item.smooth for item in whole):
        return whole, 0.0
    half = len(points) // 2
    later = tuple(phase_curve(points[half:], phase[half:], angles=angles) for phase in phases)
    return (later, 0.5) if all(item.smooth for item in later) else (whole, 0.0)


def _zero_one(series: Floats, angle: np.bool_) -> tuple[float, float]:
    observed = np.cos(series) if angle else series
    beyond = _less_periodic_part(observed)
    if beyond.std() <= REPEATING * np.ptp(observed):
        return 0.0, 0.0  # what repeats is regular, and its round-off is not asked
    result = zero_one(beyond)
    return result.growth, result.spread


def _less_periodic_part(series: Floats) -> Floats:
    """A series less the periodic one that is closest to it.

    Chaos in several bands, visited one after the other, is regular but for what it does within
    them, and the 0–1 test would see little else. Regular series stay regular.
    """
    result = series - series.mean()
    for count in range(2, MOST_BANDS + 1):
        phase = np.arange(len(series)) % count
        means = np.bincount(phase, series) / np.bincount(phase)
        other = series - means[phase]
        if other.var() < result.var():
            result = other
    return result
