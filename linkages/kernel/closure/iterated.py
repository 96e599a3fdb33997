"""Blocks without a closed form: Newton's iteration on all their loops at once.

The unknowns start from values that an integration carries along, so that the assembly mode is
that of the motion itself. One more step follows the iteration in straight-line code: it takes the
last round-off away, and its derivatives are those of the solution.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from linkages.kernel.graph.scalars import Scalar, ScalarGraph
from linkages.kernel.graph.several import Iteration
from linkages.kernel.graph.vectors import Vector

Columns = Sequence[Sequence[Vector]]
"""For each unknown the derivatives of all loops."""


@dataclass(frozen=True)
class LinearSystem:
    """The equations of a block for derivatives of its unknowns: exact, or by least squares.

    Parameters
    ----------
    columns
        Derivatives of the loops with respect to the unknowns.
    """

    columns: Columns

    @property
    def graph(self) -> ScalarGraph:
        """Where the nodes belong."""
        return self.columns[0][0].x.graph

    @property
    def square(self) -> bool:
        """Whether there are as many equations as unknowns."""
        return 2 * len(self.columns[0]) == len(self.columns)

    @cached_property
    def rows(self) -> list[list[Scalar]]:
        """Coefficients, equation by equation."""
        loops = range(len(self.columns[0]))
        return [
            [getattr(column[loop], axis) for column in self.columns]
            for loop in loops
            for axis in ("x", "y")
        ]

    @cached_property
    def matrix(self) -> list[list[Scalar]]:
        """Of the system, or of the normal equations where there are redundant ones."""
        if self.square:
            return self.rows
        return [[self._product(a, b) for b in self.columns] for a in self.columns]

    def _product(self, a: Sequence[Vector], b: Sequence[Vector]) -> Scalar:
        return self.graph.total(u.dot(v) for u, v in zip(a, b, strict=True))

    def solve(self, gaps: Sequence[Vector]) -> list[Scalar]:
        """Unknowns that make the columns add up to given vectors, one per loop."""
        if self.square:
            right = [value for gap in gaps for value in (gap.x, gap.y)]
        else:
            right = [self._product(column, gaps) for column in self.columns]
        if len(right) == 1:
            return [right[0] / self.matrix[0][0]]
        return self.graph.solve(self.matrix, right)

    @cached_property
    def determinant(self) -> Scalar:
        """Zero at a singular position; with redundant equations the root of the normal equations'.

        So it has the same size in both cases: the volume that the columns span.
        """
        found = self.matrix[0][0] if len(self.matrix) == 1 else self.graph.determinant(self.matrix)
        if self.square:
            return found
        # round-off may take a sum of squares below zero
        return self.graph.sqrt(self.graph.select(found, found, self.graph.zero))

    @cached_property
    def largest_determinant(self) -> Scalar:
        """Its bound by Hadamard: the product of the lengths of the columns."""
        result = self.graph.one
        for column in self.columns:
            result = result * self.graph.sqrt(self._product(column, column))
        return result

    def determinant_rate(self, rates: Columns) -> Scalar:
        """Derivative of the determinant, given those of the columns: one column at a time."""
        other = LinearSystem(rates)
        if self.square:
            changes = [list(row) for row in other.rows]
        else:
            pairs = list(zip(self.columns, rates, strict=True))
            changes = [
                [self._product(da, b) + self._product(a, db) for b, db in pairs] for a, da in pairs
            ]
        if len(changes) == 1:
            return self._root_rate(changes[0][0])
        terms = []
        for k in range(len(changes)):
            replaced = [
                [changes[i][j] if j == k else entry for j, entry in enumerate(row)]
                for i, row in enumerate(self.matrix)
            ]
            terms.append(self.graph.determinant(replaced))
        return self._root_rate(self.graph.total(terms))

    def _root_rate(self, rate: Scalar) -> Scalar:
        """Derivative of the determinant from that of the matrix."""
        return rate if self.square else 0.5 * rate / self.determinant


@dataclass(frozen=True)
class Iterated:
    """A solved block.

    Parameters
    ----------
    unknowns
        Angles and displacements.
    system
        The linear system for their derivatives.
    iteration
        How they are found.
    radicand
        Negative where redundant equations contradict each other; None if there are none.
    """

    unknowns: tuple[Scalar, ...]
    system: LinearSystem
    iteration: Iteration
    radicand: Scalar | None

    @property
    def margin(self) -> Scalar:
        """Zero at a singular position."""
        return self.system.determinant

    @property
    def margin_scale(self) -> Scalar:
        """The bound of the margin."""
        return self.system.largest_determinant
