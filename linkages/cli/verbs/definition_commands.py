"""``new``, ``schema`` and ``import``: definition files."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from pathlib import Path

from linkages.cli.requests import require_folder
from linkages.cli.terminal import json_text, present
from linkages.cli.verb import SUFFIXES, Template
from linkages.components.mechanisms.registry import FILE_NAME, SECTIONS, TITLE
from linkages.errors import InputError, Problem
from linkages.reading.overrides import parse_assignment
from linkages.reports.report import Report, Unbroken
from linkages.spec.conversion import QuantityError, parse_quantity
from linkages.spec.units import LENGTH, Bound


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
    shown = f'"{path}"' if " " in str(path) else str(path)
    said = (
        f"wrote {path}, a commented starter file, and {schema.name}, with which your editor "
        "completes and checks it",
        f"next: python -m linkages check {shown}",
        f"      python -m linkages simulate {shown}",
    )
    data = {"template": template, "files": [str(path), str(schema)]}
    return present(Report(parts=[Unbroken(line) for line in said], data=data), json)


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


def run_import(
    link: str,
    out: Path,
    masses: bool,
    mass_per_length: float,
    clearance: Sequence[str] | None,
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
            clearances=dict(map(_clearance, clearance or ())),
        )  # fmt: skip
    except ValueError as error:
        raise InputError("import", [Problem(message=str(error))]) from None
    mechanism.save(out)
    said = (f"wrote {out}: {mechanism!r}", f"next: python -m linkages check {out}")
    data = {"mechanism": mechanism.name, "files": [str(out)]}
    return present(Report(parts=[Unbroken(line) for line in said], data=data), json)


def _clearance(text: str) -> tuple[str, float]:
    joint, size = parse_assignment(text)
    try:
        return joint, parse_quantity(size, LENGTH, Bound.POSITIVE)
    except QuantityError as error:
        raise InputError("--clearance", [Problem(message=f"{joint}: {error}")]) from None
