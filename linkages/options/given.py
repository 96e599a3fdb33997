"""Options from keyword arguments, checked one by one with their names."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from functools import cache
from numbers import Real
from typing import Any, Literal, TypeVar, cast, get_args, get_origin, get_type_hints

from linkages.options.option import OptionError
from linkages.options.run import RunOptions, SimulationOptions
from linkages.reading.wording import listed, suggestion
from linkages.spec.annotations import alternatives, rule_of, stripped
from linkages.spec.quantities import Count, Quantity

Options = TypeVar("Options", bound=RunOptions)


def given_options(
    kind: type[Options], given: Mapping[str, Any], file: SimulationOptions
) -> Options:
    """Options of a run.

    Parameters
    ----------
    kind
        Their class.
    given
        Keyword arguments; None says nothing.
    file
        What the definition file says of how motions are integrated, and simulated.

    Raises
    ------
    OptionError
        For a value that makes no sense.
    TypeError
        For a name that is no option, and for a value of another type.
    """
    known = option_types(kind)
    for name in given:
        if name not in known:
            near = suggestion(name, known)
            raise TypeError(f"unexpected keyword argument {name!r}{near}")
    shared = SimulationOptions if issubclass(kind, SimulationOptions) else RunOptions
    said = {name: _read(name, known[name], value) for name, value in given.items()}
    defaults = {field.name: getattr(file, field.name) for field in fields(shared)}
    return kind(**defaults | {name: value for name, value in said.items() if value is not None})


def option_types(kind: type) -> Mapping[str, Any]:
    """Name of an option → its annotation."""
    return _types(cast(Any, kind))


@cache
def _types(kind: type) -> Mapping[str, Any]:
    hints = get_type_hints(kind, include_extras=True)
    return {field.name: hints[field.name] for field in fields(kind)}


def _read(name: str, annotation: Any, value: Any) -> Any:
    if value is None:
        return None
    (arm,) = alternatives(annotation)
    rule, kind = rule_of(arm), stripped(arm)
    if isinstance(rule, Count):
        number = whole_number(name, value)
        if number < rule.least:
            raise OptionError(name, f"{name} must be at least {rule.least}, found {value}")
        return number
    if isinstance(rule, Quantity):
        real = real_number(name, value)
        if not (math.isfinite(real) and rule.bound.holds(real)):
            limit = f"{rule.dimension.article} {rule.bound.value}".rstrip()
            raise OptionError(name, f"{name} must be {limit}, found {value}")
        return real
    if get_origin(kind) is Literal:
        if value not in get_args(kind):
            words = listed(map(repr, get_args(kind)))
            raise OptionError(name, f"{name} must be {words}, found {value!r}")
        return value
    if not isinstance(value, kind):
        word = {bool: "True or False", str: "text"}[kind]
        raise TypeError(f"{name} must be {word}, found {value!r}")
    return value


def whole_number(name: str, value: Any) -> int:
    """A whole number; 20.0 is one, and NumPy's are.

    Raises
    ------
    TypeError, OptionError
        For what is no number, or no whole one.
    """
    number = real_number(name, value)
    if not (math.isfinite(number) and number == int(number)):
        raise OptionError(name, f"{name} must be a whole number, found {value!r}")
    return int(number)


def real_number(name: str, value: Any) -> float:
    """A number.

    Raises
    ------
    TypeError
        For what is no number.
    """
    if not isinstance(value, Real) or isinstance(value, bool):
        raise TypeError(f"{name} must be a number, found {value!r}")
    return float(value)
