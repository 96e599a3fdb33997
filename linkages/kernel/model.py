"""The equations of motion of a mechanism as one graph of scalar operations.

A rigid body whose centre of mass lies at P + (λ + iμ)(Q − P), in complex notation and with two of
its points P and Q at distance L, moves exactly like a mass m(1 − λ) at P, a mass mλ at Q and the
moment of inertia J − mL²(λ − λ² − μ²), plus, if μ ≠ 0, a coupling −mμ (v_P × v_Q) in the energy.
Masses of all bodies at a joint add up, and the sums depend on parameters alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

from linkages.components.contributed.functions import Function, Internal, Measured
from linkages.components.contributed.load_measures import Load, Measure, written
from linkages.components.contributed.state_laws import NOTHING, InternalState
from linkages.components.contributed.terms import Body
from linkages.kernel.differentiation import Evaluator, solve_symmetric
from linkages.kernel.forces.generalised_forces import Acting, LoadNodes, load_nodes
from linkages.kernel.inputs import Inputs, chosen_paths, definition_numbers, value_of
from linkages.kernel.lru_cache import LRUCache
from linkages.kernel.positions import Positions
from linkages.kernel.scalars import Scalar, ScalarGraph, Vector, section
from linkages.kernel.switches import Switches, add_updates
from linkages.kernel.velocities import Accelerations, Rates
from linkages.reading.paths import KeyPath, dotted
from linkages.topology.topology import Topology

if TYPE_CHECKING:
    from linkages.kernel.articulated_bodies import BodyTree
    from linkages.kernel.cams import CamNodes
    from linkages.kernel.forces.contact_forces import GapNodes
    from linkages.kernel.forces.rigid_contacts import RigidContacts
    from linkages.kernel.forces.rigid_impacts import EndNodes, Unilateral


class MotionField(Protocol):
    """Velocities or accelerations of bodies and joints."""

    joints: dict[str, Vector]

    def turning(self, name: str) -> Scalar:
        """Angular speed or acceleration of a body."""
        ...


@dataclass(frozen=True)
class Coupling:
    """A body whose centre of mass is off the line through two of its points."""

    factor: Scalar
    first: str
    second: str
    body: str


class Inertia:
    """Masses and moments of inertia, and the quadratic forms that they define."""

    @section("masses at joints and moments of inertia")
    def __init__(self, positions: Positions) -> None:
        self._positions = positions
        self._graph = positions.graph
        self.masses: dict[str, Scalar] = {}
        self.shares: dict[tuple[str, str], Scalar] = {}
        self.moments: dict[str, Scalar] = {}
        self.couplings: list[Coupling] = []
        for body in positions.topology.mechanism.bodies.values():
            if body.rotates:
                self._add_turning(body)
            else:
                self._add_sliding(body)
        for term in positions.topology.mechanism.point_masses:
            if not term.mass.absent:
                self._add_mass(term.joint, positions.inputs.parameter(term.mass))
        for joint, mass in self.masses.items():
            if mass.label is None and mass.operands:
                mass.label = f"joint{positions.numbers[joint]}_mass"

    def _add_mass(self, joint: str, mass: Scalar) -> None:
        self.masses[joint] = self.masses.get(joint, self._graph.zero) + mass

    def _add_share(self, body: Body, joint: str, mass: Scalar) -> None:
        self.shares[body.name, joint] = mass
        self._add_mass(joint, mass)

    def _add_sliding(self, body: Body) -> None:
        """The centre of mass of a slider lies at its first point."""
        if not body.mass.absent:
            first = next(iter(body.points))
            self._add_share(body, first, self._positions.inputs.parameter(body.mass))
        if not body.inertia.absent:
            self.moments[body.name] = self._positions.inputs.parameter(body.inertia)

    def _add_turning(self, body: Body) -> None:
        inputs = self._positions.inputs
        moment = inputs.parameter(body.inertia)
        if not body.mass.absent:
            mass = inputs.parameter(body.mass)
            first, *others = body.points
            centre = inputs.vector(body.centre) - inputs.vector(body.points[first])
            if others:
                second = others[0]
                base = self._positions.in_frame(body.name, first, second)
                ratio = centre.times(Vector(base.x, -base.y)) * (1.0 / base.square)
                self._add_share(body, first, mass * (1.0 - ratio.x))
                self._add_share(body, second, mass * ratio.x)
                share = ratio.x - ratio.x * ratio.x - ratio.y * ratio.y
                moment = moment - mass * base.square * share
                if ratio.y.constant != 0.0:
                    self.couplings.append(Coupling(mass * ratio.y, first, second, body.name))
            else:  # a body with one point has its centre of mass there
                self._add_share(body, first, mass)
        if moment.constant != 0.0:
            if moment.label is None and moment.operands:
                moment.label = f"body{self._positions.body_numbers[body.name]}_moment"
            self.moments[body.name] = moment

    def product(self, a: MotionField, b: MotionField, offset: Vector | None = None) -> Scalar:
        """Σ m a·b + Σ J α β; of partial velocities it is J_ij of the paper's Eq. 5."""
        terms: list[Scalar] = []
        for joint, mass in self.masses.items():
            vector = a.joints[joint] if offset is None else a.joints[joint] - offset
            weighted = b.joints[joint] * mass
            terms.append(vector.dot(weighted))
        terms += [a.turning(n) * (b.turning(n) * moment) for n, moment in self.moments.items()]
        for c in self.couplings:
            first, second = a.joints[c.first], a.joints[c.second]
            if offset is not None:
                first, second = first - offset, second - offset
            skew = first.dot(b.joints[c.second].turned) - second.dot(b.joints[c.first].turned)
            terms.append(c.factor * skew)
        return self._graph.total(terms)

    def apart(
        self, a: MotionField, body: str, point: str, velocity: Vector, offset: Vector | None = None
    ) -> Scalar:
        """What the masses of a body at one of its points add where it moves away from that point.

        `product` takes all masses at a joint to move with it.
        """

        def at(joint: str) -> Vector:
            return a.joints[joint] if offset is None else a.joints[joint] - offset

        share = self.shares.get((body, point), self._graph.zero)
        total = at(point).dot(velocity * share)
        for c in self.couplings:
            if c.body == body and point == c.second:
                total = total + c.factor * at(c.first).dot(velocity.turned)
            if c.body == body and point == c.first:
                total = total - c.factor * at(c.second).dot(velocity.turned)
        return total

    def forces(self, a: MotionField, offset: Vector) -> tuple[dict[str, Vector], dict[str, Scalar]]:
        """What `product` is the power of: forces at joints, and torques on bodies."""
        moved = {joint: a.joints[joint] - offset for joint in a.joints}
        at = {joint: moved[joint] * mass for joint, mass in self.masses.items()}
        zero = Vector(self._graph.zero, self._graph.zero)
        for c in self.couplings:
            first, second = moved[c.first].turned, moved[c.second].turned
            at[c.second] = at.get(c.second, zero) - first * c.factor
            at[c.first] = at.get(c.first, zero) + second * c.factor
        return at, {name: a.turning(name) * moment for name, moment in self.moments.items()}

    def moment_of_mass(self) -> Vector:
        """Σ m x: total mass times the place of the common centre of mass, in kg·m."""
        total = Vector(self._graph.zero, self._graph.zero)
        places = self._positions.joints
        for joint, mass in self.masses.items():
            total = total + places[joint] * mass
        for c in self.couplings:
            total = total + (places[c.second] - places[c.first]).turned * c.factor
        return total


MOST_EVALUATORS = 128
"""Sets of nodes whose way of evaluation a model remembers."""


@dataclass(frozen=True)
class Actuated:
    """Rates of actuators per rates of driven coordinates, one row for each actuator."""

    rows: Sequence[Sequence[Scalar]]

    def driven(self, rates: Sequence[Scalar]) -> list[Scalar]:
        """Rates of driven coordinates from those of actuators."""
        if len(rates) == 1:
            return [rates[0] / self.rows[0][0]]
        return self.rows[0][0].graph.solve(self.rows, rates)

    @property
    def dexterity(self) -> Scalar:
        """The determinant of the rows scaled to length one, from −1 to 1; zero if singular."""
        graph, result = self.rows[0][0].graph, determinant(self.rows)
        for row in self.rows:
            result = result / graph.sqrt(graph.total(number * number for number in row))
        return result


def determinant(rows: Sequence[Sequence[Scalar]]) -> Scalar:
    """By minors of the first row; of a few rows, with derivatives."""
    first, *others = rows
    if not others:
        return first[0]
    minors = (determinant([[*row[:k], *row[k + 1 :]] for row in others]) for k in range(len(rows)))
    return first[0].graph.total(
        (-1.0) ** k * number * minor
        for k, (number, minor) in enumerate(zip(first, minors, strict=True))
    )


@dataclass(frozen=True)
class Reach:
    """Whether a block can be assembled: `radicand` must not be negative."""

    block: int
    radicand: Scalar


class Model:
    """Positions, motion, inertia and efforts of a mechanism, built when they are asked for."""

    def __init__(self, topology: Topology, more: int = 0, further: Sequence[KeyPath] = ()) -> None:
        self.topology = topology
        self.mechanism = topology.mechanism
        self.graph = ScalarGraph()
        paths = [*definition_numbers(self.mechanism), *chosen_paths(topology), *further]
        self.inputs = Inputs(self.graph, len(topology.coordinates) + more, paths)
        self.positions = Positions(topology, self.inputs)
        self.switches = Switches(self)
        self._pressing: dict[int, Scalar] = {}
        self._evaluators: LRUCache[tuple[Scalar, ...], Evaluator] = LRUCache(MOST_EVALUATORS)
        self.outputs: dict[object, list[Scalar]] = {}

    def evaluator(self, nodes: Sequence[Scalar]) -> Evaluator:
        """Evaluates nodes; those of a sweep are asked for at every point."""
        return self._evaluators.get(tuple(nodes), lambda: Evaluator(nodes))

    @cached_property
    def gravity(self) -> Vector:
        """Gravitational acceleration."""
        g = self.mechanism.gravity
        return self.inputs.vector((g.x, g.y))

    @cached_property
    def inertia(self) -> Inertia:
        """Masses and moments of inertia."""
        return Inertia(self.positions)

    @cached_property
    def loads(self) -> list[LoadNodes]:
        """Forces, torques, springs and dampers."""
        return [load_nodes(self, load, place) for place, load in enumerate(self.mechanism.loads)]

    @cached_property
    def sensed(self) -> dict[Measure, LoadNodes]:
        """What laws depend on beside what their loads act along; no force is along them here."""
        first = len(self.mechanism.loads)
        return {
            measure: load_nodes(self, Load(measure, NOTHING, ()), place)
            for place, measure in enumerate(self.mechanism.sensed, first)
        }

    @property
    def pressing(self) -> dict[int, Scalar]:
        """Number of a load whose law depends on a reaction → the size of that."""
        _ = self.changes
        return self._pressing

    @property
    def unpressed(self) -> list[Acting]:
        """All that acts, but for what follows a reaction."""
        loads = [load for load in self.loads if load.load.bearing is None]
        return [*loads, *self.contacts, *self.ends]

    @cached_property
    def internal(self) -> list[Scalar]:
        """Values of the internal states: rates of coordinates that mean nothing."""
        first = len(self.topology.free)
        return [self.inputs.rate(first + k) for k in range(len(self.topology.internal))]

    @property
    def internal_rates(self) -> list[Scalar]:
        """Rates of the internal states; zero for those that are sampled."""
        of_loads = [rate for load in self.loads for rate in load.internal_rates]
        zero = self.graph.zero
        own = [law if s.period is None else zero for s, law in self.own_laws]
        return [*of_loads, *own]

    @property
    def next_values(self) -> list[Scalar]:
        """What the internal states become at an update; the values of those that have none."""
        of_loads = [value for load in self.loads for value in load.next_values]
        own = [self.sense(s.value) if s.period is None else law for s, law in self.own_laws]
        return [*of_loads, *own]

    @property
    def own_laws(self) -> list[tuple[InternalState, Scalar]]:
        """Internal states that belong to no load, and what their laws give."""
        return [(state, self._own_law(state)) for state in self.mechanism.states]

    def _own_law(self, state: InternalState) -> Scalar:

        def mode(part: Function, node: Scalar) -> Scalar:
            return self.switches.side(f"{dotted(state.path)}: {written(part)}", node)

        if state.period is not None:
            return value_of(state.law, self.inputs, self.sense)
        return value_of(state.law, self.inputs, self.sense, mode)

    def sense(self, found: Measured | Internal) -> Scalar:
        """The value or rate of a measure that laws depend on, or the value of an internal state."""
        if isinstance(found, Internal):
            return self.internal[self.topology.internal.index(found.name)]
        assert found.measure is not None
        return self.sensed[found.measure].measured(found.order)

    @cached_property
    def contacts(self) -> list[GapNodes]:
        """What presses in clearances that open."""
        if not self.mechanism.contacts:
            return []
        from linkages.kernel.forces.rigid_impacts import gap_nodes

        return [gap_nodes(self, contact) for contact in self.mechanism.contacts]

    @cached_property
    def ends(self) -> list[EndNodes]:
        """What bounces at ends of ways."""
        if not self.mechanism.ends:
            return []
        from linkages.kernel.forces.rigid_impacts import EndNodes

        first = len(self.mechanism.loads) + len(self.mechanism.sensed)
        return [EndNodes(self, end, place) for place, end in enumerate(self.mechanism.ends, first)]

    def cam(self, slider: str) -> CamNodes:
        """The cam of a follower."""
        from linkages.kernel.cams import following_cam
        from linkages.kernel.forces.gaps import FollowerGap

        gaps = (nodes.gap for nodes in self.contacts)
        left = (
            gap.cam for gap in gaps if isinstance(gap, FollowerGap) and gap.cam.slider == slider
        )
        return next(left, None) or following_cam(self.positions, slider)

    @cached_property
    def walls(self) -> RigidContacts:
        """The equations of all rigid contacts together."""
        from linkages.kernel.forces.rigid_contacts import RigidContacts

        return RigidContacts(self, self.rigid)

    @cached_property
    def rigid(self) -> list[Unilateral]:
        """All rigid contacts."""
        if not (self.mechanism.contacts or self.mechanism.ends):
            return []
        from linkages.kernel.forces.rigid_impacts import Unilateral

        return [nodes for nodes in self.acting if isinstance(nodes, Unilateral)]

    @property
    def acting(self) -> list[Acting]:
        """All that acts beside drives and gravity."""
        return [*self.loads, *self.contacts, *self.ends]

    @cached_property
    def known_rates(self) -> dict[str, Scalar]:
        """Rates of driven and free coordinates."""
        driven = {name: law.rate for name, law in self.positions.laws.items()}
        free = {name: self.inputs.rate(i) for i, name in enumerate(self.topology.free)}
        return driven | free

    @cached_property
    def velocities(self) -> Rates:
        """The actual velocities."""
        return Rates(self.positions, self.known_rates, "v")

    @cached_property
    def driven_accelerations(self) -> dict[str, Scalar]:
        """Second derivatives of driven coordinates."""
        return {name: law.acceleration for name, law in self.positions.laws.items()}

    @cached_property
    def bias(self) -> Accelerations:
        """Accelerations as they would be if the free coordinates did not accelerate."""
        return Accelerations(self.positions, self.velocities, self.driven_accelerations, "b")

    @cached_property
    def accelerations(self) -> Accelerations:
        """The actual accelerations, given those of the free coordinates."""
        free = range(len(self.topology.free))
        return self.moving_with([self.inputs.acceleration(i) for i in free])

    def moving_with(self, free: Sequence[Scalar]) -> Accelerations:
        """Accelerations of everything, given those of the free coordinates, which come first."""
        known = self.driven_accelerations | dict(zip(self.topology.free, free, strict=False))
        return Accelerations(self.positions, self.velocities, known, "a")

    def partial(self, name: str) -> Rates:
        """Partial velocities with respect to one coordinate."""
        number = self.positions.body_numbers[name]
        return Rates(self.positions, {name: self.graph.one}, f"u{number}")

    def stretched(self, link: str) -> Rates:
        """Virtual velocities as a link grows and nothing else works."""
        label = f"s{self.positions.body_numbers[link]}"
        return self.unactuated(lambda known: Rates(self.positions, known, label, link))

    @cached_property
    def actuators(self) -> list[LoadNodes]:
        """What makes the motion of the drives in their place."""
        actuations = self.mechanism.actuations.values()
        result = [load_nodes(self, Load(a.measure, NOTHING, a.path), -1) for a in actuations]
        for nodes in result:
            nodes.given_force = self.graph.one  # what it does per newton or newton metre
        return result

    @cached_property
    def actuated(self) -> Actuated:
        """How actuators move with the driven coordinates."""
        driven = [self.partial(name) for name in self.topology.driven]
        return Actuated([[own.rate(p) for p in driven] for own in self.actuators])

    @cached_property
    def drive_partials(self) -> list[Rates]:
        """Partial velocities with respect to what each drive moves, or each actuator."""
        driven = self.topology.driven
        if not self.actuators:
            return [self.partial(name) for name in driven]
        unit = [[float(i == k) for i in range(len(driven))] for k in range(len(driven))]
        rows = [self.actuated.driven([self.graph.number(v) for v in row]) for row in unit]
        return [
            Rates(self.positions, dict(zip(driven, row, strict=True)), f"m{k}")
            for k, row in enumerate(rows)
        ]

    def unactuated(self, made: Callable[[Mapping[str, Scalar]], Rates]) -> Rates:
        """Virtual velocities at which actuators stand still, or drives where there are none.

        `made`: rates of driven coordinates → the velocities.
        """
        result = made({})
        if not self.actuators:
            return result
        back = self.actuated.driven([-own.rate(result) for own in self.actuators])
        return made(dict(zip(self.topology.driven, back, strict=True)))

    @cached_property
    def tree(self) -> BodyTree | None:
        """The bodies as a tree, where they are one and are many."""
        if not self.topology.hangs:
            return None
        from linkages.kernel.articulated_bodies import BodyTree

        return BodyTree(self)

    def required_forces(
        self, accelerations: Accelerations, names: Sequence[str], acting: Sequence[Acting]
    ) -> list[Scalar]:
        """`required_of` for each of some coordinates."""
        if self.tree is not None:
            return self.tree.required(accelerations, acting, names)
        ways = self.partials if names == self.topology.free else map(self.partial, names)
        return [self.required_of(accelerations, way, acting) for way in ways]

    def accelerated(self, forces: Sequence[Scalar]) -> list[Scalar]:
        """Second derivatives of the free coordinates that generalised forces give: J⁻¹ forces."""
        if self.tree is not None:
            return self.tree.solved(forces)
        return solve_symmetric(self.mass_matrix, list(forces))

    def required_force(self, accelerations: Accelerations, partial: Rates) -> Scalar:
        """Generalised force that a motion needs beyond gravity and the loads (paper, Eq. 4)."""
        return self.required_of(accelerations, partial, self.acting)

    def required_of(
        self, accelerations: Accelerations, partial: Rates, acting: Sequence[Acting]
    ) -> Scalar:
        """The same of some of what acts."""
        with section(f"projection on {partial.label}"):
            force = self.inertia.product(accelerations, partial, self.gravity)
            if partial.apart is not None:
                force = force + self.inertia.apart(accelerations, *partial.apart, self.gravity)
            for load in acting:
                force = force - load.power(partial)
        return force

    @cached_property
    def reaches(self) -> list[Reach]:
        """What must not be negative for the mechanism to be assembled."""
        return [
            Reach(index, dyad.radicand)
            for index, dyad in self.positions.dyads.items()
            if dyad.radicand is not None
        ]

    @cached_property
    def margins(self) -> list[Scalar]:
        """Per block: zero at a singular position."""
        return [dyad.margin for dyad in self.positions.dyads.values()]

    @cached_property
    def margin_rates(self) -> list[Scalar]:
        """Derivatives of `margins` with respect to time."""
        return [self.velocities.margin_rate(block) for block in self.topology.solved_blocks]

    @cached_property
    def margin_scales(self) -> list[Scalar]:
        """Sizes of `margins` away from singular positions; to be taken at t = 0."""
        return [dyad.margin_scale for dyad in self.positions.dyads.values()]

    @cached_property
    def settled(self) -> list[Scalar]:
        """Coordinates that are carried along as the closure determines them, then their rates."""
        carried = self.topology.carried
        values = [self.positions.coordinate(name) for name in carried]
        return [*values, *(self.velocities.bodies[name] for name in carried)]

    @cached_property
    def counted(self) -> list[Scalar]:
        """Cosines, sines and speeds of the bodies whose whole turns are counted."""
        names = self.topology.counted
        units = [self.positions.unit(name) for name in names]
        speeds = [self.velocities.turning(name) for name in names]
        return [*(unit.x for unit in units), *(unit.y for unit in units), *speeds]

    def integrated_accelerations(self, changes: list[Scalar]) -> list[Scalar]:
        """Second derivatives of all integrated coordinates, given `changes`."""
        if not self.topology.carried:
            return changes
        bodies = self.moving_with(changes).bodies
        return [*changes, *(bodies[name] for name in self.topology.carried)]

    @cached_property
    def partials(self) -> list[Rates]:
        """Partial velocities of all free coordinates."""
        return [self.partial(name) for name in self.topology.free]

    @cached_property
    @section("inertia terms J_ij of the free coordinates")
    def mass_matrix(self) -> list[list[Scalar]]:
        """Lower triangle of J_ij over the free coordinates."""
        return [
            [self.inertia.product(self.partials[i], self.partials[j]) for j in range(i + 1)]
            for i in range(len(self.partials))
        ]

    @cached_property
    def unheld_accelerations(self) -> list[Scalar]:
        """Second derivatives of the free coordinates as if no rigid contact pressed."""
        given = [nodes for nodes in self.acting if nodes not in self.rigid]
        required = self.required_forces(self.bias, self.topology.free, given)
        return self.accelerated([-force for force in required])

    @property
    def free_accelerations(self) -> list[Scalar]:
        """Second derivatives of the free coordinates: J q̈ = −(force required without them)."""
        return self.changes[: len(self.topology.free)]

    @cached_property
    def unheld(self) -> Accelerations:
        """The accelerations as if no rigid contact pressed."""
        return self.moving_with(self.unheld_accelerations)

    @cached_property
    @section("accelerations of the free coordinates")
    def changes(self) -> list[Scalar]:
        """Second derivatives of the free coordinates, then the rates of internal states."""
        if self.tree is None:
            _ = self.mass_matrix  # its terms come first in generated code
        with self.switches.collecting():
            required = self.required_forces(self.bias, self.topology.free, self.unpressed)
            rates = self.internal_rates
            add_updates(self)
            solution = self.accelerated([-force for force in required])
            if pressed := [load for load in self.loads if load.load.bearing is not None]:
                from linkages.kernel.forces.reaction_friction import ReactionFrictions

                solution, self._pressing = ReactionFrictions(self, pressed).solved(solution)
        for index, value in enumerate(solution):
            if value.label is None and value.operands:
                value.label = f"acceleration{index}"
        return self.switches.sticking([*solution, *rates])

    @cached_property
    def power(self) -> Scalar:
        """Power of drives and loads, without springs, at accelerations that the state implies."""
        moving = self.moving_with(self.free_accelerations)
        result = self._driven_power(moving) + self.load_power
        if not self.switches.equivalent:
            return result
        return result + self.switches.held(self.driven_power + self.load_power)

    @property
    def losses(self) -> list[Scalar]:
        """Power lost across the walls of all contacts, then along them; rates of sliding."""
        result = [contact.normal_loss for contact in self.contacts]
        result += [contact.friction_loss for contact in self.contacts]
        if self.switches.equivalent:
            result = [loss + self.switches.held(loss) for loss in result]
        if not self.mechanism.rubbing:
            return result
        from linkages.kernel.forces.sliding import sliding_rates

        return [*result, *sliding_rates(self)]

    @property
    def driven_power(self) -> Scalar:
        """Power of the drives, given the accelerations of the free coordinates."""
        return self._driven_power(self.accelerations)

    def _driven_power(self, accelerations: Accelerations) -> Scalar:
        driven = self.topology.driven
        efforts = self.required_forces(accelerations, driven, self.acting)
        return self.graph.total(
            effort * self.known_rates[name] for name, effort in zip(driven, efforts, strict=True)
        )

    @property
    def load_power(self) -> Scalar:
        """Power of all loads but of what they store."""
        return self.graph.total(load.working for load in self.acting)

    @property
    def potential_energy(self) -> Scalar:
        """Of gravity and springs; zero for centres of mass at the origin and relaxed springs."""
        elastic = self.graph.total(load.potential for load in self.acting)
        return elastic - self.gravity.dot(self.inertia.moment_of_mass())
