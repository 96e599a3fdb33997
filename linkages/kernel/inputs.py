"""The arguments of a kernel (parameters, time, state) and laws as nodes of its graph."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.functions import (
    Function,
    Internal,
    Measured,
    Number,
    Operation,
    Table,
    Time,
)
from linkages.components.contributed.terms import Parameter
from linkages.kernel.differentiation import Evaluator, derivative
from linkages.kernel.parameters import NEAREST, Fed, numbers_in, slots, table_numbers
from linkages.kernel.scalars import Level, Scalar, ScalarGraph, Vector
from linkages.operations import COMPOSITE
from linkages.reading.paths import KeyPath

_KEYS = frozenset(
    {
        "angle", "center", "damping", "dissipation", "exponent", "force", "friction", "inertia",
        "law", "least_rate", "length", "mass", "pin_radius", "points", "position", "ratio",
        "restitution", "size", "slip", "speed", "spline", "stiffness", "through", "torque",
    }
)  # fmt: skip


class Inputs:
    """Nodes of a graph for the arguments of a kernel.

    Parameters
    ----------
    graph
        The graph that gets the input nodes.
    coordinates
        Number of integrated coordinates n; the state is n coordinates, then n rates.
    paths
        Path of each entry of the parameter array.

    Attributes
    ----------
    parameters
        Path → its place in the parameter array.
    """

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
        """The sign that selects the assembly mode of a block, +1 or −1."""
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
        found: list[dict[int, Scalar]] = [{} for _ in paths]
        for slot, (number, path) in enumerate(slots(paths)):
            found[number][self._placed(path).index] = self.slope(slot)
        return found

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
        numbers: dict[tuple, int] = {}
        return [_numbered_path(path, numbers) for path in self.parameters]


def _numbered_path(path: KeyPath, numbers: dict[tuple, int]) -> str:
    """A path without any text of the user, for comments of the generated code.

    Keys of a component stand second behind the section; whatever stands elsewhere is a name, even
    if it reads like a key.
    """
    section, *rest = path
    parts = [str(section)]
    for place, element in enumerate(rest):
        if isinstance(element, int) or (place == 1 and element in _KEYS):
            parts.append(str(element))
        else:
            family = [key for key in numbers if key[:2] == (section, place)]
            parts.append(f"#{numbers.setdefault((section, place, element), len(family))}")
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
    """The node of a function.

    Parameters
    ----------
    mode
        Part of the function and a node in it, at whose zero the part has a jump or a corner → what
        tells both sides apart; the node itself if not given.
    """
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
            found = COMPOSITE["power"].expanded
            base_value = value_of(base, inputs, measured, mode)
            return graph.lift(found(graph.apply, base_value, int(exponent.value)))
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
    (found,) = Evaluator([node])(t=times.reshape(1, -1), p=numbers)
    return np.broadcast_to(found, times.size).reshape(times.shape)
