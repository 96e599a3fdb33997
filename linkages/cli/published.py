"""Files of one run of a command: written aside, then put in their place together.

A folder of results has, of every command, the files of its last run and nothing else of it, all of
one definition: files of other commands computed from another one are moved to ``earlier``.
What an interrupted run leaves goes into ``unfinished``, so that it never takes the place of
something whole. Records in ``.linkages`` say which run the files are of; nothing that has no
record, or was changed since, is removed or moved.
"""

from __future__ import annotations

import hashlib
import json
import logging
import re
import shlex
import shutil
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from linkages import interrupts
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import LinkagesError
from linkages.reading.output_files import prefix, remove_leftovers, replaced
from linkages.solution.files import DEFINITION, origin_of
from linkages.stamps import stamp

LOGGER = logging.getLogger(__name__)

RECORDS = ".linkages"
UNFINISHED = "unfinished"
EARLIER = "earlier"

DEFINITIONS = (".yaml", ".yml")
"""Endings of files that results may be computed from: they stay where they are."""


_LOCAL = re.compile(r"(?<![^=])(/|~|[A-Za-z]:[\\/]).*")
"""An absolute path, alone or after an equals sign."""

MAX_RECORD = 32 * 1024**2
"""Bytes of a record that is read."""


class EndedError(LinkagesError):
    """Ctrl-C or a signal ended a run; the message says what has been written."""


@dataclass
class Published:
    """Where files of a run are to be written, and once they are: where they are, in their order.

    `notes` say what became of others.
    """

    folder: Path
    files: list[Path] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


@contextmanager
def published(
    verb: str,
    folder: Path,
    mechanism: Mechanism,
    options: Mapping[str, Any],
    *,
    complete: bool = True,
    interrupted: bool = False,
) -> Iterator[Published]:
    """A folder to write the files of a run into, which are put in their place at the end.

    Those of the last run of `verb` are replaced. Files say what was computed, how, and whether the
    run is complete. Those of an interrupted run go into ``folder/unfinished``; a motion that stops
    is not interrupted, because the same command would stop it again. EndedError if somebody
    interrupts while files are written: those that are whole are kept as unfinished.
    """
    made = [path for path in (folder / RECORDS, folder, *folder.parents) if not path.exists()]
    (folder / RECORDS).mkdir(parents=True, exist_ok=True)
    remove_leftovers(folder / RECORDS)
    staging = Path(tempfile.mkdtemp(dir=folder / RECORDS, prefix=prefix()))
    run = Published(staging)
    whole = "yes" if complete and not interrupted else "no"
    origin = {
        "command": _command(),
        "verb": verb,
        **origin_of(mechanism, options),
        "complete": whole,
    }
    try:
        try:
            yield run
        except BaseException as error:
            # in the midst of drawing, an interrupt may become an error of a library
            if not isinstance(error, KeyboardInterrupt) and not interrupts.received():
                raise
            run.files = _put(verb, staging, folder / UNFINISHED, origin | {"complete": "no"})
            if not run.files:
                raise KeyboardInterrupt from None
            raise EndedError(
                f"interrupted while files were written: {len(run.files)} of them are in "
                f"{folder / UNFINISHED}"
            ) from None
        with interrupts.interrupts_kept():
            run.files = _put(verb, staging, folder / UNFINISHED if interrupted else folder, origin)
            if not interrupted:
                _clear(verb, folder / UNFINISHED)
                run.notes = _separate(verb, folder, origin) if run.files else []
    finally:
        shutil.rmtree(staging, ignore_errors=True)
        for path in made:
            with suppress(OSError):
                path.rmdir()  # if nothing was put there


def _put(verb: str, staging: Path, folder: Path, origin: Mapping[str, str]) -> list[Path]:
    """Move the files of a run to their place, and remove those of the last one."""
    result = sorted(staging.iterdir(), key=lambda path: path.stat().st_mtime_ns)
    new = [path for path in result if not path.name.startswith(".")]
    if not new:
        return []
    for path in new:
        stamp(path, origin)
    (folder / RECORDS).mkdir(parents=True, exist_ok=True)
    record = folder / RECORDS / f"{verb}.json"
    files = {path.name: _fingerprint(path) for path in new}
    stale = {name: mark for name, mark in _own(record).items() if name not in files}
    # both, in case that the process is killed in between
    _write(record, origin, files | stale)
    _remove(folder, stale)
    placed = [path.replace(folder / path.name) for path in new]
    for path in placed:
        LOGGER.info("wrote %s", path)
    if stale:
        _write(record, origin, files)
    return placed


def _separate(verb: str, folder: Path, origin: Mapping[str, str]) -> list[str]:
    """Move files of other commands that were computed from another definition; says which."""
    notes = []
    for record in sorted((folder / RECORDS).glob("*.json")):
        content = _read(record)
        if record.stem == verb or content.get(DEFINITION) in (None, origin[DEFINITION]):
            continue
        own = {
            name: mark
            for name, mark in _own(record).items()
            if Path(name).suffix not in DEFINITIONS and _unchanged(folder, name, mark)
        }
        if own:
            aside = folder / EARLIER
            _remove(aside, _own(aside / RECORDS / record.name))
            (aside / RECORDS).mkdir(parents=True, exist_ok=True)
            for name in own:
                (folder / name).replace(aside / name)
            record.replace(aside / RECORDS / record.name)
            notes.append(
                f"moved {len(own)} file{'s' * (len(own) > 1)} of {record.stem} to {aside}: "
                "computed from another definition"
            )
    return notes


def _clear(verb: str, folder: Path) -> None:
    """Remove what an interrupted run of a command has left."""
    record = folder / RECORDS / f"{verb}.json"
    _remove(folder, _own(record))
    record.unlink(missing_ok=True)
    for path in (folder / RECORDS, folder):
        with suppress(OSError):
            path.rmdir()  # if nothing else is there


def _own(record: Path) -> dict[str, str]:
    """Name → fingerprint of the files of the last run; none if it left no record."""
    files = _read(record).get("files")
    return {str(n): str(mark) for n, mark in files.items()} if isinstance(files, dict) else {}


def _read(record: Path) -> dict[str, Any]:
    """What a record says; nothing if it is none."""
    try:
        if record.stat().st_size > MAX_RECORD:
            return {}
        content = json.loads(record.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}


def _remove(folder: Path, files: Mapping[str, str]) -> None:
    """Remove files, unless somebody has changed them."""
    for name, mark in files.items():
        if _unchanged(folder, name, mark):
            (folder / name).unlink()


def _unchanged(folder: Path, name: str, mark: str) -> bool:
    """Whether a file of a folder is there as it was written."""
    path = folder / name
    return path.parent == folder and path.is_file() and _fingerprint(path) == mark


def _write(record: Path, origin: Mapping[str, str], files: Mapping[str, str]) -> None:
    content = {**origin, "options": json.loads(origin["options"]), "files": files}
    with replaced(record) as temporary:
        temporary.write_text(
            json.dumps(content, indent=2, ensure_ascii=False) + "\n", encoding="utf-8"
        )


def _fingerprint(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _command() -> str:
    """What was typed; of absolute paths, their names: folders are of one machine."""
    return f"python -m linkages {shlex.join(_LOCAL.sub(_name, word) for word in sys.argv[1:])}"


def _name(found: re.Match[str]) -> str:
    return Path(found[0]).name or "."
