"""The classical Runge–Kutta method of order 4, in steps of equal length."""

from __future__ import annotations

import numpy as np

from linkages.solvers.coefficients.tableau import Tableau
from linkages.solvers.methods.method import RungeKutta


def tableau() -> Tableau:
    """Kutta's coefficients (Hairer, Nørsett & Wanner, table II.1.2, left)."""
    return Tableau(
        name="rk4",
        order=4,
        A=np.array(
            [
                [0.0, 0.0, 0.0, 0.0],
                [0.5, 0.0, 0.0, 0.0],
                [0.0, 0.5, 0.0, 0.0],
                [0.0, 0.0, 1.0, 0.0],
            ]
        ),
        b=np.array([1 / 6, 1 / 3, 1 / 3, 1 / 6]),
        c=np.array([0.0, 0.5, 0.5, 1.0]),
    )


RK4 = RungeKutta(
    name="rk4",
    order=4,
    adaptive=False,
    summary="classical Runge–Kutta of order 4, fixed step",
    build=tableau,
)
