"""``new``, ``schema``, ``import`` and ``list``: definition files."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.markup import escape

from linkages.cli.options import SUFFIXES, Template
from linkages.cli.requests import require_folder
from linkages.cli.terminal import console, json_text, print_json, table
from linkages.components.mechanisms.registry import FILE_NAME, SECTIONS, TITLE
from linkages.errors import InputError, Problem
from linkages.reading.document import find, read, shipped
from linkages.reading.overrides import parse_assignment
from linkages.spec.conversion import QuantityError, parse_quantity
from linkages.spec.units import LENGTH, Bound

if TYPE_CHECKING:
    from linkages.components.mechanisms.mechanism import Mechanism
    from linkages.kernel.system import System


def run_schema() -> int:
    """Print the schema; returns the exit code."""
    unicode = (sys.stdout.encoding or "").lower().startswith("utf")
    print(schema_text(ascii_only=not unicode))
    return 0


def schema_text(ascii_only: bool = False) -> str:
    """The schema as text."""
    from linkages.components.mechanisms.registry import definition_schema

    return json_text(definition_schema(), ascii_only=ascii_only, indent=1)


TEMPLATES = Path(__file__).resolve().parents[1] / "templates"


def run_new(name: str, template: Template, force: bool, json: bool) -> int:
    """Write a definition file and its schema; returns the exit code."""
    from linkages.reading.output_files import replaced

    path = _path(name)
    schema = path.parent / FILE_NAME
    _require_writable(path, schema, force)
    for file, text in (
        (path, _filled(TEMPLATES / f"{template}.yaml")),
        (schema, schema_text() + "\n"),
    ):
        with replaced(file) as temporary:
            temporary.write_text(text, encoding="utf-8", newline="\n")
    if json:
        print_json({"template": str(template), "files": [str(path), str(schema)]})
    else:
        _say_what_next(path, schema)
    return 0


def _filled(template: Path) -> str:
    """A template; one that comments sections out gets those that it does not know yet."""
    text = template.read_text(encoding="utf-8")
    if "# free:" not in text:
        return text
    missing = {key: s for key, s in SECTIONS.items() if not re.search(f"^(# )?{key}:", text, re.M)}
    forms = {"mapping": "# {}:\n#   {}\n", "list": "# {}:\n#   - {}\n", "value": "# {}: {}\n"}
    more = [forms[section.form].format(key, section.example) for key, section in missing.items()]
    return "\n".join([text, *more])


def _path(name: str) -> Path:
    path = Path(name)
    if not path.name or not path.name.isprintable() or name.endswith(("/", "\\")):
        message = f"expected the name of a file, such as engine or engine.yaml, found {name!r}"
        raise InputError("new", [Problem(message=message)])
    # a dot may belong to the name: press-1.5 becomes press-1.5.yaml
    return path if path.suffix in SUFFIXES else path.with_name(f"{path.name}.yaml")


def _require_writable(path: Path, schema: Path, force: bool) -> None:
    require_folder(path.parent)
    problems = [
        Problem(message=f"{file} is a folder; expected a file, or none of that name")
        for file in (path, schema)
        if file.is_dir()
    ]
    if path.is_file() and not force:
        problems.append(Problem(message=f"{path} exists; --force replaces it"))
    if schema.is_file() and not force and not _ours(schema):
        problems.append(Problem(message=f"{schema} exists and is no schema of linkages; --force"))
    if problems:
        raise InputError("new", problems)


def _ours(schema: Path) -> bool:
    """Whether a file was written by `new`: it may then be brought up to date."""
    return TITLE in schema.read_text(encoding="utf-8", errors="replace")[:400]


def _say_what_next(path: Path, schema: Path) -> None:
    screen = console()
    shown = f'"{path}"' if " " in str(path) else str(path)
    for line in (
        f"wrote {path}, to be edited, and {schema.name}, with which editors complete and check it",
        f"next: python -m linkages check {shown}",
        f"      python -m linkages simulate {shown}",
    ):
        screen.print(line, markup=False, soft_wrap=True)


def run_import(
    link: str,
    out: Path,
    masses: bool,
    mass_per_length: float,
    clearance: Sequence[str],
    force: bool,
    json: bool,
) -> int:
    """Write a definition file; returns the exit code."""
    from linkages.bridges.pmks import from_pmks

    if out.exists() and not force:
        raise InputError("import", [Problem(message=f"{out} exists; --force replaces it")])
    require_folder(out.parent)
    try:
        mechanism = from_pmks(
            link, masses=masses and not mass_per_length, mass_per_length=mass_per_length,
            clearances=dict(map(_clearance, clearance)),
        )  # fmt: skip
    except ValueError as error:
        raise InputError("import", [Problem(message=str(error))]) from None
    mechanism.save(out)
    if json:
        print_json({"mechanism": mechanism.name, "files": [str(out)]})
        return 0
    screen = console()
    screen.print(f"wrote {out}: {mechanism!r}", markup=False, soft_wrap=True)
    screen.print(f"next: python -m linkages check {out}", markup=False, soft_wrap=True)
    return 0


def _clearance(text: str) -> tuple[str, float]:
    joint, size = parse_assignment(text)
    try:
        return joint, parse_quantity(size, LENGTH, Bound.POSITIVE)
    except QuantityError as error:
        raise InputError("--clearance", [Problem(message=f"{joint}: {error}")]) from None


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
