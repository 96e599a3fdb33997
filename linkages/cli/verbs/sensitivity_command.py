"""``sensitivity``: how measures change with numbers of the definition, the most telling first."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from functools import partial
from typing import TYPE_CHECKING, Any

from rich.console import Console

from linkages.cli.requests import File, Request
from linkages.cli.terminal import number, print_notes, table

if TYPE_CHECKING:
    import xarray as xr

    from linkages.design.sensitivities import Effect

MOST_ROWS = 40


def run(request: Request, of: Sequence[str], to: Sequence[str]) -> int:
    """Differentiate, write, print; returns the exit code."""
    from linkages.design.sensitivities import effects_of
    from linkages.design.stored_requests import sensitivity_asked
    from linkages.spec.measures import read_measure

    with request.computing("sensitivities of"):
        data = sensitivity_asked(request.mechanism, of, to, **request.given)
        measures = list(dict.fromkeys(read_measure(text).text for text in of))
        found = {text: effects_of(request.mechanism, data, text) for text in measures}
    files = request.write(_files(data, found, request.figures))
    content = _content(data, found)
    return request.report(content, files, partial(_print, data, found))


def _unit(data: xr.Dataset, measure: str) -> str:
    """The unit of a measure itself."""
    found = str(data[measure].attrs["units"]).partition(" / ")[0]
    return "" if found == "1" else found


def _reason(data: xr.Dataset, name: str) -> str:
    """Why something of a measure or a series does not exist; empty if all does."""
    return str(data[name].attrs.get("reason", ""))


def _grouped(unit: str) -> str:
    """A unit below a fraction bar."""
    return f"({unit})" if " " in unit else unit


def _files(data: xr.Dataset, found: dict[str, list[Effect]], figures: bool) -> Iterator[File]:
    yield "sensitivity", data
    yield "sensitivity", _columns(data, found)
    if figures:
        from linkages.plots.study_figures import sensitivity_curves, sensitivity_figure

        yield "sensitivity", sensitivity_figure(data, found)
        yield "sensitivity_curves", sensitivity_curves(data)


def _columns(data: xr.Dataset, found: dict[str, list[Effect]]) -> dict[str, list[Any]]:
    """A row for each measure and number."""
    rows = [(text, effect) for text, effects in found.items() for effect in effects]
    return {
        "measure": [text for text, _ in rows],
        "value": [float(data[text].attrs["value"]) for text, _ in rows],
        "measure unit": [_unit(data, text) for text, _ in rows],
        "parameter": [effect.parameter for _, effect in rows],
        "number": [effect.number for _, effect in rows],
        "unit": [effect.unit for _, effect in rows],
        "derivative": [effect.derivative for _, effect in rows],
        "relative": [
            float("nan") if effect.relative is None else effect.relative for _, effect in rows
        ],
        "reason": [_reason(data, text) for text, _ in rows],
    }


def _content(data: xr.Dataset, found: dict[str, list[Effect]]) -> dict[str, Any]:
    return {
        "mechanism": data.attrs["name"],
        "measures": [
            {
                "measure": text,
                "value": float(data[text].attrs["value"]),
                "units": _unit(data, text),
                "reason": _reason(data, text) or None,
                "effects": [asdict(effect) for effect in effects],
            }
            for text, effects in found.items()
        ],
    }


def _print(data: xr.Dataset, found: dict[str, list[Effect]], screen: Console) -> None:
    heads = ["parameter", "number", "", "derivative", "", "relative"]
    for text, effects in found.items():
        unit = _unit(data, text)
        value = float(data[text].attrs["value"])
        title = f"{text} = {number(value)} {unit}".strip()
        rows = [
            [
                effect.parameter, number(effect.number), effect.unit, number(effect.derivative),
                f"{unit or '1'} / {_grouped(effect.unit) or '1'}",
                "" if effect.relative is None else f"{effect.relative:.4f}",
            ]
            for effect in effects[:MOST_ROWS]
            if math.isfinite(effect.derivative)
        ]  # fmt: skip
        title = title if math.isfinite(value) else f"{text} has no value"
        screen.print(table(title, heads, rows) if rows else title)
        if len(effects) > MOST_ROWS:
            screen.print(f"{len(effects) - MOST_ROWS} more rows are in sensitivity.csv")
    print_notes([text for name in map(str, data) if (text := _reason(data, name))], screen)
