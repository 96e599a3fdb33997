"""Functions of time as nodes of a kernel's graph, with exact first and second derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from linkages.components.functions import Function, Number, Operation, Table, Time
from linkages.components.interpolation import polynomials
from linkages.kernel.differentiation import derivative
from linkages.kernel.evaluator import Evaluator
from linkages.kernel.inputs import Inputs
from linkages.kernel.scalars import Scalar, ScalarGraph
from linkages.operations import COMPOSITE


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
            numbers = table_numbers(function)
            place = inputs.block((*function.path, "spline"), numbers)
            count = (len(numbers) - 1) // 5
            return graph.spline(inputs.time, place, count, function.periodic)[0]
        case Operation("power", (base, Number(exponent))):
            found = COMPOSITE["power"].expanded
            return graph.lift(found(graph.apply, value_of(base, inputs), int(exponent.value)))
        case Operation(name, arguments):
            return graph.apply(name, *(value_of(argument, inputs) for argument in arguments))
        case _:
            assert_never(function)


def law_of(function: Function, inputs: Inputs) -> Law:
    """The nodes of a function of time and of its derivatives."""
    value = value_of(function, inputs)
    ((rate,),) = derivative([value], [inputs.time])
    ((acceleration,),) = derivative([rate], [inputs.time])
    return Law(value, rate, acceleration)


def table_numbers(table: Table) -> list[float]:
    """Knots, then four coefficients for each interval, the cubic one first."""
    found = polynomials(table)
    return [*map(float, found.x), *(float(c) for column in found.c.T for c in column)]


def law_values(function: Function, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values of a function of time, shape (times,); nan or infinite where it has none."""
    inputs = Inputs(ScalarGraph(), 0)
    node = value_of(function, inputs)
    numbers = np.array(list(inputs.parameters.values()))
    (found,) = Evaluator([node])(t=times[None, :], p=numbers)
    return np.broadcast_to(found, times.shape)
