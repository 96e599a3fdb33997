"""Flags of options, from their fields: name, type, default and help stand there alone."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import Field, fields
from enum import StrEnum
from inspect import Parameter
from typing import Annotated, Any, Literal, Optional, cast, get_args, get_origin

import typer

from linkages.options.given import option_types
from linkages.options.run import FORM, RunOptions, SimulationOptions
from linkages.spec.annotations import alternatives, rule_of, stripped
from linkages.spec.conversion import QuantityError
from linkages.spec.docstrings import field_texts
from linkages.spec.quantities import Count, FieldType, Quantity

OF_FILE = "Simulation (default: what the file says under simulate)"
"""Heading in `--help` of what the definition file says as well."""

_SENTENCE = re.compile(r"\.(\s+(?=[A-Z])|$)")


def flags(kind: type[RunOptions]) -> list[Parameter]:
    """Parameters of a command that has all options of a kind.

    Those that the definition file has as well come last, and are None unless they are given.
    """
    texts, types = field_texts(cast(Any, kind)), option_types(kind)
    said = SimulationOptions if issubclass(kind, SimulationOptions) else RunOptions
    of_file = {field.name for field in fields(said)}
    return [
        _flag(field, types[field.name], texts.get(field.name, ""), field.name in of_file)
        for field in sorted(fields(kind), key=lambda field: field.name in of_file)
    ]


def _flag(field: Field[Any], annotation: Any, text: str, of_file: bool) -> Parameter:
    (arm,) = alternatives(annotation)
    rule, value = rule_of(arm), stripped(arm)
    default = None if of_file else field.default
    how: dict[str, Any] = {"metavar": field.metadata.get(FORM)}
    if isinstance(rule, Count | Quantity):
        how = {"parser": _reading(rule), "metavar": _metavar(rule)}
    elif get_origin(value) is Literal:
        value = _words(field.name, value)
    names = (f"--{field.name}",) if value is bool and default is False else ()
    sentence = _SENTENCE.split(text, maxsplit=1)[0].replace("`", "'")
    panel = OF_FILE if of_file else None
    option = typer.Option(*names, help=f"{sentence}.", rich_help_panel=panel, **how)
    kind = Optional[value] if default is None else value  # noqa: UP045  # value is no type to mypy
    return Parameter(
        field.name, Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[kind, option]
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
