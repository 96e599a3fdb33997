"""Solutions of blocks: dyads in closed form, all others by an iteration.

Position, rates and accelerations of the two unknowns of a dyad need no iteration: it is a chain
from a known place over two unknown links to another one, and `gap` is what these must bridge.

Blocks without a closed form are solved by Newton's method on all their loops at once. The unknowns
start from values that an integration carries along, so that the assembly branch is that of the
motion. One more step in straight-line code takes the last round-off away; its derivatives are those
of the solution.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
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

LEAST_MARGIN = 1e-5
"""Relative margin below which a position counts as singular in double precision.

The closed forms take ``sqrt(L² - n²)``, which at the relative margin m carries a relative error
ε/m²; accelerations divide by m once more and lose all but their first digits at this bound.
"""


@dataclass(frozen=True, kw_only=True)
class Dyad(ABC):
    """Two unknown coordinates, solved."""

    radicand: Scalar | None = None
    """Negative where the dyad cannot be assembled; None if it always can."""
    margin: Scalar
    """Zero at a singular position."""
    margin_scale: Scalar
    """Size of `margin` far from singular positions; it is taken at t = 0."""

    @abstractmethod
    def rates(self, gap_rate: Vector) -> tuple[Scalar, Scalar]:
        """Rates of the two unknowns."""

    @abstractmethod
    def accelerations(
        self, gap_acceleration: Vector, rates: tuple[Scalar, Scalar]
    ) -> tuple[Scalar, Scalar]:
        """Second derivatives of the two unknowns."""

    @abstractmethod
    def margin_rate(self, rates: tuple[Scalar, Scalar]) -> Scalar:
        """Derivative of `margin` with respect to time."""


@dataclass(frozen=True)
class TwoLinks(Dyad):
    """Two turning links (RRR): gap = first + second.

    The first link is u·gap + h·(gap turned by 90°), where h > 0 puts the apex on the left of the
    line between the known ends.
    """

    gap_square: Scalar
    first: Vector
    second: Vector
    first_square: Scalar
    second_square: Scalar
    product: Scalar
    inverse_margin: Scalar

    @staticmethod
    def solve(gap: Vector, first_square: Scalar, second_square: Scalar, side: Scalar) -> TwoLinks:
        """Intersect two circles; `gap` leads from the known end of the first link to the other."""
        graph = side.graph
        inverse_square = 1.0 / gap.square
        u = 0.5 + 0.5 * (first_square - second_square) * inverse_square
        radicand = first_square * inverse_square - u * u
        h = side * graph.sqrt(radicand)
        first = gap * u + gap.turned * h
        inverse_margin = -(inverse_square / h)
        return TwoLinks(
            gap_square=gap.square,
            first=first,
            second=gap - first,
            first_square=first_square,
            second_square=second_square,
            radicand=radicand,
            product=u * gap.square - first_square,
            margin=-(h * gap.square),
            inverse_margin=inverse_margin,
            margin_scale=graph.sqrt(first_square * second_square),
        )

    def _solve(self, along_first: Scalar, along_second: Scalar) -> tuple[Scalar, Scalar]:
        return along_second * self.inverse_margin, -(along_first * self.inverse_margin)

    def rates(self, gap_rate: Vector) -> tuple[Scalar, Scalar]:
        return self._solve(gap_rate.dot(self.first), gap_rate.dot(self.second))

    def accelerations(
        self, gap_acceleration: Vector, rates: tuple[Scalar, Scalar]
    ) -> tuple[Scalar, Scalar]:
        first, second = rates[0] * rates[0], rates[1] * rates[1]
        along_first = first * self.first_square + second * self.product
        along_second = first * self.product + second * self.second_square
        return self._solve(
            gap_acceleration.dot(self.first) + along_first,
            gap_acceleration.dot(self.second) + along_second,
        )

    def margin_rate(self, rates: tuple[Scalar, Scalar]) -> Scalar:
        """The margin is first × second."""
        return (rates[1] - rates[0]) * self.product


@dataclass(frozen=True)
class LinkAndSlider(Dyad):
    """A turning link and a slider on an axis that is known (RRP): gap + link = position·axis."""

    axis: Vector
    link: Vector
    position: Scalar
    forward: Scalar
    across: Scalar
    inverse_forward: Scalar

    @staticmethod
    def solve(gap: Vector, link_square: Scalar, axis: Vector, side: Scalar) -> LinkAndSlider:
        """Intersect a circle and a line; `gap` leads from the axis point to the end of the link."""
        graph = side.graph
        across = -gap.dot(axis.turned)
        radicand = link_square - across * across
        forward = side * graph.sqrt(radicand)
        return LinkAndSlider(
            axis=axis,
            link=axis * forward + axis.turned * across,
            position=gap.dot(axis) + forward,
            forward=forward,
            across=across,
            inverse_forward=1.0 / forward,
            radicand=radicand,
            margin=forward,
            margin_scale=graph.sqrt(link_square),
        )

    def rates(self, gap_rate: Vector) -> tuple[Scalar, Scalar]:
        turning = -gap_rate.dot(self.axis.turned) * self.inverse_forward
        return turning, gap_rate.dot(self.axis) - turning * self.across

    def accelerations(
        self, gap_acceleration: Vector, rates: tuple[Scalar, Scalar]
    ) -> tuple[Scalar, Scalar]:
        square = rates[0] * rates[0]
        sideways = square * self.across - gap_acceleration.dot(self.axis.turned)
        turning = sideways * self.inverse_forward
        along = gap_acceleration.dot(self.axis) - turning * self.across
        return turning, along - square * self.forward

    def margin_rate(self, rates: tuple[Scalar, Scalar]) -> Scalar:
        """The margin is the link's component along the axis."""
        return -(rates[0] * self.across)


@dataclass(frozen=True)
class LinkInGuide(Dyad):
    """A turning guide and a slider along it (RPR): gap = base + position·axis, all turned."""

    gap: Vector
    unit: Vector
    axis: Vector
    position: Scalar
    forward: Scalar
    across: Scalar
    inverse_forward: Scalar

    @staticmethod
    def solve(gap: Vector, base: Vector, axis: Vector, sign: float, side: Scalar) -> LinkInGuide:
        """Turn a guide until its axis goes through a place; `gap` begins on the guide's side."""
        graph = side.graph
        along = axis * sign
        across = base.dot(along.turned)
        radicand = gap.square - across * across
        forward = side * graph.sqrt(radicand)
        turned = along * forward + along.turned * across  # the gap in the frame of the guide
        unit = gap.times(Vector(turned.x, -turned.y)) * (1.0 / gap.square)
        return LinkInGuide(
            gap=gap,
            unit=unit,
            axis=unit.times(along),
            position=forward - base.dot(along),
            forward=forward,
            across=across,
            inverse_forward=1.0 / forward,
            radicand=radicand,
            margin=forward,
            margin_scale=graph.sqrt(gap.square),
        )

    def rates(self, gap_rate: Vector) -> tuple[Scalar, Scalar]:
        turning = -(gap_rate.cross(self.axis) * self.inverse_forward)
        return turning, self.gap.dot(gap_rate) * self.inverse_forward

    def accelerations(
        self,
        gap_acceleration: Vector,
        rates: tuple[Scalar, Scalar],  # noqa: ARG002
    ) -> tuple[Scalar, Scalar]:
        return self.rates(gap_acceleration)

    def margin_rate(self, rates: tuple[Scalar, Scalar]) -> Scalar:
        """The margin grows as the slider moves."""
        return rates[1]


@dataclass(frozen=True)
class TwoSliders(Dyad):
    """Two sliders on axes of known directions (PP): gap = second·axis₂ − first·axis₁."""

    first_axis: Vector
    second_axis: Vector
    first: Scalar
    second: Scalar
    inverse_margin: Scalar

    @staticmethod
    def solve(gap: Vector, first_axis: Vector, second_axis: Vector) -> TwoSliders:
        """Solve two linear equations: both displacements bridge the gap."""
        graph = gap.x.graph
        margin = first_axis.cross(second_axis)
        inverse = 1.0 / margin
        return TwoSliders(
            first_axis=first_axis,
            second_axis=second_axis,
            first=second_axis.cross(gap) * inverse,
            second=first_axis.cross(gap) * inverse,
            inverse_margin=inverse,
            margin=margin,
            margin_scale=graph.one,
        )

    def rates(self, gap_rate: Vector) -> tuple[Scalar, Scalar]:
        return (
            self.second_axis.cross(gap_rate) * self.inverse_margin,
            self.first_axis.cross(gap_rate) * self.inverse_margin,
        )

    def accelerations(
        self,
        gap_acceleration: Vector,
        rates: tuple[Scalar, Scalar],  # noqa: ARG002
    ) -> tuple[Scalar, Scalar]:
        return self.rates(gap_acceleration)

    def margin_rate(self, rates: tuple[Scalar, Scalar]) -> Scalar:
        return rates[0].graph.zero


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
