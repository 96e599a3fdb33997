"""Commands of analyses that are found by themselves: flags, files and a table from a function."""

from __future__ import annotations

import inspect
from inspect import Parameter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from linkages.analyses import Analysis, analyses
from linkages.cli.options import File, Json, Out, Set

if TYPE_CHECKING:
    import xarray as xr

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
    common = inspect.signature(_common, eval_str=True).parameters.values()

    def command(**given: Any) -> None:
        own = {option.name: given.pop(option.name) for option in options}
        raise typer.Exit(_run(verb, analysis, own, **given))

    command.__doc__ = (analysis.__doc__ or "").strip().partition("\n")[0]
    flags = [flag.replace(kind=Parameter.KEYWORD_ONLY) for flag in common]
    command.__signature__ = inspect.Signature([*flags, *options])  # type: ignore[attr-defined]
    command.__annotations__ = {flag.name: flag.annotation for flag in [*flags, *options]}
    app = typer.Typer(add_completion=False, rich_markup_mode="rich")
    app.command(verb)(command)
    return typer.main.get_command(app)


def _common(file: File, assignments: Set = None, out: Out = None, json: Json = False) -> None:
    """Flags that all of these commands have."""


def _kind(parameter: Parameter) -> type | None:
    given = parameter.annotation
    words = (given if isinstance(given, str) else inspect.formatannotation(given)).split(" | ")
    return KINDS.get(words[0]) if words[1:] in ([], ["None"]) else None


def _flag(parameter: Parameter, text: str) -> Parameter:
    kind: Any = _kind(parameter)
    if parameter.default is None:
        kind = kind | None
    return parameter.replace(annotation=Annotated[kind, typer.Option(help=text)])


def _run(
    verb: str,
    analysis: Analysis,
    own: dict[str, Any],
    file: str,
    assignments: list[str] | None,
    out: Path | None,
    json: bool,
) -> int:
    from rich.markup import escape

    from linkages.cli.loading import mechanism_from, require_folder
    from linkages.cli.published import published
    from linkages.cli.results import save_netcdf, save_table
    from linkages.cli.terminal import console, number, print_json, print_notes, table
    from linkages.errors import InputError, Problem

    mechanism = mechanism_from(file, assignments or [])
    folder = Path("results") / Path(file).stem if out is None else out
    require_folder(folder)
    try:
        data = analysis(mechanism, **own)
    except ValueError as error:
        raise InputError(file, [Problem(message=str(error))]) from None
    columns = _columns(data)
    with published(verb, folder, mechanism, own) as run:
        save_netcdf(data, run.folder / f"{verb}.nc")
        save_table(columns, run.folder / f"{verb}.csv")
    rows = list(zip(*columns.values(), strict=True))
    warning = str(data.attrs.get("warning", ""))
    if json:
        print_json(
            {
                "mechanism": mechanism.name,
                "rows": [dict(zip(columns, row, strict=True)) for row in rows],
                "warning": warning or None,
                "files": [str(path) for path in run.files],
            }
        )
        return 0
    screen = console()
    cells = [[c if isinstance(c, str) else number(c) for c in row] for row in rows]
    screen.print(table(escape(mechanism.name), list(columns), cells, numbers=len(columns) - 1))
    print_notes([warning] if warning else [], screen)
    screen.print(f"{len(run.files)} files in {folder}", markup=False)
    return 0


def _columns(data: xr.Dataset) -> dict[str, list[Any]]:
    """Head → column of a table with a row for each place; dimensions first."""
    frame = data.to_dataframe().reset_index()
    units = {str(name): array.attrs.get("units", "1") for name, array in data.data_vars.items()}
    return {
        f"{name} ({units[name]})" if units.get(name, "1") != "1" else str(name): list(column)
        for name, column in frame.items()
    }
