"""``list``: the mechanisms that are shipped with the package, and what one of them is."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from linkages.cli.terminal import present
from linkages.errors import InputError, Problem
from linkages.reading.document import find, read, shipped
from linkages.reports.report import Report, Table, Unbroken

if TYPE_CHECKING:
    from linkages.components.mechanisms.mechanism import Mechanism
    from linkages.kernel.system import System

EDITOR_LINE = "yaml-language-server:"
"""Begins the comment that tells editors the schema."""


def run_list(
    name: str | None, json: bool, out: Path | None, figures: bool, form: str, dimensions: bool
) -> int:
    """List the library with a line each, or show one mechanism; returns the exit code."""
    if name is not None:
        return _show(name, out, json, figures, form, dimensions)
    for flag, given in (("--dimensions", dimensions), ("--out", out is not None)):
        if given:
            message = "expected the NAME of a mechanism to draw before this option"
            raise InputError(flag, [Problem(message=message)])
    entries = {
        name: {"title": read(path).content.get("name"), "file": str(path)}
        for name, path in shipped().items()
    }
    rows = [[name, entry["title"]] for name, entry in entries.items()]
    table = Table("Mechanisms shipped with the package", ["file", "what it is"], rows)
    return present(Report(parts=[table], data={"mechanisms": entries}), json)


def _show(
    file: str, out: Path | None, json: bool, figures: bool, picture: str, dimensions: bool
) -> int:
    """Say what one mechanism is and draw it."""
    from linkages.cli.requests import mechanism_from, require_folder
    from linkages.kernel.system import System

    mechanism = mechanism_from(file, ())
    folder = Path("results") / Path(file).stem if out is None else out
    if figures:
        require_folder(folder)
    system = System(mechanism)
    path, topology = find(file), system.topology
    drawn = [_drawn(system, folder / f"drawing.{picture}", dimensions)] if figures else []
    paragraphs = description(path.read_text(encoding="utf-8"))
    components, mobility = _components(mechanism), topology.mobility
    rows = [
        [section, ", ".join(names) if not names[0].isdigit() else str(len(names))]
        for section, names in components.items()
    ]
    driven, free = (", ".join(names) or "none" for names in (topology.driven, topology.free))
    report = Report(
        name=mechanism.name,
        parts=[
            *(Unbroken(f"\n{paragraph}") for paragraph in paragraphs),
            Table("\nComponents", ["section", "entries"], rows),
            Unbroken(f"\nmobility {mobility}; driven: {driven}; free: {free}"),
            Unbroken(f"file: {path}"),
            *(Unbroken(f"drawn in {file}") for file in drawn),
        ],
        data={
            "mechanism": mechanism.name,
            "file": str(path),
            "description": paragraphs,
            "components": components,
            "mobility": mobility,
            "driven": list(topology.driven),
            "free": list(topology.free),
            "files": [str(file) for file in drawn],
        },
    )
    return present(report, json)


def description(text: str) -> list[str]:
    """The paragraphs of the comment that a definition file begins with, sources among them."""
    lines: list[str] = []
    for line in text.removeprefix("\ufeff").splitlines():
        if not line.startswith("#"):
            break
        if EDITOR_LINE not in line:
            lines.append(line.lstrip("#").removeprefix(" ").rstrip())
    return [part.strip("\n") for part in "\n".join(lines).split("\n\n") if part.strip()]


def _components(mechanism: Mechanism) -> dict[str, list[str]]:
    """Section → the names of its entries; those of a list have their place for a name."""
    result: dict[str, list[str]] = {}
    for part in mechanism.components:
        names = [str(name) for name in part.path[1:]]
        if names:
            result.setdefault(part.section, []).extend(names)
    return result


def _drawn(system: System, path: Path, dimensions: bool) -> Path:
    from linkages.plots.figures import write_figure
    from linkages.plots.mechanism.drawing import start_figure

    return write_figure(start_figure(system, dimensions=dimensions), path)
