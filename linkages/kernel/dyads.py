"""Closed-form solutions of dyads: position, rates and accelerations of two unknowns.

Every dyad is a chain from a known place over two unknown links to another one, and `gap` is what
these must bridge. Nothing iterates, so there is no constraint drift.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

from linkages.kernel.scalars import Scalar, Vector

LEAST_MARGIN = 1e-5
"""Relative margin below which a position counts as singular in double precision.

The closed forms take ``sqrt(L² - n²)``, which at the relative margin m carries a relative error
ε/m²; accelerations divide by m once more and lose all but their first digits at this bound.
"""


class Dyad(ABC):
    """Two unknown coordinates, solved."""

    radicand: Scalar | None
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
    radicand: Scalar
    product: Scalar
    margin: Scalar
    inverse_margin: Scalar
    margin_scale: Scalar

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
    radicand: Scalar
    margin: Scalar
    margin_scale: Scalar

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
    radicand: Scalar
    margin: Scalar
    margin_scale: Scalar

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
    margin: Scalar
    margin_scale: Scalar
    radicand: None = None

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
