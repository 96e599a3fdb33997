"""What a computation is asked for, as a result file stores it and another run takes it over.

This is the one list of arguments that are taken from files. They describe the computation. Where it
runs, what it connects to, and what it reads and writes besides its definition are `PLACES`: these
come from the command line or the call alone, and are not stored.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, JsonValue, TypeAdapter, ValidationError

from linkages.errors import InputError, Problem

PLACES = frozenset((
    "store", "cores", "scheduler", "device", "executor", "watch", "results", "out", "json",
    "figures", "file", "assignments", "others", "status", "browser", "tables_from",
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
    state: _Numbers | dict[_Text, float | _Numbers | dict[_Text, float]] | None = None
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
    count: int | None = None
    interval: float | None = None
    quick: bool | None = None
    # what is varied
    vary: _Texts | None = None
    sample: _Texts | None = None
    draws: int | None = None
    seed: int | None = None
    sequence: _Text | None = None
    time_per_point: float | None = None
    minimise: _Text | None = None
    maximise: _Text | None = None
    subject_to: _Texts | None = None
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
    kernel: bool | None = None
    modes: bool | None = None


def asked_in(
    arguments: Mapping[str, JsonValue], source: str, own: Collection[str] = ()
) -> dict[str, Any]:
    """Those arguments of a result file that another computation takes over."""
    known = {name: value for name, value in arguments.items() if name in Asked.model_fields}
    others = {n: arguments[n] for n in own if n in arguments and n not in known.keys() | PLACES}
    try:
        found = Asked.model_validate(known)
        TypeAdapter(dict[str, _Scalar]).validate_python(others, strict=True)
    except ValidationError as error:
        names = dict.fromkeys(str(problem["loc"][0]) for problem in error.errors())
        problems = [
            Problem(path=f"origin.arguments.{name}", message="is not of the type of this argument")
            for name in names
        ]
        raise InputError(source, problems) from None
    return {name: getattr(found, name) for name in known} | others


def stored(options: Mapping[str, Any]) -> dict[str, Any]:
    """Those options of a computation that its result files store: all that describe it."""
    return {name: value for name, value in options.items() if name not in PLACES}
