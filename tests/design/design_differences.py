"""Derivatives by Richardson's extrapolation of central differences, with what is left of error."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from linkages.design.differentiated import Differentiated

# a torque that jumps by two numbers at one time
TWO_JUMPS = """
joints: {O: [0, 0]}
parameters: {one: 0.3, other: 0.3}
bars: {arm: {joints: [O, A], length: 0.2, mass: 1}}
drives: {arm: {angle: 0, speed: 1}}
loads: [{bar: arm, torque: "where(t < one, 1, 2)"}, {bar: arm, torque: "where(t < other, 3, 7)"}]
"""


Floats = NDArray[np.float64]
LEVELS = 5


def richardson(
    function: Callable[[Floats], Floats], at: Floats, number: int, step: float
) -> tuple[Floats, Floats]:
    """Derivative by one number, and the least difference of neighbours in the tableau.

    Steps are halved from one level to the next; every column takes away another even power.
    """
    column = []
    for level in range(LEVELS):
        moved = np.zeros_like(at)
        moved[number] = step / 2**level
        column.append((function(at + moved) - function(at - moved)) / (2 * moved[number]))
    best, error = column[0], np.full_like(column[0], np.inf)
    for order in range(1, LEVELS):
        factor = 4.0**order
        finer = [(factor * b - a) / (factor - 1) for a, b in pairwise(column)]
        for place, value in enumerate(finer):
            beside = np.maximum(abs(value - column[place]), abs(value - column[place + 1]))
            best = np.where(beside < error, value, best)
            error = np.minimum(beside, error)
        column = finer
    return best, error


def compared(
    found: Differentiated, series: list[str], times: Floats, numbers: list[int], part: float
) -> tuple[Floats, Floats]:
    """How far derivatives are from differences, and what these can tell, (numbers, series, times).

    Both as parts of the derivative, or of the series per number where that is larger: a change of
    the series by less than that is round-off of the differences.

    Parameters
    ----------
    numbers, part
        Places of the numbers, and the largest step as a part of each.
    """
    exact = found.along(found.values, series, times)
    assert exact.derivatives is not None
    missed, attainable = [], []
    for number in numbers:
        size = abs(found.values[number]) or 1.0
        difference, error = richardson(
            lambda x: found.along(x, series, times, derivatives=False).values,
            found.values,
            number,
            part * size,
        )
        own = exact.derivatives[:, number]
        scale = np.maximum(np.abs(own), np.abs(exact.values) / size)
        scale = np.where(scale == 0.0, 1.0, scale)
        missed.append(np.abs(own - difference) / scale)
        attainable.append(error / scale)
    return np.array(missed), np.array(attainable)
