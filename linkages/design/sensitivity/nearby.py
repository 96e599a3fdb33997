"""Polynomials that say all of a series near a place, with its derivatives by that place."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebpts1, chebval, chebvander
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_DEGREE = 24
NODES = chebpts1(_DEGREE + 1)
_FIT: Floats = np.asarray(np.linalg.inv(chebvander(NODES, _DEGREE)), dtype=float)
_EXACT = 1e-13
"""Relative size of the last coefficients of a polynomial that says all of a function."""


class Near(NamedTuple):
    """Polynomials about a place, in samples: Chebyshev coefficients, shape (degree + 1, rows)."""

    middle: float
    half: float
    coefficients: Floats

    @classmethod
    def through(cls, middle: float, half: float, rows: Floats) -> Near:
        """Those with values at `middle + half * NODES`, shape (rows, nodes)."""
        return cls(middle, half, _FIT @ np.broadcast_to(rows, (len(rows), len(NODES))).T)

    @property
    def exact(self) -> bool:
        """Whether they say all of what they are of."""
        size = np.abs(self.coefficients)
        return bool((size[-3:] <= _EXACT * size.max(axis=0)).all())

    def rate(self, place: float, order: int) -> Floats:
        """Derivatives at a place, by places, shape (rows,)."""
        found = chebval((place - self.middle) / self.half, chebder(self.coefficients, order))
        return np.asarray(found / self.half**order)
