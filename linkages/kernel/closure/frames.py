"""How bodies are turned: constant rotations against the body whose angle is solved for."""

from __future__ import annotations

from collections.abc import Callable

from linkages.components.contributed.terms import Parameter
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.graph.vectors import Vector
from linkages.kernel.numbers.inputs import Inputs
from linkages.kernel.numbers.parameters import right_angle
from linkages.topology.orientation import is_unit
from linkages.topology.topology import Topology


class Frames:
    """Vectors within bodies, in frames of the bodies that they turn with.

    Parameters
    ----------
    topology, inputs
        The mechanism and the numbers of its definition.
    slope
        Follower of a cam → the derivative of its lift at the angle of the cam.
    """

    def __init__(self, topology: Topology, inputs: Inputs, slope: Callable[[str], Scalar]) -> None:
        self._slope = slope
        self._topology = topology
        self._mechanism = topology.mechanism
        self._inputs = inputs
        self._one = Vector(inputs.graph.one, inputs.graph.zero)

    def direction(self, angle: Parameter) -> Vector:
        """Unit vector at an angle; exact multiples of 90° are structure."""
        quarters, graph = right_angle(angle), self._inputs.graph
        if quarters is not None:
            x, y = ((1, 0), (0, 1), (-1, 0), (0, -1))[quarters]
            return Vector(graph.number(x), graph.number(y))
        node = self._inputs.parameter(angle)
        return Vector(graph.cos(node), graph.sin(node))

    def rotation(self, name: str) -> tuple[str | None, Vector]:
        """The body that a body turns with as if fixed to it, and its direction in that frame.

        The body is None for the ground. A body that gears turn stands for itself.
        """
        guide = self._mechanism.bodies[name].guide
        if guide is not None:
            axis = self.direction(guide.angle)
            if guide.body is None:
                return None, axis
            master, own = self.rotation(guide.body)
            return master, own.times(axis)
        relation = self._topology.slaves.get(name)
        if relation is None or not self._topology.orientations[name].rigid:
            return name, self._one
        offset = self.direction(relation.offset)
        if not relation.parts:
            return None, offset
        master, own = self.rotation(relation.parts[0][0])
        return master, own.times(offset)

    def fixed(self, name: str, start: str, end: str) -> Vector:
        """From one point of a body to another in its own frame, without what slides."""
        return self._place(name, end) - self._place(name, start)

    def _place(self, name: str, label: str) -> Vector:
        places = self._mechanism.attachments[name]
        if label not in places:  # the axis point of a slider: at its pin when it has not moved
            return Vector(self._inputs.graph.zero, self._inputs.graph.zero)
        return self._inputs.vector(places[label])

    def sliding(self, name: str, start: str, end: str) -> int:
        """+1 for a way along the displacement of a slider, −1 against it, 0 otherwise."""
        body = self._mechanism.bodies[name]
        if body.rotates:
            return 0
        own = body.axis
        return (start == own) - (end == own)

    def ratios(self, name: str) -> dict[str, Scalar]:
        """How fast a body turns with each body that its orientation depends on."""
        guide = self._mechanism.bodies[name].guide
        if guide is not None:
            return {} if guide.body is None else self.ratios(guide.body)
        return self.moves(name)

    def moves(self, name: str) -> dict[str, Scalar]:
        """How fast a body's own coordinate changes with each that it depends on."""
        if name not in self._topology.slaves:
            return {name: self._inputs.graph.one}
        total: dict[str, Scalar] = {}
        for other, factor in self.follows(name):
            for master, value in self.moves(other).items():
                added = factor * value
                total[master] = total[master] + added if master in total else added
        return total

    def follows(self, name: str) -> list[tuple[str, Scalar]]:
        """Bodies that a follower moves with, and in which ratios of rates."""
        parts = self.summed(name)
        if self._topology.slaves[name].profile is None:
            return parts
        slope = self._slope(name)
        return [(other, slope * ratio) for other, ratio in parts]

    def summed(self, name: str) -> list[tuple[str, Scalar]]:
        """Bodies whose coordinates a follower's depends on, and in which ratios they add up."""
        parts = self._topology.slaves[name].parts
        return [(other, self._ratio(ratio)) for other, ratio in parts]

    def _ratio(self, ratio: Parameter) -> Scalar:
        graph = self._inputs.graph
        return graph.one if is_unit(ratio) else self._inputs.parameter(ratio)
