"""Functions of time as nodes of a kernel's graph, with exact first and second derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from linkages.components.functions import ONE_ARGUMENT, Function, Number, Operation, Table, Time
from linkages.kernel.differentiation import derivative
from linkages.kernel.evaluator import Evaluator
from linkages.kernel.inputs import Inputs
from linkages.kernel.parameters import numbers_in, table_numbers
from linkages.kernel.scalars import Scalar, ScalarGraph


@dataclass(frozen=True)
class Law:
    """A function of time and its derivatives at time t."""

    value: Scalar
    rate: Scalar
    acceleration: Scalar


def value_of(function: Function, inputs: Inputs) -> Scalar:
    """The node of a function of time."""
    graph = inputs.graph
    match function:
        case Number(parameter):
            return inputs.parameter(parameter) if parameter.path else graph.number(parameter.value)
        case Time():
            return inputs.time
        case Table():
            place = inputs.parameters[*function.path, "spline", 0]
            count = (len(table_numbers(function)) - 1) // 5
            return graph.spline(inputs.time, place, count, function.periodic)[0]
        case Operation(name, arguments):
            return _operation(name, arguments, inputs)
        case _:
            assert_never(function)


def _operation(name: str, arguments: tuple[Function, ...], inputs: Inputs) -> Scalar:
    graph = inputs.graph
    if name == "power":
        base, exponent = arguments
        assert isinstance(exponent, Number)
        return _power(value_of(base, inputs), int(exponent.parameter.value))
    values = [value_of(argument, inputs) for argument in arguments]
    match name, values:
        case "add", (a, b):
            return a + b
        case "sub", (a, b):
            return a - b
        case "mul", (a, b):
            return a * b
        case "div", (a, b):
            return a / b
        case "neg", (a,):
            return -a
        case "select", (c, a, b):
            return graph.select(c, a, b)
        case _, (a,) if name in ONE_ARGUMENT:
            return graph.function(name, a)
    raise ValueError(f"no operation {name!r} in a function of time")


def _power(base: Scalar, exponent: int) -> Scalar:
    """A whole power by repeated squaring."""
    if exponent < 0:
        return 1.0 / _power(base, -exponent)
    result = base.graph.one
    while exponent:
        if exponent % 2:
            result = result * base
        base, exponent = base * base, exponent // 2
    return result


def law_of(function: Function, inputs: Inputs) -> Law:
    """The nodes of a function of time and of its derivatives."""
    value = value_of(function, inputs)
    ((rate,),) = derivative([value], [inputs.time], inputs.graph.section)
    ((acceleration,),) = derivative([rate], [inputs.time], inputs.graph.section)
    return Law(value, rate, acceleration)


def law_values(function: Function, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values of a function of time, shape (times,); nan or infinite where it has none."""
    given = dict(numbers_in(function))
    node = value_of(function, Inputs(ScalarGraph(), 0, given))
    numbers = np.array(list(given.values()))
    (found,) = Evaluator([node])(t=times[None, :], p=numbers)
    return np.broadcast_to(found, times.shape)
