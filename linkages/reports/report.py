"""A report of a run: drawing, inputs, curves, largest values, notes, origin; HTML or PDF."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from linkages.plots import pages
from linkages.plots.figures import FIGURES, PICTURES, dense_data, figures_of
from linkages.plots.prefixes import scale_for
from linkages.reading.replacing import replaced
from linkages.reports.inputs import MARK, input_rows
from linkages.solution.origin import DEFINITION, origin_of
from linkages.solution.solution import Solution
from linkages.stamps import stamp

MOST_CURVES = 6
FIRST = ("drive_effort", "drive_force", "clearance_force")
"""Curves that designers ask for first; then those in the order of `FIGURES`."""

RESOLVED = 1e-3
"""Part of a largest value that samples may miss before it is marked."""

LATE, OPEN = "*", "~"

MARKS = {
    LATE: "later than the motion is predictable: right in kind only, another run has another value",
    OPEN: "samples do not resolve the peak: the motion may exceed the value",
}


@dataclass(frozen=True, kw_only=True)
class Report:
    """What a report says, however it is set.

    Parameters
    ----------
    solution
        The run.
    facts
        What is to be known of it, line by line.
    inputs, maxima
        Rows of tables.
    marks
        What marks in `maxima` mean, those that are there.
    notes
        What was assumed, or could not be computed.
    drawing, curves
        Figures.
    origin
        Of `origin_of`.
    """

    solution: Solution
    facts: list[str]
    inputs: list[list[str]]
    maxima: list[list[str]]
    marks: list[str]
    notes: list[str]
    drawing: Figure | None
    curves: list[Figure]
    origin: dict[str, str]


HEADS = ["quantity", "of", "least", "at t (s)", "largest", "at t (s)", "unit"]


def save_report(solution: Solution, path: str | Path) -> Path:
    """Write a report of a run: drawing, inputs, curves, largest values, notes, and its origin.

    Parameters
    ----------
    solution
        Of `linkages.simulate`.
    path
        Ends in ``.html``, a page that needs no other file, or in ``.pdf``, sheets of A4. The
        definition is in both, so that either can be computed again.

    Raises
    ------
    ValueError
        For another ending.
    """
    from linkages.reports.sheets import write_pdf

    file = Path(path)
    kinds: dict[str, Callable[[Report, Path], None]] = {".html": _write_html, ".pdf": write_pdf}
    if file.suffix not in kinds:
        raise ValueError(f"path must end in .html or .pdf, found {file.name!r}")
    found = report_of(solution)
    with replaced(file) as temporary:
        kinds[file.suffix](found, temporary)
        stamp(temporary, found.origin)
    return file


def report_of(solution: Solution) -> Report:
    """Gather what a report says."""
    data, mechanism = solution.data, solution.mechanism
    rows = [_row(solution, row) for row in solution.maxima]
    chosen = sorted({*figures_of(solution)} - {*PICTURES}, key=_importance)
    dense = dense_data(solution, chosen)
    curves = (FIGURES[name](dense, mechanism) for name in chosen)
    values = "".join(cell for row in rows for cell in (row[2], row[4]))
    return Report(
        solution=solution,
        facts=_facts(solution),
        inputs=input_rows(mechanism),
        maxima=rows,
        marks=[f"{mark} {text}" for mark, text in MARKS.items() if mark in values],
        notes=list(dict.fromkeys([*solution.notes, *solution.motion.notes])),
        drawing=FIGURES["mechanism"](data, mechanism),
        curves=[figure for figure in curves if figure is not None][:MOST_CURVES],
        origin={"verb": "simulate", **origin_of(mechanism, solution.options)},
    )


def _importance(name: str) -> tuple[int, int]:
    place = FIRST.index(name) if name in FIRST else len(FIRST)
    return place, list(FIGURES).index(name)


def _row(solution: Solution, row: dict[str, Any]) -> list[str]:
    """Cells of `HEADS`."""
    until = solution.data.attrs.get("horizon")
    cells = [row["long_name"], row["element"]]
    for which in ("least", "greatest"):
        time = row[f"{which}_time"]
        late = LATE if until is not None and abs(time) > abs(until) else ""
        unresolved = OPEN if row["missed"] > RESOLVED else ""
        cells += [f"{row[which]:.6g}{late}{unresolved}", f"{time:.4g}"]
    return [*cells, scale_for(1.0, row["units"]).units]


def _facts(solution: Solution) -> list[str]:
    topology, motion = solution.system.topology, solution.motion
    coordinates = "; ".join(
        f"{word} {', '.join(names)}"
        for word, names in (("driving", topology.driven), ("independent", topology.free))
        if names
    )
    how = (
        f"{motion.method}, rtol {solution.settings.run.rtol:g}"
        if motion.method
        else "drives determine the motion, nothing integrated"
    )
    found = [
        f"mobility {topology.mobility}" + (f": {coordinates}" if coordinates else ""),
        f"{len(topology.dependent)} dependent coordinates in {len(topology.solved_blocks)} blocks",
        f"{solution.summary}; {how}",
    ]
    if motion.failure is not None:
        found.append(f"stopped {motion.failure}")
    if "horizon" in solution.data.attrs:
        found.append(f"predictable to t = {solution.data.attrs['horizon']:.6g} s")
    return found


def provenance(report: Report) -> list[str]:
    """How the run is computed again."""
    options = json.loads(report.origin["arguments"])
    said = ", ".join(f"{k} = {v}" for k, v in options.items() if k != "outputs")
    return [report.origin["version"], report.origin["libraries"], said]


def _write_html(report: Report, path: Path) -> None:
    mechanism = report.solution.mechanism
    changed = [f"{MARK} differs from the file"] if mechanism.changes else []
    body = [
        pages.figure_with(report.drawing, "The mechanism at t = 0.") if report.drawing else "",
        pages.items(report.facts),
        pages.section("Notes", pages.items(report.notes)),
        pages.section(
            "Inputs",
            pages.table(["entry", "values"], report.inputs, texts=True),
            *map(pages.paragraph, changed),
        ),
        pages.section("Curves", *(pages.figure_with(f, "") for f in report.curves)),
        pages.section(
            "Least and largest values",
            pages.table(HEADS, report.maxima, texts=True),
            *map(pages.paragraph, report.marks),
        ),
        pages.section(
            "Origin",
            pages.items(provenance(report)),
            pages.definition(report.origin[DEFINITION]),
        ),
    ]
    text = pages.page(mechanism.name, mechanism.file_name, mechanism.changes, body)
    path.write_text(text, encoding="utf-8")
