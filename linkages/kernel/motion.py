"""Rates and accelerations of all bodies and joints, for given rates of the known coordinates.

The same class serves the actual velocities and the partial velocities of one coordinate (all
other rates zero): zeros are folded away, so a partial velocity costs what it moves.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping

from linkages.kernel.positions import Positions
from linkages.kernel.scalars import Scalar
from linkages.kernel.vectors import Vector
from linkages.topology.blocks import Block


class _Field(ABC):
    """Body rates and joint vectors, propagated block by block."""

    def __init__(self, positions: Positions, known: Mapping[str, Scalar], label: str) -> None:
        self.positions = positions
        self.graph = positions.graph
        self.bodies: dict[str, Scalar] = {}
        zero = Vector(self.graph.zero, self.graph.zero)
        self.joints = dict.fromkeys(positions.topology.mechanism.ground, zero)
        self._zero = zero
        self.label = label
        for name in (*positions.topology.driven, *positions.topology.free):
            self.bodies[name] = known.get(name, self.graph.zero)
        for block in positions.topology.blocks:
            self.graph.section = f"block {block.index}: {block.kind} dyad, {label}"
            if not block.unknowns:
                self.graph.section = f"bodies with known coordinates, {label}"
            self._add(block)

    @abstractmethod
    def _along(self, name: str, start: str, end: str) -> Vector:
        """Derivative of the vector from one point of a body to another."""

    @abstractmethod
    def _solved(self, block: Block, gap: Vector) -> tuple[Scalar, Scalar]:
        """Derivatives of the two unknowns of a block, from that of what they bridge."""

    def _add(self, block: Block) -> None:
        if block.unknowns:
            first, second = self._solved(block, self._gap(block))
            steps = [s for s in block.loops[0].steps if s.body in block.unknowns]
            for step, value in zip(steps, (first, second), strict=True):
                if value.label is None and value.operands:
                    value.label = f"body{self.positions.body_numbers[step.body]}_{self.label}"
                self.bodies[step.body] = value
        for name, entry in block.placements:
            for joint in self.positions.topology.mechanism.bodies[name].points:
                if self.positions.topology.placing.get(joint) == name:
                    number = self.positions.numbers[joint]
                    place = self._place(name, entry, joint)
                    self.joints[joint] = place.label(f"joint{number}_{self.label}")

    def _place(self, name: str, entry: str | None, joint: str) -> Vector:
        guide = self.positions.topology.mechanism.bodies[name].guide
        if guide is not None:
            return self.positions.axis(guide) * self.bodies[name]
        assert entry is not None
        return self.joints[entry] + self._along(name, entry, joint)

    def _gap(self, block: Block) -> Vector:
        """Derivative of what the two unknown links must bridge."""
        loop = block.loops[0]
        start = self._zero if loop.start is None else self.joints[loop.start]
        end = self._zero if loop.end is None else self.joints[loop.end]
        gap = end - start
        for step in loop.steps:
            if step.body not in block.unknowns:
                assert step.start is not None
                assert step.end is not None
                gap = gap - self._along(step.body, step.start, step.end)
        return gap if block.kind == "RRR" else -gap


class Rates(_Field):
    """First derivatives.

    Parameters
    ----------
    positions
        Solved positions.
    known
        Rates of driven and free coordinates; those not named are zero.
    label
        Used in the names of the printed kernel.
    stretch
        A link whose length grows at unit rate: a virtual motion that gives the force along it.
    """

    def __init__(
        self,
        positions: Positions,
        known: Mapping[str, Scalar],
        label: str,
        stretch: str | None = None,
    ) -> None:
        self._stretch = stretch
        super().__init__(positions, known, label)

    def _along(self, name: str, start: str, end: str) -> Vector:
        link = self.positions.along(name, start, end)
        rate = link.turned * self.bodies[name]
        if name == self._stretch:
            forward = tuple(self.positions.topology.mechanism.bodies[name].points) == (start, end)
            unit = self.positions.unit(name)
            rate = rate + (unit if forward else -unit)
        return rate

    def _solved(self, block: Block, gap: Vector) -> tuple[Scalar, Scalar]:
        return self.positions.dyads[block.index].rates(gap)


class Accelerations(_Field):
    """Second derivatives.

    Parameters
    ----------
    positions
        Solved positions.
    rates
        The actual rates.
    known
        Second derivatives of driven and free coordinates; those not named are zero.
    label
        Used in the names of the printed kernel.
    """

    def __init__(
        self, positions: Positions, rates: Rates, known: Mapping[str, Scalar], label: str
    ) -> None:
        self.rates = rates
        super().__init__(positions, known, label)

    def _along(self, name: str, start: str, end: str) -> Vector:
        link = self.positions.along(name, start, end)
        rate = self.rates.bodies[name]
        return link.turned * self.bodies[name] - link * (rate * rate)

    def _solved(self, block: Block, gap: Vector) -> tuple[Scalar, Scalar]:
        steps = [s.body for s in block.loops[0].steps if s.body in block.unknowns]
        rates = (self.rates.bodies[steps[0]], self.rates.bodies[steps[1]])
        return self.positions.dyads[block.index].accelerations(gap, rates)
