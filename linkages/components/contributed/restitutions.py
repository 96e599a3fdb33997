"""What one impact of a free body reaches with a damping factor, and the factor that it takes."""

from __future__ import annotations

import math
from collections.abc import Callable


def restitution_reached(factor: float) -> float:
    """What one impact of a free body reaches with K dⁿ (1 + χ d'/d'₀), for every K, n and mass.

    It is the solution e of (1 + χ)/(1 − χ e) = exp(χ (1 + e)), by bisection.
    """
    if factor == 0.0:
        return 1.0
    return _bisected(lambda e: _balance(factor, e), 0.0, min(1.0, 1.0 / factor))


def factor_for(restitution: float) -> float:
    """The damping factor χ with which an impact reaches a restitution in (0, 1]."""
    if restitution == 1.0:
        return 0.0
    least = 0.75 * (1.0 - restitution**2)  # Lankarani and Nikravesh's, which is too small
    return _bisected(lambda factor: _balance(factor, restitution), least, 1.0 / restitution)


def _balance(factor: float, restitution: float) -> float:
    """ln((1 + χ)/(1 − χ e)) − χ (1 + e)."""
    rebound = factor * restitution
    if rebound >= 1.0:
        return math.inf
    return math.log1p(factor) - math.log1p(-rebound) - factor * (1.0 + restitution)


def _bisected(function: Callable[[float], float], low: float, high: float) -> float:
    """Where a function that is negative at `low` and positive at `high` is zero."""
    while low < (middle := 0.5 * (low + high)) < high:
        if function(middle) < 0.0:
            low = middle
        else:
            high = middle
    return high
