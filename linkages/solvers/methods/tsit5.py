"""Tsitouras's method of order 5 with dense output of order 4, adaptive, for loose tolerances.

References
----------
.. [1] Ch. Tsitouras, "Runge–Kutta pairs of order 5(4) satisfying only the first column
       simplifying assumption", Computers and Mathematics with Applications 62 (2011), 770–775,
       table 1 and the interpolant of section 3.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.solvers.coefficients.tableau import Tableau
from linkages.solvers.methods.method import RungeKutta

NODES = [0.0, 0.161, 0.327, 0.9, 0.9800255409045097, 1.0]
STAGES = [
    [],
    [0.161],
    [-0.008480655492356989, 0.335480655492357],
    [2.8971530571054935, -6.359448489975075, 4.3622954328695815],
    [5.325864828439257, -11.748883564062828, 7.4955393428898365, -0.09249506636175525],
    [
        5.86145544294642,
        -12.92096931784711,
        8.159367898576159,
        -0.071584973281401,
        -0.028269050394068383,
    ],
]
WEIGHTS = [
    0.09646076681806523,
    0.01,
    0.4798896504144996,
    1.379008574103742,
    -3.290069515436081,
    2.324710524099774,
]
# Weights of order 5 less those of order 4; the last one belongs to the end of the step.
ERROR = [
    -0.00178001105222577714,
    -0.0008164344596567469,
    0.007880878010261995,
    -0.1447110071732629,
    0.5823571654525552,
    -0.45808210592918697,
    1 / 66,
]
# The interpolant's weights are these leading coefficients times θ times the factors below: one
# factor θ - r₁ and a quadratic for the first stage, θ times a quadratic for the others.
LEADING = [
    -1.0530884977290216,
    0.1017,
    2.490627285651252793,
    -16.54810288924490272,
    47.37952196281928122,
    -34.87065786149660974,
    2.5,
]
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


def tableau() -> Tableau:
    """Coefficients of [1]_."""
    stages = len(NODES)
    A = np.zeros((stages, stages))
    for row, weights in enumerate(STAGES):
        A[row, : len(weights)] = weights
    return Tableau(
        name="tsit5",
        order=5,
        A=A,
        b=np.array(WEIGHTS),
        c=np.array(NODES),
        error=np.array([ERROR]),
        error_order=4,
        dense=_powers(),
    )


def _powers() -> NDArray[np.float64]:
    """Interpolant of [1]_ in powers of θ, shape (7, 4)."""
    result = np.zeros((len(LEADING), 4))
    for row, (leading, (p, q)) in enumerate(zip(LEADING, QUADRATICS, strict=True)):
        root = FIRST_ROOT if row == 0 else 0.0
        # Coefficients are kept from the constant term upwards.
        result[row] = leading * np.convolve([-root, 1.0], [q, -p, 1.0])
    return result


TSIT5 = RungeKutta(
    name="tsit5",
    order=5,
    adaptive=True,
    summary="Tsitouras of order 5(4), adaptive, dense output of order 4; for loose tolerances",
    build=tableau,
    # Measured: 2 to 7 % fewer evaluations for the same error on a double pendulum and the nine-bar.
    # With more memory, errors no longer follow the tolerance within a factor of 10; methods of
    # order 8 and 9 gain on one problem and lose on the other, and go without.
    memory=0.02,
)
