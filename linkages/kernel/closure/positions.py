"""Where everything is: positions of points and vectors along bodies, block by block."""

from __future__ import annotations

import math

from linkages.components.contributed.functions import Table
from linkages.components.contributed.terms import Body
from linkages.kernel.closure.closed_forms import solve_dyad
from linkages.kernel.closure.dyads import Dyad
from linkages.kernel.closure.frames import Frames
from linkages.kernel.closure.iterated import Iterated
from linkages.kernel.closure.iteration import iterate_block
from linkages.kernel.graph.differentiation import derivative
from linkages.kernel.graph.scalars import Scalar, section
from linkages.kernel.graph.vectors import Vector
from linkages.kernel.numbers.inputs import Inputs
from linkages.kernel.numbers.laws import Law, law_of, value_of
from linkages.topology.blocks import ITERATED, Block, Loop
from linkages.topology.orientation import is_unit
from linkages.topology.topology import Topology


class Positions:
    """Positions of a mechanism as functions of parameters, time and integrated coordinates.

    Parameters
    ----------
    topology
        Its blocks are solved in their order.
    inputs
        Arguments of the kernel.

    Attributes
    ----------
    joints
        Point → position.
    displacements
        Slider → displacement, of those that do not follow from others.
    units, links
        How a body is turned: its unit vector, or one of its vectors in its own frame and in the
        plane.
    dyads
        Block → its solution.
    laws
        Driven body → its law.
    """

    def __init__(self, topology: Topology, inputs: Inputs) -> None:
        self.topology = topology
        self.inputs = inputs
        self.graph = inputs.graph
        self.frames = Frames(topology, inputs, self.slope)
        self.dyads: dict[int, Dyad | Iterated] = {}
        # in the order of the bodies: the order of the ground joints in the file is no structure
        mechanism = topology.mechanism
        ground = mechanism.anchors
        used = [j for name in mechanism.bodies for j in mechanism.labels(name) if j in ground]
        self.joints = {
            joint: inputs.vector(ground[joint]) for joint in dict.fromkeys([*used, *ground])
        }
        self.displacements: dict[str, Scalar] = {}
        self.laws: dict[str, Law] = {}
        self.units: dict[str, Vector] = {}
        self.links: dict[str, tuple[Vector, Vector]] = {}
        self._angles: dict[str, Scalar] = {}
        self._followers: dict[str, Vector] = {}
        self.numbers = {joint: index for index, joint in enumerate(topology.joints)}
        self.body_numbers = {name: i for i, name in enumerate(mechanism.bodies)}
        self._known_coordinates()
        for block in topology.blocks:
            title = f"block {block.index}: {block.title}"
            with section(title if block.unknowns else "bodies with known coordinates"):
                self._place(block)

    def body(self, name: str) -> Body:
        """A body by its name."""
        return self.topology.mechanism.bodies[name]

    def integrated(self, name: str) -> Scalar:
        """The integrated coordinate of a body, free or carried along."""
        return self.inputs.coordinate(self.topology.coordinates.index(name))

    def _known_coordinates(self) -> None:
        """What is known before any block is solved."""
        for name in (*self.topology.driven, *self.topology.free):
            with section(f"body {self.body_numbers[name]}: known coordinate"):
                self._know(name)

    def _know(self, name: str) -> None:
        if name in self.topology.driven:
            law = law_of(self.topology.mechanism.prescribed[name].law, self.inputs)
            self.laws[name] = law
            self.assign(name, law.value)
        else:
            self.assign(name, self.integrated(name))
        if name in self.units:
            self.units[name].label(f"body{self.body_numbers[name]}_e")

    def assign(self, name: str, coordinate: Scalar) -> None:
        """Enter the value of a coordinate."""
        self._followers.clear()
        if self.body(name).rotates:
            self._angles[name] = coordinate
            self.units[name] = Vector(self.graph.cos(coordinate), self.graph.sin(coordinate))
        else:
            self.displacements[name] = coordinate

    def _place(self, block: Block) -> None:
        if block.unknowns:
            solve = iterate_block if block.kind == ITERATED else solve_dyad
            self.dyads[block.index] = solve(self, block)
        for name, entry, labels in block.placements:
            for label in labels:
                place = self.joints[entry] + self.along(name, entry, label)
                self.joints[label] = place
                if label in self.numbers:
                    place.label(f"joint{self.numbers[label]}_")

    def in_frame(self, name: str, start: str, end: str) -> Vector:
        """From one point of a body to another, in the body's own frame."""
        vector = self.frames.fixed(name, start, end)
        sliding = self.frames.sliding(name, start, end)
        if not sliding:
            return vector
        displacement = self.displacement(name)
        return Vector(vector.x + (displacement if sliding > 0 else -displacement), vector.y)

    def along(self, name: str, start: str, end: str) -> Vector:
        """From one point of a body to another."""
        master, own = self.frames.rotation(name)
        return self.turned(master, own.times(self.in_frame(name, start, end)))

    def turned(self, master: str | None, vector: Vector) -> Vector:
        """A vector in the frame of a body (None: the ground) as it stands in the plane."""
        if master is None:
            return vector
        if master not in self.links:
            return self.unit(master).times(vector)
        base, link = self.links[master]
        if (vector.x, vector.y) == (base.x, base.y):
            return link
        if (vector.x, vector.y) == ((-base).x, (-base).y):
            return -link
        conjugate = Vector(base.x, -base.y)
        return link.times(vector.times(conjugate) * (1.0 / base.square))

    def unit(self, name: str) -> Vector:
        """Cosine and sine of the angle of a body's frame."""
        master, own = self.frames.rotation(name)
        if master is None:
            return own
        if master in self.links:
            base, link = self.links[master]
            unit = link.times(Vector(base.x, -base.y) * (1.0 / base.square))
        elif master in self.units:
            unit = self.units[master]
        else:
            unit = self._follower(master)
        return unit.times(own)

    def _follower(self, name: str) -> Vector:
        """Unit vector of a body that gears turn, or that turns against another one."""
        if name not in self._followers:
            relation = self.topology.slaves[name]
            if all(is_unit(ratio) for _, ratio in relation.parts):
                turned = self.frames.direction(relation.offset)
                for other, _ in relation.parts:
                    turned = turned.times(self.unit(other))
                self._followers[name] = turned
            else:
                angle = self.angle(name)
                self._followers[name] = Vector(self.graph.cos(angle), self.graph.sin(angle))
        return self._followers[name]

    def angle(self, name: str) -> Scalar:
        """The angle of a body; with its whole turns where they count or it is not dependent.

        Any other angle lies in [−π, π].
        """
        guide = self.body(name).guide
        if guide is not None:
            turned = self.inputs.parameter(guide.angle)
            return turned if guide.body is None else self.angle(guide.body) + turned
        if name in self.topology.slaves:
            return self._following(name)
        if name in self._angles:
            return self._angles[name]
        unit = self.unit(name)
        angle = self.graph.apply("atan2", unit.y, unit.x)
        if name in self.topology.carried:
            turns = (self.integrated(name) - angle) * (0.5 / math.pi) + 0.5
            angle = angle + self.graph.apply("floor", turns) * (2.0 * math.pi)
            self._angles[name] = angle
        return angle

    def gap(self, loop: Loop) -> Vector:
        """What the links of a loop bridge: it may end where it starts, in its own block."""
        if loop.start == loop.end:
            return Vector(self.graph.zero, self.graph.zero)
        return self.joints[loop.end] - self.joints[loop.start]

    def correct(self, name: str, value: Scalar, update: Scalar) -> None:
        """Add an update of the size of round-off without another sine and cosine."""
        self._followers.clear()
        if self.body(name).rotates:
            self.units[name] = self.units[name].times(Vector(self.graph.one, update))
            self._angles[name] = value + update
        else:
            self.displacements[name] = value + update

    def coordinate(self, name: str) -> Scalar:
        """A body's own coordinate: its angle, or its displacement."""
        return self.angle(name) if self.body(name).rotates else self.displacement(name)

    def displacement(self, name: str) -> Scalar:
        """The displacement of a slider."""
        following = name in self.topology.slaves
        return self._following(name) if following else self.displacements[name]

    def _following(self, name: str) -> Scalar:
        """A coordinate that follows from others."""
        relation = self.topology.slaves[name]
        value = self._summed(name)
        if relation.profile is not None:
            value = self._lift(relation.profile, value)
        return value + self.inputs.parameter(relation.offset)

    def _summed(self, name: str) -> Scalar:
        parts = self.frames.summed(name)
        return self.graph.total(factor * self.coordinate(other) for other, factor in parts)

    def _lift(self, profile: Table, value: Scalar) -> Scalar:
        return value_of(profile, self.inputs, lambda _: value)

    def _profile(self, name: str) -> Table:
        profile = self.topology.slaves[name].profile
        assert profile is not None
        return profile

    def slope(self, name: str) -> Scalar:
        """Derivative of the lift of a cam's follower by the angle of the cam."""
        angle = self._summed(name)
        ((found,),) = derivative([self._lift(self._profile(name), angle)], [angle])
        return found

    def curvature(self, name: str) -> Scalar:
        """Second derivative of the lift of a cam's follower by the angle of the cam."""
        return self._lift(self._profile(name).bends, self._summed(name))

    def travel(self, name: str) -> Vector:
        """How the pin of a slider moves on its axis with what its displacement follows from."""
        relation = self.topology.slaves.get(name)
        cam = relation is not None and relation.profile is not None
        return self.unit(name) * self.slope(name) if cam else self.unit(name)
