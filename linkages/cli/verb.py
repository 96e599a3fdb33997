"""Flags, and commands as functions of a mechanism, built in or registered."""

from __future__ import annotations

import inspect
import os
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import copy
from enum import StrEnum
from functools import partial
from importlib import import_module
from inspect import Parameter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args, get_origin, get_type_hints

import typer
from typer.core import TyperCommand, TyperGroup

from linkages.options.option import Option, options_in
from linkages.options.run import RunOptions
from linkages.spec.conversion import QuantityError, has_tolerance
from linkages.spec.quantities import Count, FieldType, Quantity

if TYPE_CHECKING:
    import xarray as xr

    from linkages.analyses import Analysis
    from linkages.cli.requests import Request

SUFFIXES = (".yaml", ".yml")


def complete_file(incomplete: str) -> list[str]:
    """Definition files and folders that begin as given, then shipped mechanisms."""
    from linkages.reading.document import shipped

    return [*_paths(incomplete), *(name for name in shipped() if name.startswith(incomplete))]


def _paths(incomplete: str) -> list[str]:
    folder, begun = os.path.split(incomplete)
    try:
        entries = sorted(Path(folder or ".").expanduser().iterdir())
    except OSError:
        return []
    return [
        os.path.join(folder, entry.name) + (os.sep if entry.is_dir() else "")
        for entry in entries
        if entry.name.startswith(begun)
        and (entry.name.startswith(".") <= begun.startswith("."))
        and (entry.is_dir() or entry.suffix in SUFFIXES)
    ]


OF_FILE = "Simulation (default: the section simulate of the file)"
"""Heading in `--help` of what the definition file says as well."""

IN_AND_OUT = "Input and output"
HEADINGS = ("Arguments", "Options", OF_FILE, IN_AND_OUT)

File = Annotated[
    str,
    typer.Argument(
        metavar="FILE",
        help="A definition file, or the name of a shipped mechanism.",
        autocompletion=complete_file,
    ),
]
Set = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="PATH=VALUE",
        help="Use another value, e.g. clearances.r1.size=0.1mm.",
        rich_help_panel=IN_AND_OUT,
    ),
]
TablesFrom = Annotated[
    Path | None,
    typer.Option(
        "--tables-from",
        metavar="DIR",
        help="Read files of tables below this folder, too; default: below that of FILE.",
        rich_help_panel=IN_AND_OUT,
    ),
]
At = Annotated[
    str | None,
    typer.Option(
        metavar="LABEL",
        help="Of a file of branches, follow.nc: start at this point, e.g. PD1.",
        rich_help_panel=IN_AND_OUT,
    ),
]
Json = Annotated[
    bool,
    typer.Option(
        "--json", help="Print one JSON object and nothing else.", rich_help_panel=IN_AND_OUT
    ),
]
Out = Annotated[
    Path | None,
    typer.Option(
        "--out",
        metavar="DIR",
        help="Folder for results; default: results/<file stem>.",
        rich_help_panel=IN_AND_OUT,
    ),
]
Figures = Annotated[bool, typer.Option(help="Draw figures.", rich_help_panel=IN_AND_OUT)]


Picture = Literal["png", "svg", "pdf"]
Format = Annotated[
    Picture,
    typer.Option(
        "--format", help="Of figures; svg and pdf are vectors.", rich_help_panel=IN_AND_OUT
    ),
]
Template = Literal["slider-crank", "four-bar", "nine-bar", "empty"]


class Page(StrEnum):
    """Formats of reports; lists need an enumeration."""

    HTML = "html"
    PDF = "pdf"


Command = Callable[..., None]


_SAID = re.compile(r"^(--[\w-]+)(?: (\S+))?  (.+(?:\n    .+)*)", re.M)
"""What a docstring says of a flag: its name, the form of its value, and its help."""

_EXAMPLE = re.compile(r"^\$ (.+(?:\n    +.+)*)$", re.M)
"""A command line of a docstring."""

_SENTENCE = re.compile(r"\.(\s+(?=[A-Z])|$)")


def _common(
    file: File,
    assignments: Set = None,
    out: Out = None,
    json: Json = False,
    figures: Figures = True,
    form: Format = "png",
    tables_from: TablesFrom = None,
    at: At = None,
) -> None:
    """Flags that all of these commands have."""


def computes(
    module: str, kind: type[RunOptions] | None = None, without: Collection[str] = ()
) -> Callable[[Callable[..., None]], Command]:
    """Make a command of its parameters and its docstring, as `documented` takes them.

    It runs `run_NAME` of the module in `linkages.cli.verbs`, which takes a `Request` and what else
    is given, and returns the exit code. Options of the `kind` are flags, too, unless a
    parameter has the same name, and those that all have but `without` these.
    """

    def made(function: Callable[..., None]) -> Command:
        verb = function.__name__.rstrip("_")
        own = _declared(function)
        return _with_examples(command_of(verb, *own, _later(module, verb), kind, without), function)

    return made


def _later(module: str, verb: str) -> Callable[..., int]:
    """What a command does, of a module that is imported when it runs."""

    def run(*request: Any, **own: Any) -> int:
        room = import_module(f"linkages.cli.verbs.{module}")
        code: int = getattr(room, f"run_{verb}")(*request, **own)
        return code

    return run


def command_of(
    verb: str,
    text: str | None,
    own: Sequence[Parameter],
    run: Callable[..., int],
    kind: type[RunOptions] | None = None,
    without: Collection[str] = (),
) -> Command:
    """The function that Typer makes a command of, with its own flags and those of `computes`."""
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
            at=given.get("at"),
            out=given.get("out"),
            json=given["json"],
            figures=given.get("figures", False),
            format=given.get("form", "png"),
            kind=kind,
            given={f.name: given[f.name] for f in options if given[f.name] is not None},
            own={flag.name: given[flag.name] for flag in own},
            flags={flag.name: flag.annotation for flag in own},
        ).again()
        raise typer.Exit(run(request, **request.own))

    parameters = sorted([*common, *own, *options], key=lambda p: p.default is not p.empty)
    return _named(command, verb, text, parameters)


def _named(
    command: Command, verb: str, text: str | None, parameters: Sequence[Parameter]
) -> Command:
    """A function of keywords as Typer takes it."""
    command.__name__, command.__doc__ = verb, text
    command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    command.__annotations__ = {flag.name: flag.annotation for flag in parameters}
    return command


def documented(module: str) -> Callable[[Callable[..., None]], Command]:
    """Make a command of its parameters alone, with the help that its docstring has of them."""

    def made(function: Callable[..., None]) -> Command:
        verb = function.__name__.rstrip("_")

        def command(**given: Any) -> None:
            raise typer.Exit(_later(module, verb)(**given))

        return _with_examples(_named(command, verb, *_declared(function)), function)

    return made


def _with_examples(command: Command, function: Callable[..., Any]) -> Command:
    """The command with the examples of the docstring, for its help."""
    command.examples = _EXAMPLE.findall(inspect.getdoc(function) or "")  # type: ignore[attr-defined]
    return command


def _declared(function: Callable[..., Any]) -> tuple[str | None, list[Parameter]]:
    """The first paragraph of a docstring, and parameters as flags with what it says of them."""
    summary, _, rest = (inspect.getdoc(function) or "").partition("\n\n")
    said = {name: (form, " ".join(text.split())) for name, form, text in _SAID.findall(rest)}
    flags = [_with_help(parameter, said) for parameter in _parameters(function)]
    return summary or None, flags


def _with_help(
    parameter: Parameter, said: Mapping[str, tuple[str, str]], switch: bool = True
) -> Parameter:
    """A flag with its form and its help; a `switch` that is off by default has no opposite."""
    kind, given = parameter.annotation, typer.Option()
    if get_origin(kind) is Annotated:
        kind, given = get_args(kind)
    own = given.default is not ...  # Typer has the name of an annotation there
    name = given.default if own else f"--{parameter.name.replace('_', '-')}"
    alone = switch and kind is bool and parameter.default is False and not own
    if name not in said and not alone:
        return parameter
    flag, (form, text) = copy(given), said.get(name, ("", None))
    flag.metavar, flag.help = form or None, text
    if alone:
        flag.param_decls = (name,)
    return parameter.replace(annotation=Annotated[kind, flag])


def _parameters(function: Callable[..., Any]) -> list[Parameter]:
    """Parameters by keyword, with their annotations as they are meant."""
    hints = get_type_hints(function, include_extras=True)
    return [
        parameter.replace(kind=Parameter.KEYWORD_ONLY, annotation=hints[name])
        for name, parameter in inspect.signature(function).parameters.items()
    ]


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
    names = (f"--{option.name}",) if value is bool and default is False else ()
    sentence = _SENTENCE.split(option.text, maxsplit=1)[0].replace("`", "'")
    panel = OF_FILE if option.of_file else None
    text = f"{sentence}." if sentence else None  # python -OO has no docstrings
    flag = typer.Option(*names, help=text, rich_help_panel=panel, **how)
    kind = value | None if default is None else value
    return Parameter(
        option.name, Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[kind, flag]
    )


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


KINDS = {"int": int, "float": float, "str": str, "bool": bool}
"""Types of options, as annotations have them."""


UsageError: type[Exception] = typer.BadParameter.__bases__[0]


@contextmanager
def _errors_of(name: str) -> Iterator[None]:
    """Errors of options read as those of files do: ``name: 1 problem``, and what it is."""
    from linkages.errors import InputError, Problem

    try:
        yield
    except UsageError as error:
        where, message = getattr(error, "ctx", None), error.format_message()  # type: ignore[attr-defined]
        message = message.replace("Value error, ", "").removesuffix(".")
        raise InputError(where.info_name if where else name, [Problem(message=message)]) from None


class Verb(TyperCommand):
    """A command whose help has its options under headings, then its examples."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Options under the headings that they name."""
        records: dict[str, list[tuple[str, str]]] = {}
        for flag in self.get_params(ctx):
            usual = "Arguments" if flag.param_type_name == "argument" else "Options"
            heading = getattr(flag, "rich_help_panel", None) or usual
            if (record := flag.get_help_record(ctx)) is not None:
                records.setdefault(heading, []).append(record)
        for heading in sorted(records, key=HEADINGS.index):
            with formatter.section(heading):
                formatter.write_dl(records[heading])

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        """Examples, which stay on their lines."""
        examples = getattr(ctx.command.callback, "examples", ())
        if examples:
            with formatter.section("Examples"):
                lines = [line for example in examples for line in example.splitlines()]
                formatter.write("".join(f"  {line}\n" for line in lines))


class Verbs(TyperGroup):
    """Commands of the program, then those found; these are looked for if no other is meant."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Names, for ``--help``."""
        return [*super().list_commands(ctx), *_found()]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """The command of that name, if there is one."""
        known = super().get_command(ctx, cmd_name)
        if known is not None:
            return known
        result = _found()
        return _command(cmd_name, result[cmd_name]) if cmd_name in result else None

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Commands under the headings that they name."""
        records: dict[str, list[tuple[str, str]]] = {}
        for name in self.list_commands(ctx):
            command = self.get_command(ctx, name)
            if command.hidden:
                continue
            heading = getattr(command, "rich_help_panel", None)
            heading = heading if isinstance(heading, str) else "Analyse"
            records.setdefault(heading, []).append((name, command.get_short_help_str(200)))
        for heading, rows in records.items():
            with formatter.section(heading):
                formatter.write_dl(rows)

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Options before the command."""
        with _errors_of("linkages"):
            return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        with _errors_of("linkages"):
            return super().invoke(ctx)


def _found() -> dict[str, Analysis]:
    """Command → analysis of those that are found by themselves."""
    from linkages.analyses import analyses

    return {name.replace("_", "-"): analysis for name, analysis in analyses().items()}


def _command(verb: str, analysis: Analysis) -> Any:
    """The command of an analysis: its options are flags, and its docstring is the help."""
    from linkages.spec.models import field_texts

    texts = field_texts(analysis).items()
    said = {f"--{name.replace('_', '-')}": ("", text) for name, text in texts}
    options = [
        _with_help(parameter.replace(annotation=kind), said, switch=False)
        for parameter in inspect.signature(analysis).parameters.values()
        if parameter.kind is Parameter.KEYWORD_ONLY and (kind := _kind(parameter)) is not None
    ]
    text = (analysis.__doc__ or "").strip().partition("\n")[0]
    run = partial(_run, analysis)
    app = typer.Typer(add_completion=False, rich_markup_mode=None)
    app.command(verb)(command_of(verb, text, options, run, without=("figures", "form")))
    return typer.main.get_command(app)


def _kind(parameter: Parameter) -> Any:
    """The type of an option of an analysis, if it is one of `KINDS` or None."""
    given = parameter.annotation
    words = (given if isinstance(given, str) else inspect.formatannotation(given)).split(" | ")
    kind: Any = KINDS.get(words[0]) if words[1:] in ([], ["None"]) else None
    return kind | None if kind is not None and parameter.default is None else kind


def _run(analysis: Analysis, request: Request, **own: Any) -> int:
    from linkages.errors import InputError, Problem
    from linkages.reports.report import Notes, Report, Table

    name = request.mechanism.name
    try:
        data = analysis(request.mechanism, **own)
    except ValueError as error:
        raise InputError(request.file, [Problem(message=str(error))]) from None
    columns, warning = _columns(data), str(data.attrs.get("warning", ""))
    rows = list(zip(*columns.values(), strict=True))
    report = Report(
        parts=[
            Table(name, list(columns), rows, numbers=len(columns) - 1),
            Notes([warning] if warning else []),
        ],
        data={
            "mechanism": name,
            "rows": [dict(zip(columns, row, strict=True)) for row in rows],
            "warning": warning or None,
        },
    )
    return request.publish(report, [(request.verb, data), (request.verb, columns)])


def _columns(data: xr.Dataset) -> dict[str, list[Any]]:
    """Head → column of a table with a row for each place; dimensions first."""
    frame = data.to_dataframe().reset_index()
    units = {str(name): array.attrs.get("units", "1") for name, array in data.data_vars.items()}
    return {
        f"{name} ({units[name]})" if units.get(name, "1") != "1" else str(name): list(column)
        for name, column in frame.items()
    }
