"""Dormand and Prince's method of order 8 with dense output of order 7, adaptive.

References
----------
.. [1] E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed.,
       Springer 1993, sections II.5 and II.6.
"""

from __future__ import annotations

from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray

from linkages.solvers.coefficients.tableau import Tableau
from linkages.solvers.methods.method import RungeKutta


def tableau() -> Tableau:
    """Coefficients of [1]_ as SciPy publishes them."""
    published = _published()
    stages, rows = published.N_STAGES, published.N_STAGES + 1
    return Tableau(
        name="dop853",
        order=8,
        A=published.A[:stages, :stages],
        b=published.B,
        c=published.C[:stages],
        error=np.array([published.E5, published.E3]),
        error_order=7,
        dense_A=published.A[rows:],
        dense_c=published.C[rows:],
        dense=_powers(published.B, published.D),
    )


def _published() -> SimpleNamespace:
    """What the file of SciPy with the coefficients defines.

    By itself: importing ``scipy.integrate``, to which it belongs, takes longer than most runs.
    """
    import scipy

    file = Path(scipy.__file__).parent / "integrate" / "_ivp" / "dop853_coefficients.py"
    return SimpleNamespace(**run_path(str(file)))


def _powers(b: NDArray[np.float64], D: NDArray[np.float64]) -> NDArray[np.float64]:
    """Dense output of [1]_, (II.6.13 ff.), in powers of θ, shape (16, 7).

    Published as ``θ(F_0 + (1-θ)(F_1 + θ(F_2 + (1-θ)(F_3 + …))))`` with ``F_0 = y_1 - y_0``,
    ``F_1 = h k_0 - F_0``, ``F_2 = 2 F_0 - h (k_0 + k_12)`` and ``F_3…6 = h D k``.
    """
    rows = D.shape[1]
    increment, first, last = np.zeros((3, rows))
    increment[: len(b)] = b
    first[0] = last[len(b)] = 1.0
    parts = [increment, first - increment, 2 * increment - first - last, *D]
    result = np.zeros((rows, len(parts)))
    basis = np.array([1.0])
    for power, part in enumerate(parts):
        # Coefficients of the polynomial are kept from the constant term upwards.
        basis = np.convolve(basis, [0.0, 1.0] if power % 2 == 0 else [1.0, -1.0])
        result[:, : len(basis) - 1] += part[:, None] * basis[1:]
    return result


DOP853 = RungeKutta(
    name="dop853",
    order=8,
    adaptive=True,
    summary="Dormand–Prince of order 8(5,3), adaptive, dense output of order 7",
    build=tableau,
)
