"""Laws as nodes of a kernel's graph, with exact first and second derivatives."""

from __future__ import annotations

from collections.abc import Callable
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
from linkages.kernel.graph.differentiation import derivative
from linkages.kernel.graph.evaluator import Evaluator
from linkages.kernel.graph.scalars import Level, Scalar, ScalarGraph
from linkages.kernel.numbers.inputs import Inputs
from linkages.kernel.numbers.parameters import numbers_in, table_numbers
from linkages.operations import COMPOSITE

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
    function
        Of time, and of measures.
    inputs
        Arguments of the kernel.
    measured
        Values and rates of measures, and values of internal states.
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
    """Values of a function of time, shape (times,); nan or infinite where it has none."""
    given = dict(numbers_in(function))
    node = value_of(function, Inputs(ScalarGraph(), 0, given))
    numbers = np.array(list(given.values()))
    (found,) = Evaluator([node])(t=times[None, :], p=numbers)
    return np.broadcast_to(found, times.shape)
