"""Rates and accelerations of all bodies and points.

The partial velocities of one coordinate are those where all other rates are zero: zeros are folded
away, so a partial velocity costs what it moves.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from functools import reduce
from operator import sub

from linkages.kernel.dyads import Dyad, Iterated
from linkages.kernel.positions import Positions
from linkages.kernel.scalars import Scalar, Vector, section
from linkages.topology.assur_groups import Block, Loop, Step
from linkages.topology.decomposition import leaders_first


class _Field(ABC):
    """Body rates and vectors of points, propagated block by block."""

    def __init__(self, positions: Positions, known: Mapping[str, Scalar], label: str) -> None:
        self.positions = positions
        self.topology = positions.topology
        self.graph = positions.graph
        self.bodies: dict[str, Scalar] = {}
        self._followed: dict[str, Scalar] = {}
        zero = Vector(self.graph.zero, self.graph.zero)
        self.joints = dict.fromkeys(self.topology.mechanism.anchors, zero)
        self.label = label
        for name in (*self.topology.driven, *self.topology.free):
            self.bodies[name] = known.get(name, self.graph.zero)
        for block in self.topology.blocks:
            title = "bodies with known coordinates"
            if block.unknowns:
                title = f"block {block.index}: {block.title}"
            with section(f"{title}, {label}"):
                self._add(block)

    @abstractmethod
    def _along(self, step: Step, block: Block | None = None) -> Vector:
        """Derivative of the vector along a body, in a block without what its solution adds."""

    @abstractmethod
    def _solved(self, block: Block, gaps: Sequence[Vector]) -> Sequence[Scalar]:
        """Derivatives of the unknowns of a block, from those of what they bridge."""

    def turning(self, name: str) -> Scalar:
        """Derivative of the orientation of a body."""
        body, _ = self.topology.turning(name)
        return self.graph.zero if body is None else self.moving(body)

    def moving(self, name: str) -> Scalar:
        """Derivative of a body's own coordinate: its angle, or its displacement."""
        if name not in self.topology.followers:
            return self.bodies[name]
        for follower in leaders_first([name], self.topology.leaders, self._followed):
            self._followed[follower] = self._following(follower)
        return self._followed[name]

    def _following(self, name: str) -> Scalar:
        """Derivative of the coordinate of a follower."""
        parts = self.positions.frames.follows(name)
        return self.graph.total(factor * self.moving(other) for other, factor in parts)

    def summed(self, name: str) -> Scalar:
        """Derivative of what the coordinate of a follower is a function of."""
        parts = self.positions.frames.summed(name)
        return self.graph.total(factor * self.moving(other) for other, factor in parts)

    def _add(self, block: Block) -> None:
        if block.unknowns:
            self.bodies |= dict.fromkeys(block.unknowns, self.graph.zero)
            self._followed.clear()
            values = self._solved(block, [self._gap(block, i) for i in range(len(block.loops))])
            self._followed.clear()
            for name, value in zip(block.unknowns, values, strict=True):
                if value.label is None and value.operands:
                    value.label = f"body{self.positions.body_numbers[name]}_{self.label}"
                self.bodies[name] = value
        for name, entry, labels in block.placements:
            for label in labels:
                place = self.joints[entry] + self._along(Step(name, entry, label))
                self.joints[label] = place
                if label in self.positions.numbers:
                    place.label(f"joint{self.positions.numbers[label]}_{self.label}")

    def _gap(self, block: Block, index: int) -> Vector:
        """Derivative of what the unknowns must bridge, as far as it is known."""
        loop = block.loops[index]
        gap = self._bridged(loop)
        for step in loop.steps:
            gap = gap - self._along(step, block)
        return -gap if block.kind in ("RRP", "PP") else gap

    def _bridged(self, loop: Loop) -> Vector:
        """Of what the links of a loop bridge: a loop may end where it starts, in its own block."""
        if loop.start == loop.end:
            return Vector(self.graph.zero, self.graph.zero)
        return self.joints[loop.end] - self.joints[loop.start]

    def _slides(self, step: Step) -> tuple[int, Vector]:
        """Direction of a way along a slider's displacement (0 if it is none), and of its axis."""
        sliding = self.positions.frames.sliding(step.body, step.start, step.end)
        zero = Vector(self.graph.zero, self.graph.zero)
        return sliding, self.positions.unit(step.body) * float(sliding) if sliding else zero


class Rates(_Field):
    """First derivatives; rates that are not `known` are zero.

    Two virtual motions give forces: that of a link whose length grows at unit rate (`stretch`), and
    that of a body that moves away at a velocity from whatever else has a point (`apart`).
    """

    def __init__(
        self,
        positions: Positions,
        known: Mapping[str, Scalar],
        label: str,
        stretch: str | None = None,
        apart: tuple[str, str, Vector] | None = None,
    ) -> None:
        self._stretch = stretch
        self.apart = apart
        super().__init__(positions, known, label)

    def _following(self, name: str) -> Scalar:
        """Derivative of a follower's coordinate: a cam that moves away moves it."""
        rate = super()._following(name)
        if self.apart is None or self.topology.followers[name].profile is None:
            return rate
        from linkages.kernel.cams import following_cam

        cam = following_cam(self.positions, name)
        parted = self.graph.zero if cam.pivot is None else cam.pressing.dot(cam.parted(self.apart))
        return rate - parted

    def parts(self, block: Block) -> list[Vector]:
        """Velocities of the known ends of the loops of a block, and along their links."""
        ends = [self.joints[end] for loop in block.loops for end in (loop.start, loop.end)]
        return ends + [self._along(step) for loop in block.loops for step in loop.steps]

    def mismatch(self, block: Block) -> list[Vector]:
        """For each loop of a block, how fast it opens."""
        return [
            reduce(sub, map(self._along, loop.steps), self._bridged(loop)) for loop in block.loops
        ]

    def _along(self, step: Step, block: Block | None = None) -> Vector:  # noqa: ARG002
        name = step.body
        link = self.positions.along(name, step.start, step.end)
        rate = link.turned * self.turning(name)
        sliding, axis = self._slides(step)
        if sliding:
            rate = rate + axis * self.moving(name)
        if name == self._stretch:
            points = tuple(self.topology.mechanism.bodies[name].points)
            unit = self.positions.unit(name)
            rate = rate + (unit if points == (step.start, step.end) else -unit)
        if self.apart is not None and name == self.apart[0]:
            _, point, velocity = self.apart
            rate = rate + velocity if point == step.start else rate
            rate = rate - velocity if point == step.end else rate
        return rate

    def _solved(self, block: Block, gaps: Sequence[Vector]) -> Sequence[Scalar]:
        solved = self.positions.dyads[block.index]
        if isinstance(solved, Dyad):
            return solved.rates(gaps[0])
        return solved.system.solve(gaps)

    def margin_rate(self, block: Block) -> Scalar:
        """Derivative of a block's margin with respect to time."""
        solved = self.positions.dyads[block.index]
        if isinstance(solved, Iterated):
            loops = range(len(block.loops))
            columns = [[self._column_rate(block, i, u) for i in loops] for u in block.unknowns]
            return solved.system.determinant_rate(columns)
        first, second = block.unknowns
        return solved.margin_rate((self.bodies[first], self.bodies[second]))

    def _column_rate(self, block: Block, index: int, name: str) -> Vector:
        total = Vector(self.graph.zero, self.graph.zero)
        for step in block.loops[index].steps:
            orientation = self.topology.orientations[step.body]
            sliding, axis = self._slides(step)
            if sliding and name in orientation.moved:
                ratio = self.positions.frames.moves(step.body)[name]
                total = total + axis.turned * self.turning(step.body) * ratio
                total = total + axis * self._ratio_rate(step.body, name)
            if name in orientation.masters:
                ratio = self.positions.frames.ratios(step.body)[name]
                total = total + self._along(step).turned * ratio
        return total

    def _ratio_rate(self, slider: str, name: str) -> Scalar:
        """How the ratio changes in which a slider moves with a coordinate: along cams alone."""
        relation = self.topology.followers.get(slider)
        if relation is None or relation.profile is None:
            return self.graph.zero
        frames = self.positions.frames
        ratio = self.graph.total(
            factor * frames.moves(other).get(name, self.graph.zero)
            for other, factor in frames.summed(slider)
        )
        return self.positions.curvature(slider) * self.summed(slider) * ratio


class Accelerations(_Field):
    """Second derivatives; those that are not `known` are zero."""

    def __init__(
        self, positions: Positions, rates: Rates, known: Mapping[str, Scalar], label: str
    ) -> None:
        self.rates = rates
        super().__init__(positions, known, label)

    def _following(self, name: str) -> Scalar:
        """Derivative of a follower's coordinate; a cam adds a part of its own."""
        value = super()._following(name)
        if self.topology.followers[name].profile is None:
            return value
        rate = self.rates.summed(name)
        return value + self.positions.curvature(name) * (rate * rate)

    def _along(self, step: Step, block: Block | None = None) -> Vector:
        name = step.body
        link = self.positions.along(name, step.start, step.end)
        rate = self.rates.turning(name)
        result = link.turned * self.turning(name)
        masters = self.topology.orientations[name].masters
        dyad = block is not None and block.kind in ("RRR", "RRP")
        if block is None or not dyad or not any(m in block.unknowns for m in masters):
            result = result - link * (rate * rate)  # else the dyad adds it by itself
        sliding, axis = self._slides(step)
        if sliding:
            result = result + axis * self.moving(name)
            result = result + axis.turned * (2.0 * self.rates.moving(name) * rate)
        return result

    def _solved(self, block: Block, gaps: Sequence[Vector]) -> Sequence[Scalar]:
        solved = self.positions.dyads[block.index]
        if isinstance(solved, Dyad):
            first, second = (self.rates.bodies[name] for name in block.unknowns)
            return solved.accelerations(gaps[0], (first, second))
        return solved.system.solve(gaps)
