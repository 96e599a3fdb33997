"""Coefficients of collocation at Gauss's nodes, for equations of second order.

References
----------
.. [1] E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed.,
       Springer 1993, section II.7.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

from linkages.solvers.coefficients.rooted_trees import order_defect

# Nodes come out right to a unit in the last place, and sums of coefficients keep about this much.
ROUND_OFF = 1e-14


@dataclass(frozen=True, kw_only=True, eq=False)
class Collocation:
    """The implicit Runge–Kutta method of order 2s with s stages at Gauss's nodes.

    With ``q' = v, v' = a`` its stages need accelerations alone::

        V_i = v + h Σ_j A_ij a_j,    Q_i = q + h c_i v + h² Σ_j (A²)_ij a_j

    Parameters
    ----------
    stages
        Number s of stages.
    """

    stages: int

    def __post_init__(self) -> None:
        defect = order_defect(self.A, self.b, 2 * self.stages)
        if not defect < ROUND_OFF:
            raise ValueError(f"collocation: order is not {2 * self.stages}, off by {defect:.2e}")
        # Symmetry, which the behaviour over long times rests on: Hairer & al., theorem II.8.10.
        mirrored = self.A[::-1, ::-1] + self.A - self.b
        if not np.abs(mirrored).max() < ROUND_OFF:
            raise ValueError("collocation: the method is not symmetric")

    @cached_property
    def c(self) -> NDArray[np.float64]:
        """Nodes, shape (s,)."""
        return (1.0 + leggauss(self.stages)[0]) / 2

    @cached_property
    def b(self) -> NDArray[np.float64]:
        """Weights, shape (s,)."""
        return leggauss(self.stages)[1] / 2

    @cached_property
    def A(self) -> NDArray[np.float64]:  # noqa: N802
        """Integrals of the cardinal polynomials from 0 to each node, shape (s, s)."""
        # Gauss's own quadrature is exact for them, and loses fewer digits than their coefficients.
        return np.array([node * (self.b @ cardinals(self.c, node * self.c)) for node in self.c])

    @cached_property
    def ahead(self) -> NDArray[np.float64]:
        """Weights of starting values, shape (s, s + 1).

        They continue the polynomial through the accelerations at the nodes and at the end of a
        step to the nodes of the next step.
        """
        return cardinals(np.append(self.c, 1.0), 1.0 + self.c)


def cardinals(nodes: NDArray[np.float64], at: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values of the polynomials that are 1 at one node and 0 at the others.

    Parameters
    ----------
    nodes : (s,)
        Nodes; there is one polynomial for each.
    at : (m,)
        Where they are evaluated.

    Returns
    -------
    Values, shape (m, s).
    """
    columns = []
    for j, node in enumerate(nodes):
        others = np.delete(nodes, j)
        columns.append(np.prod((at[:, None] - others) / (node - others), axis=1))
    return np.stack(columns, axis=1)
