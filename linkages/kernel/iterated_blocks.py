"""Blocks without a closed form: Newton's iteration on all their loops at once.

The unknowns start from values that an integration carries along, so that the assembly branch is
that of the motion. One more step in straight-line code takes the last round-off away; its
derivatives are those of the solution.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from linkages.kernel.differentiation import Iteration
from linkages.kernel.scalars import Scalar, ScalarGraph, Vector, components
from linkages.topology.assur_groups import Block, Loop, Step

if TYPE_CHECKING:
    from linkages.components.mechanisms.mechanism import Mechanism
    from linkages.kernel.positions import Positions

Columns = Sequence[Sequence[Vector]]
"""For each unknown the derivatives of all loops."""


@dataclass(frozen=True)
class LinearSystem:
    """The equations of a block for derivatives of its unknowns: exact, or by least squares."""

    columns: Columns  # derivatives of the loops with respect to the unknowns

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
            right = components(gaps)
        else:
            right = [self._product(column, gaps) for column in self.columns]
        if len(right) == 1:
            return [right[0] / self.matrix[0][0]]
        return self.graph.solve(self.matrix, right)

    @cached_property
    def determinant(self) -> Scalar:
        """Volume that the columns span: zero at a singular position."""
        result = self.matrix[0][0] if len(self.matrix) == 1 else self.graph.determinant(self.matrix)
        if self.square:
            return result
        # round-off may take a sum of squares below zero
        return self.graph.sqrt(self.graph.select(result, result, self.graph.zero))

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
        return rate if self.square else 0.5 * rate / self.determinant


@dataclass(frozen=True)
class Iterated:
    """A solved block."""

    unknowns: tuple[Scalar, ...]  # angles and displacements
    system: LinearSystem  # the linear system for their derivatives
    iteration: Iteration  # how they are found
    # Negative where redundant equations contradict each other; None if there are none
    radicand: Scalar | None

    @property
    def margin(self) -> Scalar:
        """Zero at a singular position."""
        return self.system.determinant

    @property
    def margin_scale(self) -> Scalar:
        """The bound of the margin."""
        return self.system.largest_determinant


CONTRADICTION = 1e-8
"""Relative gap from which on redundant equations contradict each other."""


def iterate_block(positions: Positions, block: Block) -> Iterated:
    """Solve a block by iteration and enter the positions of its bodies."""
    graph, unknowns = positions.graph, block.unknowns
    iterates = [positions.inputs.iterate(positions.body_numbers[name]) for name in unknowns]
    updates, _ = _newton_step(positions, block, iterates)
    scale = block_size(positions.topology.mechanism, block)
    iteration = Iteration(
        iterates=tuple(iterates),
        updates=tuple(updates),
        scales=tuple(1.0 if positions.body(name).rotates else scale for name in unknowns),
        block=block.index,
    )
    result = graph.newton(iteration, [positions.integrated(name) for name in unknowns])
    updates, missed = _newton_step(positions, block, result)
    for name, value, update in zip(unknowns, result, updates, strict=True):
        positions.correct(name, value, update)
    radicand = None
    if block.surplus:
        relative = [residual * (1.0 / scale) for residual in missed]
        allowed = CONTRADICTION**2 * len(missed)
        radicand = allowed - graph.total(residual.square for residual in relative)
    values = tuple(positions.coordinate(name) for name in unknowns)
    return Iterated(values, LinearSystem(columns(positions, block)), iteration, radicand)


def _newton_step(
    positions: Positions, block: Block, values: list[Scalar]
) -> tuple[list[Scalar], list[Vector]]:
    """One step from given values, and by how much they miss."""
    for name, value in zip(block.unknowns, values, strict=True):
        positions.assign(name, value)
    missed = residuals(positions, block)
    system = LinearSystem(columns(positions, block))
    return system.solve([-residual for residual in missed]), missed


def residuals(positions: Positions, block: Block) -> list[Vector]:
    """By how much the links of each loop of a block miss its end."""
    result = []
    for loop in block.loops:
        total = -positions.gap(loop)
        for step in loop.steps:
            total = total + positions.along(*_way(step))
        result.append(total)
    return result


def columns(positions: Positions, block: Block) -> list[list[Vector]]:
    """Derivatives of the loops of a block with respect to its unknowns."""
    return [[_column(positions, loop, name) for loop in block.loops] for name in block.unknowns]


def _column(positions: Positions, loop: Loop, name: str) -> Vector:
    total = Vector(positions.graph.zero, positions.graph.zero)
    for step in loop.steps:
        orientation = positions.topology.orientations[step.body]
        sliding = positions.frames.sliding(*_way(step))
        if sliding and name in orientation.moved:
            ratio = positions.frames.moves(step.body)[name]
            total = total + positions.unit(step.body) * float(sliding) * ratio
        if name in orientation.masters:
            ratio = positions.frames.ratios(step.body)[name]
            total = total + positions.along(*_way(step)).turned * ratio
    return total


def block_size(mechanism: Mechanism, block: Block) -> float:
    """A power of ten of the size of the longest link of a block, which stands in generated code."""
    longest = 0.0
    for step in (step for loop in block.loops for step in loop.steps):
        places = mechanism.attachments[step.body]
        ends = [places[label] for label in (step.start, step.end) if label in places]
        longest = max([longest, *(abs(value.value) for end in ends for value in end)])
    return 10.0 ** math.floor(math.log10(longest)) if longest > 0 else 1.0


def _way(step: Step) -> tuple[str, str, str]:
    return step.body, step.start, step.end
