"""Where everything is: positions of joints and vectors along bodies, block by block."""

from __future__ import annotations

import math

from linkages.components.terms import Body, Guide
from linkages.kernel.dyads import Dyad, LinkAndSlider, TwoLinks, TwoSliders
from linkages.kernel.inputs import Inputs
from linkages.kernel.scalars import Scalar
from linkages.kernel.vectors import Vector
from linkages.topology.blocks import Block, Loop
from linkages.topology.topology import Topology


class Positions:
    """Positions of a mechanism as functions of parameters, time and free coordinates.

    Parameters
    ----------
    topology
        Its blocks are solved in their order.
    inputs
        Arguments of the kernel.
    """

    def __init__(self, topology: Topology, inputs: Inputs) -> None:
        self.topology = topology
        self.inputs = inputs
        self.graph = inputs.graph
        self.dyads: dict[int, Dyad] = {}
        # in the order of the bodies: the order of the ground joints in the file is no structure
        ground = topology.mechanism.ground
        used = [
            j for body in topology.mechanism.bodies.values() for j in body.points if j in ground
        ]
        self.joints = {
            joint: inputs.vector(ground[joint]) for joint in dict.fromkeys([*used, *ground])
        }
        self.displacements: dict[str, Scalar] = {}
        self._units: dict[str, Vector] = {}
        self._known_links: dict[str, tuple[tuple[str, str], Vector]] = {}
        self.numbers = {joint: index for index, joint in enumerate(topology.joints)}
        self.body_numbers = {name: i for i, name in enumerate(topology.mechanism.bodies)}
        self._drives()
        for block in topology.blocks:
            self._place(block)

    def _body(self, name: str) -> Body:
        return self.topology.mechanism.bodies[name]

    def prescribed(self, name: str) -> tuple[Scalar, Scalar]:
        """Driven coordinate and its rate."""
        drive = self.topology.mechanism.prescribed[name]
        speed = self.inputs.parameter(drive.speed)
        return self.inputs.parameter(drive.start) + speed * self.inputs.time, speed

    def _drives(self) -> None:
        """What is known before any block is solved."""
        for name in (*self.topology.driven, *self.topology.free):
            number = self.body_numbers[name]
            self.graph.section = f"body {number}: known coordinate"
            if name in self.topology.driven:
                coordinate = self.prescribed(name)[0]
            else:
                coordinate = self.inputs.coordinate(self.topology.free.index(name))
            if self._body(name).rotates:
                unit = Vector(self.graph.cos(coordinate), self.graph.sin(coordinate))
                self._units[name] = unit.label(f"body{number}_e")
            else:
                self.displacements[name] = coordinate

    def _place(self, block: Block) -> None:
        if block.unknowns:
            self.graph.section = f"block {block.index}: {block.kind} dyad"
            self._solve(block)
        for name, entry in block.placements:
            body = self._body(name)
            for joint in body.points:
                if self.topology.placing.get(joint) != name:
                    continue
                if body.guide is not None:
                    place = (
                        self.origin(body.guide) + self.axis(body.guide) * self.displacements[name]
                    )
                else:
                    assert entry is not None
                    place = self.joints[entry] + self.along(name, entry, joint)
                self.joints[joint] = place.label(f"joint{self.numbers[joint]}_")

    def origin(self, guide: Guide) -> Vector:
        """The point that a slider's position is counted from."""
        assert not isinstance(guide.origin, str)
        return self.inputs.vector(guide.origin)

    def axis(self, guide: Guide) -> Vector:
        """Unit vector of an axis; exact multiples of 90° are structure."""
        quarters = guide.angle.value / (math.pi / 2)
        if quarters == round(quarters):
            x, y = ((1, 0), (0, 1), (-1, 0), (0, -1))[round(quarters) % 4]
            return Vector(self.graph.number(x), self.graph.number(y))
        angle = self.inputs.parameter(guide.angle)
        return Vector(self.graph.cos(angle), self.graph.sin(angle))

    def in_frame(self, name: str, start: str, end: str) -> Vector:
        """From one point of a body to another, in the body's own frame."""
        points = self._body(name).points
        return self.inputs.vector(points[end]) - self.inputs.vector(points[start])

    def along(self, name: str, start: str, end: str) -> Vector:
        """From one point of a turning body to another."""
        if name in self._units:
            return self._units[name].times(self.in_frame(name, start, end))
        reference, link = self._known_links[name]
        if reference == (start, end):
            return link
        if reference == (end, start):
            return -link
        base = self.in_frame(name, *reference)
        conjugate = Vector(base.x, -base.y)
        ratio = self.in_frame(name, start, end).times(conjugate) * (1.0 / base.square)
        return link.times(ratio)

    def unit(self, name: str) -> Vector:
        """Cosine and sine of the angle of a turning body."""
        if name in self._units:
            return self._units[name]
        reference, link = self._known_links[name]
        base = self.in_frame(name, *reference)
        return link.times(Vector(base.x, -base.y) * (1.0 / base.square))

    def end(self, loop: Loop, last: bool) -> Vector:
        """A known end of a loop: a joint, or the axis point of the slider there."""
        joint = loop.end if last else loop.start
        if joint is not None:
            return self.joints[joint]
        guide = self._body(loop.steps[-1 if last else 0].body).guide
        assert guide is not None
        return self.origin(guide)

    def _solve(self, block: Block) -> None:
        loop = block.loops[0]
        gap = self.end(loop, last=True) - self.end(loop, last=False)
        for step in loop.steps:
            if step.body not in block.unknowns:
                assert step.start is not None
                assert step.end is not None
                gap = gap - self.along(step.body, step.start, step.end)
        steps = [step for step in loop.steps if step.body in block.unknowns]
        turning = [(s.body, s.start, s.end) for s in steps if s.start and s.end]
        squares = [self.in_frame(body, start, end).square for body, start, end in turning]
        axes = [self.axis(guide) for s in steps if (guide := self._body(s.body).guide) is not None]
        dyad: Dyad
        if block.kind == "RRR":
            dyad = TwoLinks.solve(gap, squares[0], squares[1], self.inputs.side(block.index))
            links = [dyad.first, dyad.second]
        elif block.kind == "RRP":
            dyad = LinkAndSlider.solve(-gap, squares[0], axes[0], self.inputs.side(block.index))
            links = [dyad.link]
            self.displacements[steps[1].body] = dyad.position
        else:
            dyad = TwoSliders.solve(-gap, axes[0], axes[1])
            links = []
            self.displacements[steps[0].body] = dyad.first
            self.displacements[steps[1].body] = dyad.second
        for (body, start, end), link in zip(turning, links, strict=True):
            self._known_links[body] = ((start, end), link.label(f"body{self.body_numbers[body]}_"))
        self.dyads[block.index] = dyad
        for name, value in vars(dyad).items():
            if isinstance(value, Scalar) and value.label is None and value.operands:
                value.label = f"block{block.index}_{name}"
