"""``sensitivity``: how measures change with numbers of the definition, the most telling first."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

from linkages.cli.requests import File, Request
from linkages.reports.report import Notes, Part, Report, Table, number

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

    def figures() -> Iterator[File]:
        from linkages.plots.study_figures import sensitivity_curves, sensitivity_figure

        yield "sensitivity", sensitivity_figure(data, found)
        yield "sensitivity_curves", sensitivity_curves(data)

    # why a measure or a series does not exist
    reasons = {str(name): str(data[name].attrs.get("reason", "")) for name in data}
    content = [
        {
            "measure": text,
            "value": float(data[text].attrs["value"]),
            "units": "" if unit == "1" else unit,
            "reason": reasons[text] or None,
            "effects": [asdict(effect) for effect in effects],
        }
        for text, effects in found.items()
        for unit in [str(data[text].attrs["units"]).partition(" / ")[0]]
    ]
    report = Report(
        parts=[
            *(part for measure in content for part in _parts(measure)),
            Notes([text for text in reasons.values() if text]),
        ],
        data={"mechanism": data.attrs["name"], "measures": content},
    )
    files: list[File] = [("sensitivity", data), ("sensitivity", _columns(content))]
    return request.publish(report, files, figures)


def _columns(measures: Sequence[dict[str, Any]]) -> dict[str, list[Any]]:
    """A row for each measure and number."""
    rows = [
        {
            "measure": measure["measure"],
            "value": measure["value"],
            "measure unit": measure["units"],
            **{key: effect[key] for key in ("parameter", "number", "unit", "derivative")},
            "relative": math.nan if effect["relative"] is None else effect["relative"],
            "reason": measure["reason"] or "",
        }
        for measure in measures
        for effect in measure["effects"]
    ]
    return {head: [row[head] for row in rows] for head in (rows[0] if rows else ())}


def _parts(measure: dict[str, Any]) -> Iterator[Part]:
    text, unit, effects = measure["measure"], measure["units"], measure["effects"]
    title = f"{text} has no value"
    if math.isfinite(measure["value"]):
        title = f"{text} = {number(measure['value'])} {unit}".strip()
    rows = [
        [
            own["parameter"], own["number"], own["unit"], own["derivative"],
            f"{unit or '1'} / {_grouped(own['unit']) or '1'}",
            "" if own["relative"] is None else f"{own['relative']:.4f}",
        ]
        for own in effects[:MOST_ROWS]
        if math.isfinite(own["derivative"])
    ]  # fmt: skip
    heads = ["parameter", "number", "", "derivative", "", "relative"]
    yield Table(title, heads, rows) if rows else title
    if len(effects) > MOST_ROWS:
        yield f"{len(effects) - MOST_ROWS} more rows are in sensitivity.csv"


def _grouped(unit: str) -> str:
    """A unit below a fraction bar."""
    return f"({unit})" if " " in unit else unit
