"""The adaptive method of exported programs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.solvers.methods.dop853 import tableau


def dop853_tables() -> dict[str, NDArray[np.float64]]:
    """Coefficients of Dormand and Prince's method of order 8, as its tableau has them.

    Those of stages, of the result, of times and of both error estimates; then of the stages for
    dense output and of their times, and powers of the part of a step.
    """
    method = tableau()
    assert method.dense_A is not None
    assert method.dense_c is not None
    assert method.dense is not None
    return {
        "a": method.A,
        "b": method.b,
        "c": method.c,
        "error": method.error,
        "further_a": method.dense_A,
        "further_c": method.dense_c,
        "dense": method.dense,
    }
