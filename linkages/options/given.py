"""Options from keyword arguments, checked one by one with their names."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cache
from numbers import Real
from typing import Any, Literal, TypeVar, cast, get_args, get_origin, get_type_hints

from linkages.options.option import OptionError
from linkages.options.run import FORM, RunOptions, SimulationOptions
from linkages.reading.wording import listed, suggestion
from linkages.spec.annotations import alternatives, rule_of, stripped
from linkages.spec.docstrings import field_texts
from linkages.spec.quantities import Count, FieldType, Quantity

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
    known = {option.name: option for option in options_in(kind)}
    for name in given:
        if name not in known:
            near = suggestion(name, known)
            raise TypeError(f"unexpected keyword argument {name!r}{near}")
    defaults = {name: getattr(file, name) for name, option in known.items() if option.of_file}
    said = {name: value for name, value in given.items() if value is not None}
    return kind(**defaults | {name: _read(known[name], value) for name, value in said.items()})


@dataclass(frozen=True, kw_only=True)
class Option:
    """What is known of a field of options.

    Parameters
    ----------
    name, text
        As the class has it, and what its docstring says.
    value
        Type of the value, without None.
    rule
        How numbers and texts are read, if there is a rule.
    default
        None where the definition file says it.
    form
        What a text looks like.
    of_file
        Whether the definition file has it as well.
    """

    name: str
    text: str
    value: Any
    rule: FieldType | None
    default: Any
    form: str | None
    of_file: bool


def options_in(kind: type[RunOptions]) -> list[Option]:
    """All options of a kind; those that the definition file has as well come last."""
    return _options(cast(Any, kind))


@cache
def _options(kind: type[RunOptions]) -> list[Option]:
    hints, texts = get_type_hints(kind, include_extras=True), field_texts(cast(Any, kind))
    said = SimulationOptions if issubclass(kind, SimulationOptions) else RunOptions
    of_file = {field.name for field in fields(said)}
    found = []
    for field in sorted(fields(kind), key=lambda field: field.name in of_file):
        (arm,) = alternatives(hints[field.name])
        found.append(
            Option(
                name=field.name,
                text=texts.get(field.name, ""),
                value=stripped(arm),
                rule=rule_of(arm),
                default=None if field.name in of_file else field.default,
                form=field.metadata.get(FORM),
                of_file=field.name in of_file,
            )
        )
    return found


def _read(option: Option, value: Any) -> Any:
    name, rule, kind = option.name, option.rule, option.value
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
