"""``new``: a commented definition file to start from, with its schema for editors beside it."""

from __future__ import annotations

import re
from pathlib import Path

from linkages.cli.loading import require_folder
from linkages.cli.options import SUFFIXES, Template
from linkages.cli.terminal import console, print_json
from linkages.cli.verbs.schema import schema_text
from linkages.components.mechanisms.registry import SECTIONS
from linkages.components.mechanisms.schema import FILE_NAME, TITLE
from linkages.errors import InputError, Problem

TEMPLATES = Path(__file__).resolve().parents[1] / "templates"


def run_new(name: str, template: Template, force: bool, json: bool) -> int:
    """Write a definition file and its schema; returns the exit code."""
    from linkages.reading.replacing import replaced

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
