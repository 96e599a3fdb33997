"""Evaluates laws in plain Python, for the tests of this folder."""

import math

from linkages.components.contributed.functions import Measured, Number, Operation, Time

OPERATIONS = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "power": lambda a, n: a ** int(n),
    "neg": lambda a: -a,
    "abs": abs,
    "min": min,
    "max": max,
    "sign": lambda a: 1.0 if a >= 0 else -1.0,
}


def value(function, t, x=0.0, v=0.0):
    """The value at a time, and where a load has the value x and the rate v."""
    if isinstance(function, Number):
        return function.parameter.value
    if isinstance(function, Time):
        return t
    if isinstance(function, Measured):
        return v if function.order else x
    assert isinstance(function, Operation)
    if function.name in ("select", "where"):
        condition, first, second = function.arguments
        return value(first if value(condition, t, x, v) >= 0 else second, t, x, v)
    arguments = [value(argument, t, x, v) for argument in function.arguments]
    operation = OPERATIONS.get(function.name) or getattr(math, function.name)
    return operation(*arguments)


def parameters(function):
    """The numbers of the definition file in a function, each once, in their order."""
    if isinstance(function, Number):
        return [function.parameter] if function.parameter.path else []
    found = [p for argument in getattr(function, "arguments", ()) for p in parameters(argument)]
    return list(dict.fromkeys(found))
