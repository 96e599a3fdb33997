"""How well fitted numbers are known: covariance, correlation, and what cannot be told apart.

P. R. Bevington and D. K. Robinson, *Data Reduction and Error Analysis for the Physical Sciences*,
3rd ed., 2003, chapters 7 and 8.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.design.varied.ranges import Ranges

Floats = NDArray[np.float64]

SINGULAR = 1e-7
"""Ratio of singular values, of columns of length one, below which numbers cannot be told apart."""


@dataclass(frozen=True)
class Known:
    """How well numbers are known.

    Parameters
    ----------
    chi_square
        Sum of squares of residuals, each as a part of its standard deviation.
    freedom
        Number of measured values less numbers that were fitted.
    probability
        That chi-square is as large or larger by chance; nan where standard deviations are unknown.
    covariance
        Of the numbers in SI, shape (paths, paths); nan of those at bounds, or not to be told apart.
    notes
        What is doubtful.
    """

    chi_square: float
    freedom: int
    probability: float
    covariance: Floats
    notes: tuple[str, ...]

    @property
    def errors(self) -> Floats:
        """Standard errors in SI."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> Floats:
        """Between −1 and 1, shape (paths, paths)."""
        return self.covariance / np.outer(self.errors, self.errors)


def known(
    ranges: Ranges, residuals: Floats, slopes: Floats, at_bound: NDArray[np.bool_], absolute: bool
) -> Known:
    """How well numbers are known.

    Parameters
    ----------
    ranges
        What was varied.
    residuals, slopes
        At the best fit as parts of standard deviations, shape (m,), and derivatives by numbers in
        SI, (m, paths).
    at_bound
        Which numbers are at a bound: they are as if they were given.
    absolute
        Whether standard deviations are known.
    """
    chi_square = float(residuals @ residuals)
    free = np.flatnonzero(~at_bound)
    freedom = len(residuals) - len(free)
    notes = [f"{ranges.paths[place]} is at its bound" for place in np.flatnonzero(at_bound)]
    covariance = np.full((len(ranges), len(ranges)), np.nan)
    sizes = np.sqrt((slopes[:, free] ** 2).sum(axis=0))
    idle = free[sizes == 0.0]
    notes += [f"{ranges.paths[place]} changes nothing that was measured" for place in idle]
    free, sizes = free[sizes > 0.0], sizes[sizes > 0.0]
    if len(free):
        _, values, directions = np.linalg.svd(slopes[:, free] / sizes, full_matrices=False)
        weak = values <= SINGULAR * values[0]
        notes += [_alike(ranges, free, direction / sizes) for direction in directions[weak]]
        mixed = (np.abs(directions[weak]) > np.sqrt(SINGULAR)).any(axis=0)
        factor = 1.0 if absolute else chi_square / max(freedom, 1)
        scaled = directions[~weak] / values[~weak, None]
        found = factor * (scaled.T @ scaled) / np.outer(sizes, sizes)
        found[mixed], found[:, mixed] = np.nan, np.nan
        covariance[np.ix_(free, free)] = found
    if freedom < 1:
        notes.append(f"{len(residuals)} values were measured for {len(free)} numbers")
    return Known(chi_square, freedom, _chance(chi_square, freedom, absolute), covariance, (*notes,))


def _chance(chi_square: float, freedom: int, absolute: bool) -> float:
    from scipy.special import gammaincc

    return float(gammaincc(freedom / 2, chi_square / 2)) if absolute and freedom > 0 else np.nan


def _alike(ranges: Ranges, free: NDArray[np.intp], direction: Floats) -> str:
    """Which numbers cannot be told apart, as a step that changes nothing."""
    width = np.array([ranges.each[place].upper - ranges.each[place].lower for place in free])
    step = direction / (direction / width)[np.argmax(np.abs(direction / width))] / 100.0
    large = np.abs(step / width) > 1e-6
    parts = [
        f"{ranges.paths[place]} by {'+' if size > 0 else ''}{ranges.each[place].shown(size)}"
        for place, size in zip(free[large], step[large], strict=True)
    ]
    return f"cannot be told apart: changing {' and '.join(parts)} changes nothing that was measured"
