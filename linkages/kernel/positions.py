"""Positions of points and bodies, block by block."""

from __future__ import annotations

import math
from collections.abc import Callable

from linkages.components.contributed.functions import Table
from linkages.components.contributed.terms import Body, Parameter, Prescribed
from linkages.kernel.differentiation import derivative
from linkages.kernel.dyads import (
    Dyad,
    Iterated,
    LinkAndSlider,
    LinkInGuide,
    TwoLinks,
    TwoSliders,
    iterate_block,
)
from linkages.kernel.inputs import Inputs, Law, law_of, right_angle, value_of
from linkages.kernel.scalars import Scalar, Vector, section
from linkages.topology.assur_groups import ITERATED, Block, Loop
from linkages.topology.decomposition import is_unit, leaders_first
from linkages.topology.topology import Topology


def solve_dyad(positions: Positions, block: Block) -> Dyad:
    """Solve a dyad and enter the positions of its bodies.

    All links that turn with an unknown angle count as one.
    """
    graph, frames = positions.graph, positions.frames
    loop = block.loops[0]
    gap = positions.gap(loop)
    zero = Vector(graph.zero, graph.zero)
    bases = {name: zero for name in block.unknowns if positions.body(name).rotates}
    slides: dict[str, tuple[Vector, float]] = {}
    for step in loop.steps:
        way = (step.body, step.start, step.end)
        master, own = frames.rotation(step.body)
        sliding = frames.sliding(*way) if step.body in block.unknowns else 0
        if sliding:
            link = own.times(frames.fixed(*way))
            axis = own if master in bases else positions.unit(step.body)
            slides[step.body] = (axis, float(sliding))
        else:
            link = own.times(positions.in_frame(*way))
        if master in bases:
            bases[master] = bases[master] + link
        else:
            gap = gap - positions.turned(master, link)
    dyad = _solved(positions, block, gap, bases, slides)
    _label(positions, block, dyad)
    return dyad


def _solved(
    positions: Positions,
    block: Block,
    gap: Vector,
    bases: dict[str, Vector],
    slides: dict[str, tuple[Vector, float]],
) -> Dyad:
    """Solve for what bridges the gap.

    `slides` has the axis of each unknown displacement (in the frame of its carrier if that turns
    with an unknown angle), and +1 for a way along it, −1 for one against it.
    """
    first, second = block.unknowns
    if block.kind == "PP":
        (one, one_way), (other, other_way) = slides[first], slides[second]
        sliders = TwoSliders.solve(-gap, one * one_way, other * -other_way)
        positions.displacements |= {first: sliders.first, second: sliders.second}
        return sliders
    side = positions.inputs.side(block.index)
    base = bases[first]
    if block.kind == "RRR":
        links = TwoLinks.solve(gap, base.square, bases[second].square, side)
        positions.links |= {first: (base, links.first), second: (bases[second], links.second)}
        return links
    axis, way = slides[second]
    if block.kind == "RRP":
        pushed = LinkAndSlider.solve(-gap, base.square, axis * -way, side)
        positions.links[first] = (base, pushed.link)
        positions.displacements[second] = pushed.position
        return pushed
    guided = LinkInGuide.solve(gap, base, axis, way, side)
    positions.units[first] = guided.unit
    positions.displacements[second] = guided.position
    return guided


def _label(positions: Positions, block: Block, dyad: Dyad) -> None:
    """Name the results in the generated kernel."""
    for name in block.unknowns:
        if name in positions.links:
            positions.links[name][1].label(f"body{positions.body_numbers[name]}_")
    for name, value in vars(dyad).items():
        if isinstance(value, Scalar) and value.label is None and value.operands:
            value.label = f"block{block.index}_{name}"


class Frames:
    """Vectors within bodies, in frames of the bodies that they turn with."""

    def __init__(self, topology: Topology, inputs: Inputs, slope: Callable[[str], Scalar]) -> None:
        self._slope = slope
        self._topology = topology
        self._mechanism = topology.mechanism
        self._inputs = inputs
        self._one = Vector(inputs.graph.one, inputs.graph.zero)
        self._rotations: dict[str, tuple[str | None, Vector]] = {}
        self.known_moves: dict[str, dict[str, Scalar]] = {}  # those of followers

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
        fixed: dict[str, tuple[str | None, Parameter] | None] = {}

        def leaders(name: str) -> list[str]:
            fixed[name] = self._fixed_to(name)
            body, _ = fixed[name] or (None, None)
            return [] if body is None else [body]

        for each in leaders_first([name], leaders, self._rotations):
            to = fixed[each]
            if to is None:
                self._rotations[each] = each, self._one
                continue
            body, angle = to
            master, own = (None, self._one) if body is None else self._rotations[body]
            self._rotations[each] = master, own.times(self.direction(angle))
        return self._rotations[name]

    def _fixed_to(self, name: str) -> tuple[str | None, Parameter] | None:
        """What a body is fixed to (None: the ground), and at which angle; None of others."""
        guide = self._mechanism.bodies[name].guide
        if guide is not None:
            return guide.body, guide.angle
        relation = self._topology.followers.get(name)
        if relation is None or not self._topology.orientations[name].rigid:
            return None
        return relation.parts[0][0] if relation.parts else None, relation.offset

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
        body, _ = self._topology.turning(name)
        return {} if body is None else self.moves(body)

    def moves(self, name: str) -> dict[str, Scalar]:
        """How fast a body's own coordinate changes with each that it depends on."""
        if name not in self._topology.followers:
            return {name: self._inputs.graph.one}
        for follower in leaders_first([name], self._topology.leaders, self.known_moves):
            total = self.known_moves.setdefault(follower, {})
            for other, factor in self.follows(follower):
                for master, value in self.moves(other).items():
                    added = factor * value
                    total[master] = total[master] + added if master in total else added
        return self.known_moves[name]

    def follows(self, name: str) -> list[tuple[str, Scalar]]:
        """Bodies that a follower moves with, and in which ratios of rates."""
        parts = self.summed(name)
        if self._topology.followers[name].profile is None:
            return parts
        slope = self._slope(name)
        return [(other, slope * ratio) for other, ratio in parts]

    def summed(self, name: str) -> list[tuple[str, Scalar]]:
        """Bodies whose coordinates a follower's depends on, and in which ratios they add up."""
        parts = self._topology.followers[name].parts
        one, parameter = self._inputs.graph.one, self._inputs.parameter
        return [(name, one if is_unit(ratio) else parameter(ratio)) for name, ratio in parts]


class Positions:
    """Positions of a mechanism as functions of parameters, time and integrated coordinates."""

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
        self._followed: dict[str, Scalar] = {}
        self.numbers = {joint: index for index, joint in enumerate(topology.joints)}
        self.body_numbers = {name: i for i, name in enumerate(mechanism.bodies)}
        for name in (*topology.driven, *topology.free):
            with section(f"body {self.body_numbers[name]}: known coordinate"):
                self._know(name)
        for block in topology.blocks:
            title = f"block {block.index}: {block.title}"
            with section(title if block.unknowns else "bodies with known coordinates"):
                self._place(block)

    def body(self, name: str) -> Body:
        """A body by its name."""
        return self.topology.mechanism.bodies[name]

    def integrated(self, name: str) -> Scalar:
        """The integrated coordinate of a body, free or carried along."""
        return self.inputs.coordinate(self.topology.places[name])

    def _know(self, name: str) -> None:
        if name in self.topology.mechanism.prescribed:
            law = self._law(self.topology.mechanism.prescribed[name])
            self.laws[name] = law
            self.assign(name, law.value)
        else:
            self.assign(name, self.integrated(name))
        if name in self.units:
            self.units[name].label(f"body{self.body_numbers[name]}_e")

    def _law(self, drive: Prescribed) -> Law:
        """What a drive imposes: its law, and what deviates from that."""
        law, topology = law_of(drive.law, self.inputs), self.topology
        if drive.deviation is None:
            return law
        deviation, its_rate, given = drive.deviation
        first = len(topology.free)
        places = [first + topology.internal.index(name) for name in (deviation, its_rate)]
        own = [self.inputs.rate(place) for place in places]
        acceleration = law.acceleration + self.inputs.parameter(given)
        return Law(law.value + own[0], law.rate + own[1], acceleration)

    def _forget(self) -> None:
        """Forget what followed from coordinates before one of them changed."""
        for known in (self._followers, self._followed, self.frames.known_moves):
            known.clear()

    def assign(self, name: str, coordinate: Scalar) -> None:
        """Enter the value of a coordinate."""
        self._forget()
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
        followers = self.topology.followers

        def turns_as_sum(name: str) -> bool:
            return all(is_unit(ratio) for _, ratio in followers[name].parts)

        def leaders(name: str) -> list[str]:
            if not turns_as_sum(name):
                return []
            masters = (self.frames.rotation(other)[0] for other, _ in followers[name].parts)
            return [m for m in masters if m is not None and m in followers]

        for each in leaders_first([name], leaders, self._followers):
            if turns_as_sum(each):
                turned = self.frames.direction(followers[each].offset)
                for other, _ in followers[each].parts:
                    turned = turned.times(self.unit(other))
                self._followers[each] = turned
            else:
                angle = self.angle(each)
                self._followers[each] = Vector(self.graph.cos(angle), self.graph.sin(angle))
        return self._followers[name]

    def angle(self, name: str) -> Scalar:
        """The angle of a body; a dependent one whose whole turns do not count lies in [−π, π]."""
        carrier, guides = self.topology.turning(name)
        if guides:
            total = self.graph.zero if carrier is None else self.angle(carrier)
            return self.graph.total(
                [total, *(self.inputs.parameter(guide.angle) for guide in reversed(guides))]
            )
        if name in self.topology.followers:
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
        self._forget()
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
        following = name in self.topology.followers
        return self._following(name) if following else self.displacements[name]

    def _following(self, name: str) -> Scalar:
        for follower in leaders_first([name], self.topology.leaders, self._followed):
            relation = self.topology.followers[follower]
            value = self._summed(follower)
            if relation.profile is not None:
                value = self.lift(relation.profile, value)
            self._followed[follower] = value + self.inputs.parameter(relation.offset)
        return self._followed[name]

    def _summed(self, name: str) -> Scalar:
        parts = self.frames.summed(name)
        return self.graph.total(factor * self.coordinate(other) for other, factor in parts)

    def lift(self, profile: Table, angle: Scalar) -> Scalar:
        """The lift of a cam at an angle."""
        return value_of(profile, self.inputs, lambda _: angle)

    def lift_slope(self, profile: Table, angle: Scalar) -> Scalar:
        """Its derivative by the angle."""
        ((result,),) = derivative([self.lift(profile, angle)], [angle])
        return result

    def _profile(self, name: str) -> Table:
        profile = self.topology.followers[name].profile
        assert profile is not None
        return profile

    def slope(self, name: str) -> Scalar:
        """Derivative of the lift of a cam's follower by the angle of the cam."""
        return self.lift_slope(self._profile(name), self._summed(name))

    def curvature(self, name: str) -> Scalar:
        """Second derivative of the lift of a cam's follower by the angle of the cam."""
        return self.lift(self._profile(name).bends, self._summed(name))

    def travel(self, name: str) -> Vector:
        """How the pin of a slider moves on its axis with what its displacement follows from."""
        relation = self.topology.followers.get(name)
        cam = relation is not None and relation.profile is not None
        return self.unit(name) * self.slope(name) if cam else self.unit(name)
