"""Commands that compute something of a mechanism, from functions of a request."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection
from enum import Enum
from inspect import Parameter
from typing import Any, get_type_hints

import typer

from linkages.cli.flags import flags
from linkages.cli.options import Figures, File, Format, Json, Out, Picture, Set
from linkages.options.run import RunOptions

Command = Callable[..., None]


def _common(
    file: File,
    assignments: Set = None,
    out: Out = None,
    json: Json = False,
    figures: Figures = True,
    form: Format = Picture.PNG,
) -> None:
    """Flags that all of these commands have."""


def computes(
    kind: type[RunOptions] | None = None, without: Collection[str] = ()
) -> Callable[[Callable[..., int]], Command]:
    """Make a command of a function that takes a `Request`, and returns the exit code.

    Parameters
    ----------
    kind
        Its options, if it has any: each of them becomes a flag, see `flags`. Further parameters of
        the function are flags, too; one takes the place of an option of its name.
    without
        Flags that others have.
    """

    def made(function: Callable[..., int]) -> Command:
        own = _parameters(function, {"Request": object})[1:]
        taken = {*without, *(parameter.name for parameter in own)}
        options = [flag for flag in flags(kind) if flag.name not in taken] if kind else []
        common = [flag for flag in _parameters(_common) if flag.name not in taken]
        named = {flag.name for flag in options}
        mine = [flag.name for flag in own]

        def command(**given: Any) -> None:
            from linkages.cli.requests import Request

            request = Request(
                verb=function.__name__.rstrip("_"),
                file=given["file"],
                assignments=given["assignments"] or (),
                out=given.get("out"),
                json=given["json"],
                figures=given.get("figures", False),
                format=given["form"],
                kind=kind,
                given={name: _plain(given[name]) for name in named if given[name] is not None},
                own={name: given[name] for name in mine},
            )
            raise typer.Exit(function(request, **request.own))

        command.__name__, command.__doc__ = function.__name__.rstrip("_"), function.__doc__
        parameters = sorted([*common, *own, *options], key=lambda p: p.default is not p.empty)
        command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        command.__annotations__ = {flag.name: flag.annotation for flag in parameters}
        return command

    return made


def _parameters(
    function: Callable[..., Any], known: dict[str, Any] | None = None
) -> list[Parameter]:
    """Parameters by keyword, with their annotations as they are meant."""
    hints = get_type_hints(function, localns=known, include_extras=True)
    return [
        parameter.replace(kind=Parameter.KEYWORD_ONLY, annotation=hints[name])
        for name, parameter in inspect.signature(function).parameters.items()
    ]


def _plain(value: Any) -> Any:
    """A word of an enumeration as text."""
    return value.value if isinstance(value, Enum) else value
