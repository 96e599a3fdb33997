"""Commands of analyses that are found by themselves: flags, files and a table from a function."""

from __future__ import annotations

import inspect
from functools import partial
from inspect import Parameter
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from linkages.analyses import Analysis, analyses
from linkages.cli.verb import command_of

if TYPE_CHECKING:
    import xarray as xr
    from rich.console import Console

    from linkages.cli.requests import Request

KINDS = {"int": int, "float": float, "str": str, "bool": bool}
"""Types of options, as annotations have them."""


class WithFound(TyperGroup):
    """Commands of the program, then those found; these are looked for if no other is meant."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Names, for ``--help``."""
        return [*super().list_commands(ctx), *(_verb(name) for name in analyses())]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """The command of that name, if there is one."""
        known = super().get_command(ctx, cmd_name)
        if known is not None:
            return known
        found = {_verb(name): analysis for name, analysis in analyses().items()}
        return _command(cmd_name, found[cmd_name]) if cmd_name in found else None

    def invoke(self, ctx: Any) -> Any:
        """Run a command; what is wrong with its options is said without the words of pydantic."""
        try:
            return super().invoke(ctx)
        except typer.BadParameter as error:
            error.message = error.message.removeprefix("Value error, ")
            raise


def _verb(name: str) -> str:
    return name.replace("_", "-")


def _command(verb: str, analysis: Analysis) -> Any:
    """The command of an analysis: its options are flags, and its docstring is the help."""
    from linkages.spec.docstrings import field_texts

    texts = field_texts(analysis)
    options = [
        _flag(parameter, texts.get(parameter.name, ""))
        for parameter in inspect.signature(analysis).parameters.values()
        if parameter.kind is Parameter.KEYWORD_ONLY and _kind(parameter) is not None
    ]
    text = (analysis.__doc__ or "").strip().partition("\n")[0]
    run = partial(_run, analysis)
    app = typer.Typer(add_completion=False, rich_markup_mode="rich")
    app.command(verb)(command_of(verb, text, options, run, without=("figures", "form")))
    return typer.main.get_command(app)


def _kind(parameter: Parameter) -> type | None:
    given = parameter.annotation
    words = (given if isinstance(given, str) else inspect.formatannotation(given)).split(" | ")
    return KINDS.get(words[0]) if words[1:] in ([], ["None"]) else None


def _flag(parameter: Parameter, text: str) -> Parameter:
    kind: Any = _kind(parameter)
    if parameter.default is None:
        kind = kind | None
    return parameter.replace(annotation=Annotated[kind, typer.Option(help=text)])


def _run(analysis: Analysis, request: Request, **own: Any) -> int:
    from linkages.cli.terminal import print_notes, table
    from linkages.errors import InputError, Problem

    mechanism = request.mechanism
    try:
        data = analysis(mechanism, **own)
    except ValueError as error:
        raise InputError(request.file, [Problem(message=str(error))]) from None
    columns = _columns(data)
    files = request.write([(request.verb, data), (request.verb, columns)])
    rows = list(zip(*columns.values(), strict=True))
    warning = str(data.attrs.get("warning", ""))

    def show(screen: Console) -> None:
        screen.print(table(mechanism.name, list(columns), rows, numbers=len(columns) - 1))
        print_notes([warning] if warning else [], screen)

    content = {
        "mechanism": mechanism.name,
        "rows": [dict(zip(columns, row, strict=True)) for row in rows],
        "warning": warning or None,
    }
    return request.report(content, files, show)


def _columns(data: xr.Dataset) -> dict[str, list[Any]]:
    """Head → column of a table with a row for each place; dimensions first."""
    frame = data.to_dataframe().reset_index()
    units = {str(name): array.attrs.get("units", "1") for name, array in data.data_vars.items()}
    return {
        f"{name} ({units[name]})" if units.get(name, "1") != "1" else str(name): list(column)
        for name, column in frame.items()
    }
