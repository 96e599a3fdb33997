"""Explicit Runge–Kutta methods of orders 4, 5 and 8.

References
----------
.. [1] Ch. Tsitouras, "Runge–Kutta pairs of order 5(4) satisfying only the first column
       simplifying assumption", Computers and Mathematics with Applications 62 (2011), 770–775,
       table 1 and the interpolant of section 3.
.. [2] E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed.,
       Springer 1993, sections II.5 and II.6.
"""

from __future__ import annotations

from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray

from linkages.solvers.methods.method import RungeKutta
from linkages.solvers.tableau import Tableau


def rk4_tableau() -> Tableau:
    """Kutta's coefficients (Hairer, Nørsett & Wanner, table II.1.2, left)."""
    return Tableau(
        name="rk4",
        order=4,
        A=np.diag([0.5, 0.5, 1.0], k=-1),
        b=np.array([1 / 6, 1 / 3, 1 / 3, 1 / 6]),
        c=np.array([0.0, 0.5, 0.5, 1.0]),
    )


RK4 = RungeKutta(
    name="rk4",
    order=4,
    adaptive=False,
    summary="classical Runge–Kutta of order 4, fixed step",
    build=rk4_tableau,
)


NODES = [0.0, 0.161, 0.327, 0.9, 0.9800255409045097, 1.0]
STAGES = [
    [],
    [0.161],
    [-0.008480655492356989, 0.335480655492357],
    [2.8971530571054935, -6.359448489975075, 4.3622954328695815],
    [5.325864828439257, -11.748883564062828, 7.4955393428898365, -0.09249506636175525],
    [
        5.86145544294642, -12.92096931784711, 8.159367898576159, -0.071584973281401,
        -0.028269050394068383,
    ],
]  # fmt: skip
WEIGHTS = [
    0.09646076681806523, 0.01, 0.4798896504144996, 1.379008574103742, -3.290069515436081,
    2.324710524099774,
]  # fmt: skip
# Weights of order 5 less those of order 4; the last one belongs to the end of the step.
ERROR = [
    -0.00178001105222577714, -0.0008164344596567469, 0.007880878010261995, -0.1447110071732629,
    0.5823571654525552, -0.45808210592918697, 1 / 66,
]  # fmt: skip
# The interpolant's weights are these leading coefficients times θ times the factors below: one
# factor θ - r₁ and a quadratic for the first stage, θ times a quadratic for the others.
LEADING = [
    -1.0530884977290216, 0.1017, 2.490627285651252793, -16.54810288924490272, 47.37952196281928122,
    -34.87065786149660974, 2.5,
]  # fmt: skip
FIRST_ROOT = 1.3299890189751412
# Of θ² - pθ + q: p and q.
QUADRATICS = [
    (1.4364028541716351, 0.7139816917074209),
    (2.1966568338249754, 1.2949852507374631),
    (2.38535645472061657, 1.57803468208092486),
    (1.21712927295533244 + 0.61620406037800089, 1.21712927295533244 * 0.61620406037800089),
    (1.203071208372362603 + 0.658047292653547382, 1.203071208372362603 * 0.658047292653547382),
    (1.2 + 2 / 3, 1.2 * 2 / 3),
    (1.0 + 0.6, 0.6),
]


def tsit5_tableau() -> Tableau:
    """Coefficients of [1]_, and its interpolant in powers of θ, from the constant term upwards."""
    stages = len(NODES)
    A = np.zeros((stages, stages))
    for row, weights in enumerate(STAGES):
        A[row, : len(weights)] = weights
    dense = np.zeros((len(LEADING), 4))
    for row, (leading, (p, q)) in enumerate(zip(LEADING, QUADRATICS, strict=True)):
        root = FIRST_ROOT if row == 0 else 0.0
        dense[row] = leading * np.convolve([-root, 1.0], [q, -p, 1.0])
    return Tableau(
        name="tsit5",
        order=5,
        A=A,
        b=np.array(WEIGHTS),
        c=np.array(NODES),
        error=np.array([ERROR]),
        error_order=4,
        dense=dense,
    )


TSIT5 = RungeKutta(
    name="tsit5",
    order=5,
    adaptive=True,
    summary="Tsitouras of order 5(4), adaptive, dense output of order 4; for loose tolerances",
    build=tsit5_tableau,
    # Measured: 2 to 7 % fewer evaluations for the same error on a double pendulum and the nine-bar.
    # With more memory, errors no longer follow the tolerance within a factor of 10; methods of
    # order 8 and 9 gain on one problem and lose on the other, and go without.
    memory=0.02,
)


def dop853_tableau() -> Tableau:
    """Coefficients of [2]_ as SciPy publishes them.

    Their file is run by itself: importing ``scipy.integrate``, to which it belongs, takes longer
    than most runs.
    """
    import scipy

    file = Path(scipy.__file__).parent / "integrate" / "_ivp" / "dop853_coefficients.py"
    published = SimpleNamespace(**run_path(str(file)))
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


def _powers(b: NDArray[np.float64], D: NDArray[np.float64]) -> NDArray[np.float64]:
    """Dense output of [2]_, (II.6.13 ff.), in powers of θ, shape (16, 7).

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
    build=dop853_tableau,
)
