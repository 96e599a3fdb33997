"""The arguments of a kernel (parameters, time, state) and laws as nodes of its graph.

Structure is all of a mechanism that its numbers do not change: names, joints, laws as operations,
and which numbers are exactly zero, right angles or ones.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, assert_never

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.component import Term
from linkages.components.contributed.functions import (
    Function,
    Internal,
    Measured,
    Number,
    Operation,
    Table,
    Time,
    polynomials,
)
from linkages.components.contributed.load_measures import Distance, JointFriction, Load, Turn
from linkages.components.contributed.state_laws import InternalState
from linkages.components.contributed.terms import Guide, Initial, Parameter, Relation
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.differentiation import Evaluator, derivative
from linkages.kernel.scalars import Level, Scalar, ScalarGraph, Vector
from linkages.operations import COMPOSITE
from linkages.reading.overrides import Column
from linkages.reading.paths import KeyPath
from linkages.topology.decomposition import is_unit
from linkages.topology.topology import Topology

NEAREST: KeyPath = ("nearest",)
"""Distance in metres below which two joints are apart by round-off only."""

ROUND_OFF = 4e-15
"""Distance of two joints, beside the size of the mechanism, that round-off may cause."""

SIDED = ("RRR", "RRP", "RPR")
"""Blocks that can be assembled in two ways."""


def right_angle(angle: Parameter) -> int | None:
    """Quarter turns of an angle that is an exact multiple of 90°, 0 to 3; None if it is not."""
    quarters = angle.value / (math.pi / 2)
    return None if angle.kept or quarters != round(quarters) else round(quarters) % 4


def structure_key(item: object) -> Hashable:
    """What is left of a term without its numbers; equal for equal structures."""
    match item:
        case float() | Column():
            return float
        case Parameter(path, value):
            return (path, item.absent, item.kept) if path else value
        case Guide(origin, angle, body):
            return (structure_key(origin), structure_key(angle), right_angle(angle), body)
        case Relation(body, parts, offset, path):
            ratios = tuple((name, structure_key(r), is_unit(r)) for name, r in parts)
            profile = structure_key(item.profile)
            return (body, ratios, structure_key(offset), right_angle(offset), path, profile)
        case tuple():
            return tuple(map(structure_key, item))
        case str() | int() | None:
            return item
        case Mapping():
            return tuple((name, structure_key(value)) for name, value in item.items())
    return (type(item).__name__, *map(structure_key, parts_of(item)))


def numbers_in(item: object) -> Iterator[tuple[KeyPath, float]]:
    """Path and value of every parameter in a term, in their order; not those that are absent."""
    match item:
        case Parameter(path, value):
            if path and not item.absent:
                yield path, value
        case Table(path):
            for place, value in enumerate(table_numbers(item)):
                yield (*path, "spline", place), value
            yield from numbers_in(item.over if item.corners is None else item.corners)
        case Relation(_, parts, offset, profile=Table() as profile):
            yield from numbers_in((parts, offset, profile, profile.bends))
        case str() | float() | int() | Column() | None:
            return
        case _:
            for part in parts_of(item):
                yield from numbers_in(part)


def parts_of(item: object) -> Iterable[object]:
    """What a tuple, a mapping or a dataclass consists of; nothing of all else."""
    if isinstance(item, tuple):
        return item
    if (names := getattr(type(item), "__dataclass_fields__", None)) is not None:
        return [getattr(item, name) for name in names]
    return item.values() if isinstance(item, Mapping) else ()


def initial_values(terms: Iterable[Term]) -> Iterator[tuple[str, Any, Any]]:
    """Coordinates with their initial values and rates; internal states are rates."""
    for term in terms:
        if isinstance(term, Initial):
            yield term.body, term.position, term.speed
        elif isinstance(term, Load | JointFriction | InternalState):
            for state in (term,) if isinstance(term, InternalState) else term.states:
                yield state.name, 0.0, state.initial


def table_numbers(table: Table) -> list[float]:
    """Knots, then four coefficients for each interval, the cubic one first."""
    result = polynomials(table)
    return [*map(float, result.x), *(float(c) for column in result.c.T for c in column)]


def definition_numbers(mechanism: Mechanism) -> dict[KeyPath, float]:
    """Path → number of a definition, ordered by its structure: bodies, relations, laws, loads."""
    ground, bodies = mechanism.anchors, mechanism.bodies
    # in the order of the bodies: the order of the ground joints in the file is no structure
    used = [ground[j] for name in bodies for j in mechanism.labels(name) if j in ground]
    laws = [mechanism.prescribed[name] for name in bodies if name in mechanism.prescribed]
    groups: tuple[Iterable[object], ...] = (
        (mechanism.gravity,),
        used,
        ground.values(),
        bodies.values(),
        mechanism.relations,
        mechanism.point_masses,
        laws,
        mechanism.loads,
        mechanism.cam_profiles.values(),
        mechanism.contacts,
        mechanism.ends,
        mechanism.rubbing,
        mechanism.states,
    )
    result = {path: value for group in groups for part in group for path, value in numbers_in(part)}
    measures = [own.measure for own in mechanism.loads] + [own.measure for own in mechanism.ends]
    measures += [*mechanism.sensed, *(own.measure for own in mechanism.actuations.values())]
    if any(isinstance(measure, Distance) for measure in measures):
        result[NEAREST] = nearest_distance(mechanism)
    return result


def nearest_distance(mechanism: Mechanism) -> float:
    """Distance of two joints in metres that round-off may cause.

    Beside a length that all places have in common: the farthest point of every body, summed up.
    """
    places = [*mechanism.attachments.values(), mechanism.anchors]
    farthest = (
        max((abs(n.value) for p in some.values() for n in p), default=0.0) for some in places
    )
    return ROUND_OFF * sum(farthest)


def chosen_paths(topology: Topology) -> list[KeyPath]:
    """Parameters that the way of assembly gives: sides of blocks, whole turns of loads."""
    sides = [("side", b.index) for b in topology.solved_blocks if b.kind in SIDED]
    return [*sides, *(("turns", place) for place in wound_angles(topology.mechanism))]


def wound_angles(mechanism: Mechanism) -> dict[int, Turn]:
    """Angles that count from within half a turn at the start, where nothing says more.

    Those of loads come first, by number; then angles of two bodies that loads sense, then those
    that end.
    """
    loads = mechanism.loads
    felt = set(mechanism.wound)
    own = [(load.measure, load.measure in load.wound) for load in loads]
    two = {turn for turn in felt if turn.reference is not None}
    other = [(measure, measure in two) for measure in mechanism.sensed]
    ends = [(end.measure, True) for end in mechanism.ends]
    return {
        place: measure
        for place, (measure, counts) in enumerate([*own, *other, *ends])
        if isinstance(measure, Turn) and counts
    }


def definition_vector(mechanism: Mechanism, paths: Iterable[KeyPath]) -> NDArray[np.float64]:
    """Parameters of a kernel as the definition gives them: sides are 1, turns 0; shape (p,)."""
    result = definition_numbers(mechanism)
    usual = {"side": 1.0, "turns": 0.0}
    return np.array([result[p] if p in result else usual[str(p[0])] for p in paths], dtype=float)


Floats = NDArray[np.float64]

Fed = tuple[tuple[KeyPath, ...], ...]
"""For each number of a definition the paths of the parameters that it feeds."""


@dataclass(frozen=True, eq=False)
class Effects:
    """Derivatives by numbers of a definition."""

    fed: Fed  # what each of P numbers feeds
    # Derivatives of those parameters, those of one number after those of the other, shape (s,)
    slopes: Floats
    state: Floats  # derivatives of the initial coordinates and their rates, shape (2m, P)
    # Which slopes are knots of tables instead: those of a spline whose coefficients are the
    # derivatives that follow; shape (s,)
    knots: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.fed)

    def scaled(self, factors: Floats) -> Effects:
        """The same by numbers in other units, of which each is `factors` SI units, shape (P,)."""
        each = np.repeat(factors, [len(paths) for paths in self.fed])
        slopes = np.where(self.knots, self.slopes, self.slopes * each)
        return replace(self, slopes=slopes, state=self.state * factors)


def slots(fed: Sequence[Sequence[KeyPath]]) -> Iterator[tuple[int, KeyPath]]:
    """Number of a definition and path of a parameter, for each of the slopes."""
    return ((number, path) for number, paths in enumerate(fed) for path in paths)


_KEYS = frozenset(
    {
        "angle", "center", "cos", "damping", "dissipation", "exponent", "force", "friction",
        "inertia", "law", "least_rate", "length", "mass", "pin_radius", "points", "position",
        "profile", "ratio", "restitution", "sin", "size", "slip", "speed", "spline", "stiffness",
        "through", "torque",
    }
)  # fmt: skip


class Inputs:
    """Nodes of a graph for the arguments of a kernel; a state is n coordinates, then n rates."""

    def __init__(self, graph: ScalarGraph, coordinates: int, paths: Iterable[KeyPath] = ()) -> None:
        self.graph = graph
        self.coordinates = coordinates
        self.parameters = {path: place for place, path in enumerate(paths)}

    @property
    def time(self) -> Scalar:
        """Time in seconds."""
        return self.graph.input("t", 0, Level.TIME)

    def coordinate(self, index: int) -> Scalar:
        """Integrated coordinate `index`."""
        return self.graph.input("y", index, Level.STATE)

    def rate(self, index: int) -> Scalar:
        """Rate of integrated coordinate `index`."""
        return self.graph.input("y", self.coordinates + index, Level.STATE)

    def acceleration(self, index: int) -> Scalar:
        """Second derivative of coordinate `index`, known after the rates have been evaluated."""
        return self.graph.input("a", index, Level.STATE)

    def parameter(self, parameter: Parameter) -> Scalar:
        """A number of the definition file; a structural zero is the constant 0."""
        if parameter.absent:
            return self.graph.zero
        return self._placed(parameter.path)

    def vector(self, pair: tuple[Parameter, Parameter]) -> Vector:
        """Two numbers of the definition file."""
        return Vector(self.parameter(pair[0]), self.parameter(pair[1]))

    def side(self, block: int) -> Scalar:
        """The sign that selects the assembly branch of a block, +1 or −1."""
        return self._placed(("side", block))

    def turns(self, load: int) -> Scalar:
        """The multiple of 2π by which the difference of a spring's angles is too large at t = 0."""
        return self._placed(("turns", load))

    def slope(self, slot: int) -> Scalar:
        """Derivative of a parameter by a number of the definition, see `Effects.slopes`."""
        if ("slope", slot) in self.parameters:
            return self._placed(("slope", slot))
        return self.graph.input("slope", slot, Level.PARAMETERS)

    def fed(self, paths: Fed) -> list[dict[int, Scalar]]:
        """For each number of a definition the rates of the parameters that it feeds."""
        result: list[dict[int, Scalar]] = [{} for _ in paths]
        for slot, (number, path) in enumerate(slots(paths)):
            result[number][self._placed(path).index] = self.slope(slot)
        return result

    @property
    def nearest(self) -> Scalar:
        """Distance of a spring's ends below which it is round-off, in metres."""
        return self._placed(NEAREST)

    def mode(self, index: int) -> Scalar:
        """Mode of a switch, +1 or −1."""
        return self.graph.input("mode", index, Level.STATE)

    def memory(self, index: int) -> Scalar:
        """A number kept from the last time at which a switch rose."""
        return self.graph.input("memory", index, Level.STATE)

    def memory_tangent(self, index: int) -> Scalar:
        """Derivative of such a number along a tangent."""
        return self.graph.input("memory_tangent", index, Level.STATE)

    def iterate(self, index: int) -> Scalar:
        """An unknown within an iteration."""
        return self.graph.input("z", index, Level.STATE)

    def _placed(self, path: KeyPath) -> Scalar:
        return self.graph.input("p", self.parameters[path], Level.PARAMETERS)

    def describe(self) -> list[str]:
        """What each parameter is, with numbers in the place of the file's names."""
        numbers: dict[tuple[object, int], dict[object, int]] = {}
        return [_numbered_path(path, numbers) for path in self.parameters]


def _numbered_path(path: KeyPath, numbers: dict[tuple[object, int], dict[object, int]]) -> str:
    """A path without any text of the user, for comments of the generated code.

    Keys of a component stand second behind the section; anything elsewhere is a name.
    """
    section, *rest = path
    parts = [str(section)]
    for place, element in enumerate(rest):
        if isinstance(element, int) or (place == 1 and element in _KEYS):
            parts.append(str(element))
        else:
            family = numbers.setdefault((section, place), {})
            parts.append(f"#{family.setdefault(element, len(family))}")
    return ".".join(parts)


BOUNDED = ("sqrt", "log", "asin", "acos")
"""Operations that have no value for some operands, such as ``sqrt`` of a negative number."""


@dataclass(frozen=True)
class Law:
    """A function of time and its derivatives at time t."""

    value: Scalar
    rate: Scalar
    acceleration: Scalar


def _of_time_alone(found: Measured | Internal) -> Scalar:
    raise ValueError(f"a function of time does not depend on {found}")


def value_of(
    function: Function,
    inputs: Inputs,
    measured: Callable[[Measured | Internal], Scalar] = _of_time_alone,
    mode: Callable[[Function, Scalar], Scalar] = lambda _, node: node,
) -> Scalar:
    """The node of a function; at a jump or corner `mode` gives what tells both sides apart."""
    graph = inputs.graph
    match function:
        case Number(parameter):
            return inputs.parameter(parameter) if parameter.path else graph.number(parameter.value)
        case Time():
            return inputs.time
        case Measured() | Internal():
            return measured(function)
        case Table():
            over = value_of(function.over, inputs, measured, mode)
            if function.corners is not None:
                mode(function, _of_table(function.corners, over, inputs))
            return _of_table(function, over, inputs)
        case Operation("power", (base, Number(exponent))):
            result = COMPOSITE["power"].expanded
            base_value = value_of(base, inputs, measured, mode)
            return graph.lift(result(graph.apply, base_value, int(exponent.value)))
        case Operation(name, arguments):

            def unheld(part: Function, node: Scalar) -> Scalar:
                mode(part, node)
                return node

            # steps are tried beyond a change of mode, where what is held leaves their domain
            own = unheld if name in BOUNDED else mode
            values = [value_of(argument, inputs, measured, own) for argument in arguments]
            if name not in COMPOSITE:
                return graph.apply(name, *values)

            def apply(name: str, *operands: Scalar | float) -> Scalar:
                if name != "select":
                    return graph.apply(name, *operands)
                condition, first, second = map(graph.lift, operands)
                side = mode(function, condition)
                if _is_mode(side) and max(first.level, second.level) <= Level.PARAMETERS:
                    # affine, for where a motion sticks a mode stands for what lies between
                    return 0.5 * (first + second) + 0.5 * (first - second) * side
                return graph.select(side, first, second)

            return graph.lift(COMPOSITE[name].expanded(apply, *values))
        case _:
            assert_never(function)


def _is_mode(node: Scalar) -> bool:
    """Whether it is a mode, or one with a sign of its own (see `Switches.side`)."""
    if node.operation in ("neg", "mul", "select"):
        moving = [operand for operand in node.operands if operand.level > Level.PARAMETERS]
        return len(moving) == 1 and _is_mode(moving[0])
    return node.operation == "input" and bool(node.arguments[0] == "mode")


def _of_table(table: Table, over: Scalar, inputs: Inputs) -> Scalar:
    place = inputs.parameters[*table.path, "spline", 0]
    count = (len(table_numbers(table)) - 1) // 5
    return inputs.graph.spline(over, place, count, table.periodic)[0]


def law_of(function: Function, inputs: Inputs) -> Law:
    """The nodes of a function of time and of its derivatives."""
    value = value_of(function, inputs)
    ((rate,),) = derivative([value], [inputs.time])
    ((acceleration,),) = derivative([rate], [inputs.time])
    return Law(value, rate, acceleration)


def law_values(function: Function, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values of a function of time, of the shape of times; nan or infinite where it has none."""
    given = dict(numbers_in(function))
    node = value_of(function, Inputs(ScalarGraph(), 0, given))
    numbers = np.array(list(given.values()))
    (result,) = Evaluator([node])(t=times.reshape(1, -1), p=numbers)
    return np.broadcast_to(result, times.size).reshape(times.shape)
