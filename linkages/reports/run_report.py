"""Report of a run: drawing, inputs, curves, largest values, notes; HTML or PDF."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.figures import FIGURES, PICTURES, dense_data, figures_of
from linkages.plots.style import scale_for
from linkages.reading.output_files import replaced
from linkages.reading.paths import dotted
from linkages.reports.pages import page
from linkages.reports.report import Definition, Items, Notes, Part, Picture, Report, Section, Table
from linkages.reports.sheets import write_sheets
from linkages.reports.tables import ENDS, LATE, OPEN, marked_ends
from linkages.solution.files import DEFINITION, origin_of
from linkages.solution.solution import Solution
from linkages.stamps import stamp

MARK = "●"
"""Stands before what differs from the file."""

_LONGEST = 160


def input_rows(mechanism: Mechanism) -> list[list[str]]:
    """A row for each entry of the definition: its path, marked where it differs, and its values."""
    changed = [text.partition("=")[0].strip() for text in mechanism.changes]
    rows = []
    for path, value in _entries(mechanism.definition.content):
        name = dotted(path)
        own = any(_same(name, text) or _same(text, name) for text in changed)
        rows.append([f"{MARK} {name}" if own else name, _shown(value)])
    return rows


def _entries(content: Mapping[str, Any]) -> Iterator[tuple[tuple[str | int, ...], Any]]:
    for section, value in content.items():
        if section == "name":
            continue
        if isinstance(value, dict) and any(isinstance(v, dict | list) for v in value.values()):
            yield from (((section, name), entry) for name, entry in value.items())
        elif isinstance(value, list) and any(isinstance(entry, dict) for entry in value):
            yield from (((section, index), entry) for index, entry in enumerate(value))
        else:
            yield (section,), value


def _same(inner: str, outer: str) -> bool:
    """Whether one path is another one, or within it."""
    return inner == outer or inner.startswith((f"{outer}.", f"{outer}["))


def _shown(value: Any) -> str:
    if isinstance(value, dict):
        text = ", ".join(f"{key} {_shown(entry)}" for key, entry in value.items())
    elif isinstance(value, list):
        text = f"[{', '.join(_shown(entry) for entry in value)}]"
    else:
        text = "" if value is None else str(value)
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"


MOST_CURVES = 6
FIRST = ("drive_effort", "drive_force", "clearance_force")
"""Curves that designers ask for first; then those in the order of `FIGURES`."""

MARKS = {
    LATE: "later than the motion is predictable: right in kind only, another run has another value",
    OPEN: "samples do not resolve the peak: the motion may exceed the value",
}


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
    file, mechanism = Path(path), solution.mechanism
    if file.suffix not in (".html", ".pdf"):
        raise ValueError(f"path must end in .html or .pdf, found {file.name!r}")
    origin = {"verb": "simulate", **origin_of(mechanism, solution.options)}
    report = run_report(solution, origin)
    with replaced(file) as temporary:
        if file.suffix == ".html":
            temporary.write_text(page(report, mechanism), encoding="utf-8")
        else:
            write_sheets(report, mechanism, temporary)
        stamp(temporary, origin)
    return file


def run_report(solution: Solution, origin: Mapping[str, str]) -> Report:
    """What a report of a run says; `origin` is that of its files."""
    data, mechanism = solution.data, solution.mechanism
    chosen = sorted({*figures_of(solution)} - {*PICTURES}, key=_importance)
    dense = dense_data(solution, chosen)
    curves = [figure for n in chosen if (figure := FIGURES[n](dense, mechanism)) is not None]
    drawing = FIGURES["mechanism"](data, mechanism)
    until = data.attrs.get("horizon")
    maxima = [
        [row["long_name"], row["element"], *marked_ends(row, until, ".4g"), scale.units]
        for row in solution.maxima
        for scale in [scale_for(1.0, row["units"])]
    ]
    values = "".join(cell for row in maxima for cell in (row[2], row[4]))
    options = json.loads(origin["arguments"])
    said = ", ".join(f"{name} = {value}" for name, value in options.items() if name != "outputs")
    inputs: list[Part] = [Table("", ["entry", "values"], input_rows(mechanism))]
    pictured = [] if drawing is None else [Picture(drawing, "The mechanism at t = 0.")]
    return Report(
        name=mechanism.name,
        parts=[
            *pictured,
            Items(_facts(solution)),
            Notes(list(dict.fromkeys([*solution.notes, *solution.motion.notes]))),
            Section(
                "Inputs", [*inputs, f"{MARK} differs from the file" if mechanism.changes else ""]
            ),
            Section("Curves", [Picture(figure) for figure in curves[:MOST_CURVES]]),
            Section(
                "Least and largest values",
                [
                    Table("", ENDS, maxima),
                    *(f"{mark} {text}" for mark, text in MARKS.items() if mark in values),
                ],
            ),
            Section(
                "Origin",
                [
                    Items([origin["version"], origin["libraries"], said]),
                    Definition(origin[DEFINITION]),
                ],
            ),
        ],
    )


def _importance(name: str) -> tuple[int, int]:
    place = FIRST.index(name) if name in FIRST else len(FIRST)
    return place, list(FIGURES).index(name)


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
