"""Files that are written under a temporary name, then renamed: they appear whole or not at all."""

from __future__ import annotations

import logging
import os
import platform
import re
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

LOGGER = logging.getLogger(__name__)

HOST = re.sub(r"[^A-Za-z0-9.]", "", platform.node()) or "host"
_TEMPORARY = re.compile(r"\.linkages-([A-Za-z0-9.]+)-(\d+)-\w+(\.\w+)?")
ABANDONED = 86_400.0
"""Age in seconds from which on a temporary file is nobody's, whoever made it."""


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """A temporary path beside `path` that takes its place if all goes well."""
    path.parent.mkdir(parents=True, exist_ok=True)
    remove_leftovers(path.parent)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=prefix(), suffix=path.suffix)
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o666 & ~mask)
        temporary.replace(path)
        if not any(part.startswith(".linkages") for part in path.parent.parts):
            LOGGER.info("wrote %s", path)
    except BaseException as error:
        temporary.unlink(missing_ok=True)
        # writes do not name their file, as where a disk is full; without a number it is not shown
        if isinstance(error, OSError) and error.errno and error.filename in (None, str(temporary)):
            error.filename = str(path)
        raise


def prefix() -> str:
    """Begins the name of what is temporary, and says whose it is."""
    return f".linkages-{HOST}-{os.getpid()}-"


def remove_leftovers(folder: Path) -> None:
    """Remove the temporary files and folders of processes that were killed."""
    for path in folder.iterdir():
        match = _TEMPORARY.fullmatch(path.name)
        if match is None or not _abandoned(path, match[1], int(match[2])):
            continue
        LOGGER.info("removing what a process that was killed has left: %s", path)
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)


def _abandoned(path: Path, host: str, process: int) -> bool:
    """Whether the process that made a temporary file is gone."""
    if os.name == "posix" and host == HOST:
        try:
            os.kill(process, 0)  # on Windows that would end it
        except ProcessLookupError:
            return True
        except OSError:
            return False  # somebody else's
    try:
        return time.time() - path.stat().st_mtime > ABANDONED
    except FileNotFoundError:
        return False
