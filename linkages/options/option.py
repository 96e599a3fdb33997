"""Options from keyword arguments: validation, signatures, docstrings, and what result files store.

Arguments that are taken from files describe the computation. Where it runs, what it connects to,
and what it reads and writes besides its definition are `PLACES`: these come from the command line
or the call alone, and are not stored.
"""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, fields
from functools import cache
from numbers import Real
from typing import Annotated, Any, Literal, TypeVar, cast, get_args, get_origin, get_type_hints

from pydantic import BaseModel, ConfigDict, Field, JsonValue, TypeAdapter, ValidationError

from linkages.errors import InputError, Problem
from linkages.options.run import FORM, RunOptions, SimulationOptions
from linkages.reading.wording import listed, suggestion
from linkages.spec.conversion import QuantityError
from linkages.spec.models import alternatives, field_texts, rule_of, stripped
from linkages.spec.quantities import Count, FieldType, Quantity


class OptionError(ValueError):
    """An option has a value that makes no sense."""

    def __init__(self, name: str, message: str) -> None:
        super().__init__(message)
        self.name = name


Options = TypeVar("Options", bound=RunOptions)


def given_options(
    kind: type[Options], given: Mapping[str, Any], file: SimulationOptions
) -> Options:
    """Options of a run: as given, else as the definition file says, else as they are by default.

    None counts as not given. Raises OptionError for a value that makes no sense, TypeError for a
    name that is no option and for a value of another type.
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
    """A field of options: its docstring line, type without None, how it is read, and text form."""

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
    result = []
    for field in sorted(fields(kind), key=lambda field: field.name in of_file):
        (arm,) = alternatives(hints[field.name])
        result.append(
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
    return result


def _read(option: Option, value: Any) -> Any:
    name, rule, kind = option.name, option.rule, option.value
    if isinstance(rule, Count | Quantity):
        if not isinstance(value, Real) or isinstance(value, bool):
            raise TypeError(f"{name} must be a number, found {value!r}")
        try:
            return rule.read(value)
        except QuantityError as error:
            expected = error.expected.partition(" (")[0]  # units are for texts
            raise OptionError(name, f"{name} must be {expected}, found {error.found}") from None
    if get_origin(kind) is Literal:
        if value not in get_args(kind):
            words = listed(map(repr, get_args(kind)))
            raise OptionError(name, f"{name} must be {words}, found {value!r}")
        return value
    if not isinstance(value, kind):
        word = {bool: "True or False", str: "text"}[kind]
        raise TypeError(f"{name} must be {word}, found {value!r}")
    return value


Function = TypeVar("Function", bound=Callable[..., Any])

_ENTRY = "options\n    As `{}` describes them.\n"


def takes(kind: type[RunOptions]) -> Callable[[Function], Function]:
    """Let `help` and the pages show the options of a function as its keyword arguments."""

    def shown(function: Function) -> Function:
        options = options_in(kind)
        signature: Any = inspect.signature(function)
        own = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
        given = [
            inspect.Parameter(
                option.name,
                inspect.Parameter.KEYWORD_ONLY,
                default=option.default,
                annotation=option.value | None if option.default is None else option.value,
            )
            for option in options
        ]
        made: Any = function
        made.__signature__ = signature.replace(parameters=[*own, *given])
        texts = "".join(map(_entry, options))
        # Python 3.13 takes the indentation away by itself
        text = inspect.cleandoc(made.__doc__ or "") + "\n"
        made.__doc__ = text.replace(_ENTRY.format(kind.__name__), texts)
        return function

    return shown


def _entry(option: Option) -> str:
    default = f" Default: simulate.{option.name} of the definition." if option.of_file else ""
    text = textwrap.fill(option.text + default, 92)
    return f"{option.name}\n{textwrap.indent(text, '    ')}\n"


PLACES = frozenset((
    "loci", "page",
    "store", "cores", "scheduler", "device", "executor", "watch", "results", "out", "json",
    "figures", "file", "assignments", "others", "status", "browser", "tables_from", "at",
))  # fmt: skip
"""Arguments that never go into a result file, and are never taken from one."""

_Scalar = bool | int | float | str | None
_Text = Annotated[str, Field(max_length=100_000)]
_Texts = Annotated[list[_Text], Field(max_length=10_000)]
_Numbers = Annotated[list[float], Field(max_length=10_000_000)]
_Pair = Annotated[list[float], Field(max_length=2)]


class Asked(BaseModel):
    """Arguments of commands and analyses, with their types; None where nothing is given."""

    model_config = ConfigDict(strict=True, extra="ignore")

    # how a motion is integrated, and for how long
    method: _Text | None = None
    rtol: float | None = None
    atol: float | None = None
    step: float | None = None
    max_steps: int | None = None
    change_points: _Text | None = None
    end: float | None = None
    samples: int | None = None
    times: _Numbers | None = None
    state: _Numbers | _Texts | dict[_Text, float | _Numbers | dict[_Text, float]] | None = None
    events: dict[_Text, _Text] | None = None
    throw: bool | None = None
    # what is computed of it
    outputs: _Text | _Texts | None = None
    verify: bool | None = None
    measure: _Texts | None = None
    of: _Texts | None = None
    to: _Text | _Texts | None = None
    limits: _Texts | None = None
    # sections, exponents, verdicts
    periods: int | None = None
    skip: float | None = None
    phase: float | None = None
    section: _Text | None = None
    direction: _Text | None = None
    wrap: bool | None = None
    start: float | _Text | None = None
    initial: _Texts | None = None
    exponent: bool | None = None
    indicator: _Text | None = None
    refine: int | None = None
    states: bool | None = None
    count: int | None = None
    interval: float | None = None
    quick: bool | None = None
    # orbits and branches
    longest: int | None = None
    what: _Text | None = None
    points: int | None = None
    largest_step: float | None = None
    switch: bool | None = None
    unstable: bool | None = None
    locus: _Text | None = None
    # equilibria and vibration
    time: float | None = None
    moving: bool | None = None
    solve: _Texts | None = None
    inputs: _Texts | None = None
    observed: _Texts | None = None
    frequencies: _Text | _Numbers | None = None
    matrices: _Text | None = None
    film: bool | None = None
    # wear
    until: _Text | None = None
    revolutions: int | None = None
    accuracy: float | None = None
    largest_jump: float | None = None
    confirm: bool | None = None
    feedback: _Text | None = None
    harmonics: int | None = None
    life: bool | None = None
    # duties of drives
    fluctuation: float | None = None
    motors: _Texts | None = None
    # workspaces
    point: _Text | None = None
    ranges: _Texts | None = None
    own: bool | None = None
    # basins and diagrams of many starts
    also: _Texts | None = None
    within: _Texts | None = None
    settled: float | None = None
    # what is varied
    vary: _Texts | None = None
    other: _Texts | None = None
    sample: _Texts | None = None
    draws: int | None = None
    seed: int | None = None
    sequence: _Text | None = None
    time_per_point: float | None = None
    minimise: _Text | None = None
    maximise: _Text | None = None
    subject_to: _Texts | None = None
    branches: _Text | None = None
    search: _Text | None = None
    starts: int | None = None
    runs: int | None = None
    sigma: _Texts | None = None
    repeats: int | None = None
    # what is drawn and written of it
    x: _Text | _Texts | None = None
    y: _Text | _Texts | None = None
    against: _Text | None = None
    difference: bool | None = None
    polar: bool | None = None
    zoom: _Texts | None = None
    units: _Text | None = None
    table: _Text | None = None
    reports: _Texts | None = None
    curve: _Texts | None = None
    form: _Text | None = None
    duration: float | None = None
    slow: float | None = None
    fps: float | None = None
    size: _Text | _Pair | None = None
    dpi: float | None = None
    names: bool | None = None
    plot: _Texts | None = None
    loads: bool | None = None
    reactions: _Texts | None = None
    bare: bool | None = None
    hole: float | None = None
    width: float | None = None
    paths: bool | None = None
    links: bool | None = None
    symbols: bool | None = None
    fmi: _Text | None = None
    kernel: bool | None = None
    modes: bool | None = None


def asked_in(
    arguments: Mapping[str, JsonValue], source: str, own: Collection[str] = ()
) -> dict[str, Any]:
    """Those arguments of a result file that another computation takes over."""
    known = {name: value for name, value in arguments.items() if name in Asked.model_fields}
    others = {n: arguments[n] for n in own if n in arguments and n not in known.keys() | PLACES}
    try:
        result = Asked.model_validate(known)
        TypeAdapter(dict[str, _Scalar]).validate_python(others, strict=True)
    except ValidationError as error:
        names = dict.fromkeys(str(problem["loc"][0]) for problem in error.errors())
        problems = [
            Problem(path=f"origin.arguments.{name}", message="is not of the type of this argument")
            for name in names
        ]
        raise InputError(source, problems) from None
    return {name: getattr(result, name) for name in known} | others


def stored(options: Mapping[str, Any]) -> dict[str, Any]:
    """Those options of a computation that its result files store: all that describe it."""
    return {name: value for name, value in options.items() if name not in PLACES}
