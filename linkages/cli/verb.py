"""Commands that compute something of a mechanism: their flags, and the request that they make."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Collection, Sequence
from enum import Enum, StrEnum
from importlib import import_module
from inspect import Parameter
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

import typer

from linkages.cli.options import Figures, File, Format, Json, Out, Picture, Set, TablesFrom
from linkages.options.given import Option, options_in
from linkages.options.run import RunOptions
from linkages.spec.conversion import QuantityError
from linkages.spec.quantities import Count, FieldType, Quantity
from linkages.spec.tolerance_zones import has_tolerance

Command = Callable[..., None]

OF_FILE = "Simulation (default: what the file says under simulate)"
"""Heading in `--help` of what the definition file says as well."""

_SENTENCE = re.compile(r"\.(\s+(?=[A-Z])|$)")


def _common(
    file: File,
    assignments: Set = None,
    out: Out = None,
    json: Json = False,
    figures: Figures = True,
    form: Format = Picture.PNG,
    tables_from: TablesFrom = None,
) -> None:
    """Flags that all of these commands have."""


def computes(
    kind: type[RunOptions] | None = None, without: Collection[str] = ()
) -> Callable[[Callable[..., None]], Command]:
    """Make a command of its parameters and its docstring.

    It runs `run` of the module of its name in `linkages.cli.verbs`, which takes a `Request` and
    what else is given, and returns the exit code.

    Parameters
    ----------
    kind
        Its options, if it has any: each of them becomes a flag. The parameters are flags, too; one
        takes the place of an option of its name.
    without
        Flags that others have.
    """

    def made(function: Callable[..., None]) -> Command:
        verb = function.__name__.rstrip("_")

        def run(request: Any, **own: Any) -> int:
            code: int = import_module(f"linkages.cli.verbs.{verb}").run(request, **own)
            return code

        return command_of(verb, function.__doc__, _parameters(function), run, kind, without)

    return made


def command_of(
    verb: str,
    text: str | None,
    own: Sequence[Parameter],
    run: Callable[..., int],
    kind: type[RunOptions] | None = None,
    without: Collection[str] = (),
) -> Command:
    """The function that Typer makes a command of.

    Parameters
    ----------
    verb, text
        Its name and what `--help` says.
    own
        Its own flags.
    run
        What it does, given a `Request` and its own flags; returns the exit code.
    kind, without
        As `computes` takes them.
    """
    taken = {*without, *(parameter.name for parameter in own)}
    options = [flag for flag in _flags(kind) if flag.name not in taken] if kind else []
    common = [flag for flag in _parameters(_common) if flag.name not in taken]

    def command(**given: Any) -> None:
        from linkages.cli.requests import Request

        request = Request(
            verb=verb,
            file=given["file"],
            assignments=given["assignments"] or (),
            tables_from=given["tables_from"],
            out=given.get("out"),
            json=given["json"],
            figures=given.get("figures", False),
            format=given.get("form", Picture.PNG),
            kind=kind,
            given={f.name: _plain(given[f.name]) for f in options if given[f.name] is not None},
            own={flag.name: given[flag.name] for flag in own},
            flags={flag.name: flag.annotation for flag in own},
        ).again()
        raise typer.Exit(run(request, **request.own))

    command.__name__, command.__doc__ = verb, text
    parameters = sorted([*common, *own, *options], key=lambda p: p.default is not p.empty)
    command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    command.__annotations__ = {flag.name: flag.annotation for flag in parameters}
    return command


def _parameters(function: Callable[..., Any]) -> list[Parameter]:
    """Parameters by keyword, with their annotations as they are meant."""
    hints = get_type_hints(function, include_extras=True)
    return [
        parameter.replace(kind=Parameter.KEYWORD_ONLY, annotation=hints[name])
        for name, parameter in inspect.signature(function).parameters.items()
    ]


def _plain(value: Any) -> Any:
    """A word of an enumeration as text."""
    return value.value if isinstance(value, Enum) else value


def _flags(kind: type[RunOptions]) -> list[Parameter]:
    """Parameters of a command that has all options of a kind.

    Those that the definition file has as well come last, and are None unless they are given.
    """
    return [_flag(option) for option in options_in(kind)]


def _flag(option: Option) -> Parameter:
    value, default = option.value, option.default
    how: dict[str, Any] = {"metavar": option.form}
    if isinstance(option.rule, Count | Quantity):
        how = {"parser": reading(option.rule), "metavar": _metavar(option.rule)}
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


def reading(rule: FieldType) -> Callable[[Any], Any]:
    """Read a flag as the definition file is read: with arithmetic, and with a unit."""

    def read(text: Any) -> Any:
        if has_tolerance(text):
            raise typer.BadParameter(f"options have no tolerance, found {text!r}")
        try:
            return rule.read(text)
        except QuantityError as error:
            raise typer.BadParameter(str(error)) from None

    return read
