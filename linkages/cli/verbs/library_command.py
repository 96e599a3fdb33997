"""``list``: the mechanisms that are shipped with the package, and what one of them is."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.markup import escape

from linkages.cli.terminal import console, print_json, table
from linkages.reading.document import find, read, shipped

if TYPE_CHECKING:
    from linkages.components.mechanisms.mechanism import Mechanism
    from linkages.kernel.system import System

EDITOR_LINE = "yaml-language-server:"
"""Begins the comment that tells editors the schema."""


def run_list(json: bool) -> int:
    """List the library with a line each; returns the exit code."""
    entries = {
        name: {"title": read(path).content.get("name"), "file": str(path)}
        for name, path in shipped().items()
    }
    if json:
        print_json({"mechanisms": entries})
        return 0
    rows = [[name, entry["title"]] for name, entry in entries.items()]
    console().print(table("Mechanisms shipped with the package", ["file", "what it is"], rows))
    return 0


def run_show(
    file: str, out: Path | None, json: bool, figures: bool, picture: str, dimensions: bool
) -> int:
    """Say what one mechanism is and draw it; returns the exit code."""
    from linkages.cli.requests import mechanism_from, require_folder
    from linkages.kernel.system import System

    mechanism = mechanism_from(file, ())
    folder = Path("results") / Path(file).stem if out is None else out
    if figures:
        require_folder(folder)
    system = System(mechanism)
    path = find(file)
    topology = system.topology
    content = {
        "mechanism": mechanism.name,
        "file": str(path),
        "description": description(path.read_text(encoding="utf-8")),
        "components": _components(mechanism),
        "mobility": topology.mobility,
        "driven": list(topology.driven),
        "free": list(topology.free),
        "files": [],
    }
    if figures:
        path = _drawn(system, folder / f"drawing.{picture}", dimensions)
        content["files"] = [str(path)]
    if json:
        print_json(content)
    else:
        _print(content)
    return 0


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
    found: dict[str, list[str]] = {}
    for part in mechanism.components:
        names = [str(name) for name in part.path[1:]]
        if names:
            found.setdefault(part.section, []).extend(names)
    return found


def _drawn(system: System, path: Path, dimensions: bool) -> Path:
    from linkages.plots.figures import write_figure
    from linkages.plots.mechanism.drawing import start_figure

    return write_figure(start_figure(system, dimensions=dimensions), path)


def _print(content: dict[str, Any]) -> None:
    screen = console()
    screen.print(f"[bold]{escape(content['mechanism'])}[/bold]")
    for paragraph in content["description"]:
        screen.print(f"\n{paragraph}", markup=False, soft_wrap=True)
    rows = [
        [section, ", ".join(names) if not names[0].isdigit() else str(len(names))]
        for section, names in content["components"].items()
    ]
    screen.print(table("\nComponents", ["section", "entries"], rows))
    driven, free = (", ".join(content[key]) or "none" for key in ("driven", "free"))
    screen.print(
        f"\nmobility {content['mobility']}; driven: {driven}; free: {free}",
        markup=False,
        soft_wrap=True,
    )
    screen.print(f"file: {content['file']}", markup=False, soft_wrap=True)
    for file in content["files"]:
        screen.print(f"drawn in {file}", markup=False, soft_wrap=True)
