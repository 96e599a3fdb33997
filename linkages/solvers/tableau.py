"""Coefficients of Runge–Kutta methods and their order conditions.

A method has order p when ``b·Φ(τ) = 1/γ(τ)`` for each rooted tree τ of up to p nodes (E. Hairer,
S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., Springer 1993, theorem
II.2.13; collocation: section II.7).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import TypeAlias

import numpy as np
from numpy.polynomial.legendre import legder, leggauss, legroots, legval
from numpy.typing import NDArray

# A tree is the sorted tuple of the trees that hang from its root; () is a single node.
Tree: TypeAlias = tuple["Tree", ...]


@cache
def rooted_trees(nodes: int) -> tuple[Tree, ...]:
    """All rooted trees with a number of nodes: 1, 1, 2, 4, 9, 20, 48, 115 for 1 to 8 nodes."""
    return tuple(_forests(nodes - 1, nodes - 1))


def _forests(nodes: int, largest: int) -> list[Tree]:
    """Multisets of trees with `nodes` nodes together, none larger than `largest`."""
    if nodes == 0:
        return [()]
    result = set()
    for size in range(1, min(nodes, largest) + 1):
        for tree in rooted_trees(size):
            for rest in _forests(nodes - size, size):
                result.add(tuple(sorted((tree, *rest))))
    return sorted(result)


@cache
def size(tree: Tree) -> int:
    """Count the nodes of a tree."""
    return 1 + sum(size(branch) for branch in tree)


@cache
def density(tree: Tree) -> int:
    """Density γ(τ): the product of the sizes of all subtrees."""
    product = size(tree)
    for branch in tree:
        product *= density(branch)
    return product


def stage_weights(
    tree: Tree, A: NDArray[np.float64], known: dict[Tree, NDArray[np.float64]]
) -> NDArray[np.float64]:
    """Elementary weights Φ(τ) of the stages, shape (s,); `known` keeps those computed before."""
    if tree not in known:
        product = np.ones(len(A))
        for branch in tree:
            product = product * (A @ stage_weights(branch, A, known))
        known[tree] = product
    return known[tree]


def order_defect(A: NDArray[np.float64], b: NDArray[np.float64], order: int) -> float:
    """Largest violation ``|b·Φ(τ) - 1/γ(τ)|`` over all trees of up to `order` nodes."""
    known: dict[Tree, NDArray[np.float64]] = {}
    return max(
        abs(float(b @ stage_weights(tree, A, known)) - 1 / density(tree))
        for nodes in range(1, order + 1)
        for tree in rooted_trees(nodes)
    )


# Coefficients are printed with 16 digits or more and are of size 100 at most, so that sums of
# them keep about this many.
ROUND_OFF = 2e-13


def _table() -> NDArray[np.float64]:
    return np.zeros((0, 0))


@dataclass(frozen=True, kw_only=True, eq=False)
class Tableau:
    """Butcher tableau with its error estimate and its dense output.

    Rows are counted as a solver computes them: s stages, the end of the step (row s), then e
    further stages that only the dense output needs.

    `A`, `b`, `c`: coefficients, of shapes (s, s), (s,) and (s,).
    `error`: shape (0 to 2, s + 1); weights of the error estimate; of two rows the first is the main
    estimate and the second one of lower order (see `step_size.error_norm`).
    `dense_A`, `dense_c`: further stages, of shapes (e, s + 1 + e) and (e,).
    `dense`: shape (s + 1 + e, d); ``y(θ) = y_0 + h Σ_j k_j Σ_i dense[j, i] θ**(i + 1)``. Default:
    the cubic Hermite polynomial through states and slopes at both ends.
    """

    name: str  # name in messages
    order: int  # order of the method
    A: NDArray[np.float64]
    b: NDArray[np.float64]
    c: NDArray[np.float64]
    error: NDArray[np.float64] = field(default_factory=_table)
    # Order of the error estimate; the error of a step goes like ``h**(error_order + 1)``
    error_order: int = 0
    dense_A: NDArray[np.float64] = field(default_factory=_table)  # noqa: N815
    dense_c: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    dense: NDArray[np.float64] = field(default_factory=_table)

    def __post_init__(self) -> None:
        if not self.dense.size:
            object.__setattr__(self, "dense", _hermite(self.b))
        self._check_stages()
        self._check_order()
        self._check_dense()

    @property
    def stages(self) -> int:
        """Number s of stages; also the row that holds the end of a step."""
        return len(self.b)

    @property
    def end(self) -> int:
        """The row that holds the end of a step, and the number of its evaluations."""
        return len(self.b)

    cost = end

    @property
    def extended_A(self) -> NDArray[np.float64]:  # noqa: N802
        """Coefficients of all rows, shape (s + 1 + e, s + 1 + e); row s holds b."""
        rows = self.stages + 1 + len(self.dense_c)
        table = np.zeros((rows, rows))
        table[: self.stages, : self.stages] = self.A
        table[self.stages, : self.stages] = self.b
        if len(self.dense_c):
            table[self.stages + 1 :] = self.dense_A
        return table

    @property
    def extended_c(self) -> NDArray[np.float64]:
        """Nodes of all rows, shape (s + 1 + e,)."""
        return np.concatenate([self.c, [1.0], self.dense_c])

    @cached_property
    def quarters(self) -> tuple[int, ...]:
        """Rows around the middle and both quarters of a step."""
        inner = self.c[1:-1]
        return tuple(sorted({1 + int(np.argmin(np.abs(inner - at))) for at in (0.25, 0.5, 0.75)}))

    def _check_stages(self) -> None:
        s, e = self.stages, len(self.dense_c)
        shapes = self.A.shape == (s, s) and self.c.shape == (s,)
        shapes = shapes and (not e or self.dense_A.shape == (e, s + 1 + e))
        shapes = shapes and (not self.error.size or self.error.shape[1] == s + 1)
        if not shapes or self.dense.shape[0] != s + 1 + e:
            raise ValueError(f"tableau {self.name}: shapes of the coefficients do not agree")
        if np.triu(self.extended_A).any():
            raise ValueError(f"tableau {self.name}: a stage needs itself or a later one")
        sums = self.extended_A.sum(axis=1) - self.extended_c
        self._require("row sums of A are not c", np.abs(sums).max())

    def _check_order(self) -> None:
        self._require(f"order is not {self.order}", order_defect(self.A, self.b, self.order))
        if self.error.size:
            self._require("error weights do not add up to 0", np.abs(self.error.sum(axis=1)).max())

    def _check_dense(self) -> None:
        # Coefficients of dense output may be large and cancel.
        scale = max(1.0, float(np.abs(self.dense).max()))
        ends = self.dense.sum(axis=1)
        ends[: self.stages] -= self.b
        self._require("dense output misses the end of the step", np.abs(ends).max() / scale)
        linear = self.dense.sum(axis=0)
        linear[0] -= 1.0
        defect = np.abs(linear).max() / scale
        self._require("dense output of a constant slope is not linear", defect)

    def _require(self, what: str, defect: float) -> None:
        if not defect < ROUND_OFF:
            raise ValueError(f"tableau {self.name}: {what}, off by {defect:.2e}")


def _hermite(b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cubic Hermite polynomial in terms of the slopes, shape (s + 1, 3).

    With ``y_1 - y_0 = h Σ b_j k_j`` it is
    ``(3θ² - 2θ³)(y_1 - y_0) + h (θ - 2θ² + θ³) k_0 + h (θ³ - θ²) k_s``.
    """
    weights = np.append(b, 0.0)[:, None] * np.array([0.0, 3.0, -2.0])
    weights[0] += [1.0, -2.0, 1.0]
    weights[-1] += [0.0, -1.0, 1.0]
    return weights


# Nodes come out right to a unit in the last place, and sums of coefficients keep about this much.
COLLOCATION_ROUND_OFF = 1e-14


@dataclass(frozen=True, kw_only=True, eq=False)
class Collocation:
    """The implicit Runge–Kutta method with s stages at Gauss's nodes, or at Radau's.

    Its order is 2s at Gauss's nodes, and 2s - 1 at Radau's, of which the last one is the end of the
    step. With ``q' = v, v' = a`` its stages need accelerations alone::

        V_i = v + h Σ_j A_ij a_j,    Q_i = q + h c_i v + h² Σ_j (A²)_ij a_j

    Rows are counted as a solver keeps them: the start of the step, its stages, its end.
    """

    stages: int  # number s of stages
    ends: bool = False  # whether nodes are Radau's

    cost = 0
    """Evaluations of a step that a solver counts: iterations count their own."""

    def __post_init__(self) -> None:
        order = 2 * self.stages - self.ends
        defect = order_defect(self.A, self.b, order)
        if not defect < COLLOCATION_ROUND_OFF:
            raise ValueError(f"collocation: order is not {order}, off by {defect:.2e}")
        # Symmetry, which the behaviour over long times rests on: Hairer & al., theorem II.8.10.
        mirrored = self.A[::-1, ::-1] + self.A - self.b
        if not self.ends and not np.abs(mirrored).max() < COLLOCATION_ROUND_OFF:
            raise ValueError("collocation: the method is not symmetric")

    @cached_property
    def _quadrature(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Gauss's nodes and weights, which integrate the cardinal polynomials exactly."""
        nodes, weights = leggauss(self.stages)
        return (1.0 + nodes) / 2, weights / 2

    @cached_property
    def c(self) -> NDArray[np.float64]:
        """Nodes, shape (s,)."""
        if not self.ends:
            return self._quadrature[0]
        s = self.stages
        series = [*np.zeros(s - 1), -1.0, 1.0]  # of P_s - P_(s-1)
        nodes = np.sort(np.real(legroots(series)))
        nodes -= legval(nodes, series) / legval(nodes, legder(series))
        nodes[-1] = 1.0
        return (1.0 + nodes) / 2

    @cached_property
    def b(self) -> NDArray[np.float64]:
        """Weights, shape (s,)."""
        nodes, weights = self._quadrature
        return weights @ cardinals(self.c, nodes)

    @cached_property
    def A(self) -> NDArray[np.float64]:  # noqa: N802
        """Integrals of the cardinal polynomials from 0 to each node, shape (s, s)."""
        # Quadrature loses fewer digits than their coefficients.
        nodes, weights = self._quadrature
        return np.array([node * (weights @ cardinals(self.c, node * nodes)) for node in self.c])

    @property
    def continued(self) -> NDArray[np.float64]:
        """Nodes of the polynomial that starting values continue, shape (m,)."""
        return self.c if self.ends else np.append(self.c, 1.0)

    @cached_property
    def ahead(self) -> NDArray[np.float64]:
        """Weights that continue accelerations to the next step of equal length, shape (s, m)."""
        return cardinals(self.continued, 1.0 + self.c)

    @cached_property
    def integrals(self) -> NDArray[np.float64]:
        """Integrals and double integrals of the cardinal polynomials, shape (2, s, s).

        Of powers of the fraction of a step: ``Σ_i integrals[0, j, i] θ**(i + 1)`` and
        ``θ Σ_i integrals[1, j, i] θ**(i + 1)``.
        """
        powers = np.arange(1.0, self.stages + 1)
        once = np.linalg.inv(np.vander(self.c, increasing=True)).T / powers
        return np.array([once, once / (powers + 1)])

    @cached_property
    def error(self) -> NDArray[np.float64]:
        """Weights e_i of Radau's error estimate, then γ, shape (s + 1,).

        With γ the real eigenvalue of the inverse of A, ``(f + Σ_i e_i (Y_i - y)/h)/γ`` is the
        difference to the method of order s whose further node, 0, has the weight 1/γ.
        """
        inverse = np.linalg.inv(self.A)
        values = np.linalg.eigvals(inverse)
        gamma = float(values[np.abs(values.imag).argmin()].real)
        exact = 1.0 / np.arange(1.0, self.stages + 1)
        exact[0] -= 1.0 / gamma
        embedded = np.linalg.solve(np.vander(self.c, increasing=True).T, exact)
        return np.append(gamma * ((embedded - self.b) @ inverse), gamma)

    @property
    def end(self) -> int:
        """The row that holds the end of a step."""
        return self.stages + 1

    @property
    def extended_A(self) -> NDArray[np.float64]:  # noqa: N802
        """Coefficients of all rows, of which the last one holds b, shape (s + 2, s + 2)."""
        table = np.zeros((self.stages + 2, self.stages + 2))
        table[1:-1, 1:-1] = self.A
        table[-1, 1:-1] = self.b
        return table

    @property
    def extended_c(self) -> NDArray[np.float64]:
        """Nodes of all rows, shape (s + 2,)."""
        return np.concatenate([[0.0], self.c, [1.0]])

    @property
    def dense(self) -> NDArray[np.float64]:
        """The polynomial of the stages, as that of a `Tableau`, shape (s + 2, s)."""
        return np.pad(self.integrals[0], ((1, 1), (0, 0)))


def cardinals(nodes: NDArray[np.float64], at: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values of the polynomials that are 1 at one node and 0 at the others, shape (m, s)."""
    columns = []
    for j, node in enumerate(nodes):
        others = np.delete(nodes, j)
        columns.append(np.prod((at[:, None] - others) / (node - others), axis=1))
    return np.stack(columns, axis=1)
