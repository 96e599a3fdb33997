"""Flags of options, from their fields: name, type, default and help stand there alone."""

from __future__ import annotations

import re
from collections.abc import Callable
from enum import StrEnum
from inspect import Parameter
from typing import Annotated, Any, Literal, get_args, get_origin

import typer

from linkages.options.given import Option, options_in
from linkages.options.run import RunOptions
from linkages.spec.conversion import QuantityError
from linkages.spec.quantities import Count, FieldType, Quantity

OF_FILE = "Simulation (default: what the file says under simulate)"
"""Heading in `--help` of what the definition file says as well."""

_SENTENCE = re.compile(r"\.(\s+(?=[A-Z])|$)")


def flags(kind: type[RunOptions]) -> list[Parameter]:
    """Parameters of a command that has all options of a kind.

    Those that the definition file has as well come last, and are None unless they are given.
    """
    return [_flag(option) for option in options_in(kind)]


def _flag(option: Option) -> Parameter:
    value, default = option.value, option.default
    how: dict[str, Any] = {"metavar": option.form}
    if isinstance(option.rule, Count | Quantity):
        how = {"parser": _reading(option.rule), "metavar": _metavar(option.rule)}
    elif get_origin(value) is Literal:
        value = _words(option.name, value)
    names = (f"--{option.name}",) if value is bool and default is False else ()
    sentence = _SENTENCE.split(option.text, maxsplit=1)[0].replace("`", "'")
    panel = OF_FILE if option.of_file else None
    text = f"{sentence}." if sentence else None  # python -OO has no docstrings
    flag = typer.Option(*names, help=text, rich_help_panel=panel, **how)
    kind = value | None if default is None else value
    return Parameter(
        option.name, Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[kind, flag]
    )


def _words(name: str, literal: Any) -> type[StrEnum]:
    """The words that may stand somewhere, as the enumeration that Typer wants."""
    made: Any = StrEnum  # mypy knows no enumerations whose words are computed
    found: type[StrEnum] = made(name.title(), {word.upper(): word for word in get_args(literal)})
    return found


def _metavar(rule: Count | Quantity) -> str:
    if isinstance(rule, Count):
        return "<int>"
    return f"<{rule.dimension.name}>" if rule.dimension.unit else "<float>"


def _reading(rule: FieldType) -> Callable[[Any], Any]:
    """Read a flag as the definition file is read: with arithmetic, and with a unit."""

    def read(text: Any) -> Any:
        try:
            return rule.read(text)
        except QuantityError as error:
            raise typer.BadParameter(str(error)) from None

    return read
