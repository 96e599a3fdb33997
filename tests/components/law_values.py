"""Evaluates functions of time in plain Python, for the tests of this folder."""

import math

from linkages.components.functions import Number, Operation, Time

OPERATIONS = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "power": lambda a, n: a ** int(n),
    "neg": lambda a: -a,
}


def value(function, t):
    """The value at a time."""
    if isinstance(function, Number):
        return function.parameter.value
    if isinstance(function, Time):
        return t
    assert isinstance(function, Operation)
    if function.name == "select":
        condition, first, second = function.arguments
        return value(first if value(condition, t) >= 0 else second, t)
    arguments = [value(argument, t) for argument in function.arguments]
    operation = OPERATIONS.get(function.name) or getattr(math, function.name)
    return operation(*arguments)


def parameters(function):
    """The numbers of the definition file in a function, each once, in their order."""
    if isinstance(function, Number):
        return [function.parameter] if function.parameter.path else []
    found = [p for argument in getattr(function, "arguments", ()) for p in parameters(argument)]
    return list(dict.fromkeys(found))
