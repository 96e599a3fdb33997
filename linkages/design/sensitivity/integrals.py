"""Weights with which a series in a motion is integrated over time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(5)
_POINTS, _WEIGHTS = 0.5 * (1.0 + _POINTS), 0.5 * _WEIGHTS


def simpson(grid: Floats) -> tuple[Floats, Floats]:
    """Simpson's rule between samples, for a series that is smooth: places and weights."""
    steps = np.diff(grid)
    places = np.empty(2 * len(steps) + 1)
    places[::2], places[1::2] = grid, 0.5 * (grid[1:] + grid[:-1])
    weights = np.zeros(len(places))
    weights[:-1:2] += steps / 6.0
    weights[1::2] += steps * (2.0 / 3.0)
    weights[2::2] += steps / 6.0
    return places, weights


def gauss(grid: Floats, sides: Floats) -> tuple[Floats, Floats]:
    """Gauss's rule between samples, for a series that is smooth between changes.

    Beside a change it may go with the root of the time from there, as derivatives of a force of
    Hertz do: places lie as squares there.

    Parameters
    ----------
    grid
        Places of the samples, in order.
    sides
        Those of them that lie just before a change, and just behind it, shape (changes, 2).
    """
    before, behind = np.isin(grid, sides[:, 0]), np.isin(grid, sides[:, 1])
    whole = ~before[:-1]
    starts, steps = grid[:-1][whole, None], np.diff(grid)[whole, None]
    early, late = behind[:-1][whole, None], before[1:][whole, None]
    part = np.where(early, _POINTS**2, np.where(late, 1.0 - _POINTS**2, _POINTS))
    rate = np.where(early | late, 2.0 * _POINTS, 1.0)
    return (starts + steps * part).ravel(), (steps * rate * _WEIGHTS).ravel()
