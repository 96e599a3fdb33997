"""Lines of a spectrum as whole multiples and combinations of one or two base frequencies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.spectrum import PowerSpectrum

Floats = NDArray[np.float64]

EXPLAINED = 0.999
"""Part of the power of lines that base frequencies must account for."""

_STRONGEST = 8
_DIVISORS = range(1, 9)


@dataclass(frozen=True, eq=False)
class Combinations:
    """Lines as combinations of base frequencies.

    Parameters
    ----------
    bases
        In Hz, none, one (periodic) or two (quasi-periodic).
    orders
        Whole numbers (a, b) for each line with frequency a·f₁ + b·f₂, b = 0 for one base; None
        where there are none. In the order of the lines.
    explained
        Part of the power of all lines that these carry.
    """

    bases: tuple[float, ...]
    orders: tuple[tuple[int, int] | None, ...]
    explained: float

    @property
    def complete(self) -> bool:
        """Whether the bases account for the lines."""
        return self.explained >= EXPLAINED


def combinations(
    spectrum: PowerSpectrum,
    *,
    base: float | None = None,
    order: int = 12,
    tolerance: float = 0.25,
) -> Combinations:
    """Fewest base frequencies that account for the lines, with the lowest orders.

    One base is tried first, then two. Base frequencies are strong lines or 1/2 to 1/8 of them, so
    the result of a motion of period m is one base, 1/m of the drive's frequency. Two bases are
    determined up to whole combinations of each other; the simplest orders win.

    Parameters
    ----------
    spectrum
        With its lines.
    base
        A base frequency that is known, for example that of the drive, in Hz.
    order
        Largest |a| and |b|; of one base up to `order` times 8.
    tolerance
        How far a line may be off, in bins of the spectrum.
    """
    lines, powers = spectrum.lines, spectrum.powers
    if not len(lines):
        return Combinations(bases=(), orders=(), explained=1.0)
    within = tolerance * spectrum.resolution
    strongest = [float(line) for line in lines[:_STRONGEST]]
    singles = [line / m for m in _DIVISORS for line in ([base] if base else strongest[:2])]
    trials: list[Sequence[float]] = [(single,) for single in singles]
    first = [base] if base else strongest[:3]
    seconds = [line / m for m in (1, 2, 3) for line in strongest]
    pairs = [(f, g) for f, g in product(first, seconds) if abs(f - g) > within]
    best: Combinations | None = None
    for group in (trials, pairs):
        found = [_fit(lines, powers, bases, order, within) for bases in group]
        if not found:
            continue
        chosen = max(found, key=_merit)
        if best is None or chosen.explained > best.explained + 1e-6:
            best = chosen
        if best.complete:
            break
    assert best is not None
    return best


def _merit(trial: Combinations) -> tuple[float, int]:
    known = [pair for pair in trial.orders if pair is not None]
    return round(min(trial.explained, EXPLAINED), 6), -sum(abs(a) + abs(b) for a, b in known)


def _fit(
    lines: Floats, powers: Floats, bases: Sequence[float], order: int, within: float
) -> Combinations:
    """Lowest orders for each line."""
    if len(bases) == 1:
        a, b = np.arange(1, 8 * order + 1), np.zeros(8 * order, dtype=int)
        sums = a * bases[0]
    else:
        span = np.arange(-order, order + 1)
        a, b = (grid.ravel() for grid in np.meshgrid(span, span))
        sums = a * bases[0] + b * bases[1]
    size = np.abs(a) + np.abs(b)
    orders: list[tuple[int, int] | None] = []
    for line in lines:
        near = np.flatnonzero(np.abs(sums - line) <= within)
        best = near[np.argmin(size[near])] if len(near) else None
        orders.append(None if best is None else (int(a[best]), int(b[best])))
    known = np.array([pair is not None for pair in orders])
    explained = float(powers[known].sum() / powers.sum())
    return Combinations(bases=tuple(bases), orders=tuple(orders), explained=explained)
