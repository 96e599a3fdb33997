"""Atomic writes of files, and cache folders that only the user can write to."""

from __future__ import annotations

import logging
import os
import platform
import re
import shutil
import stat
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


ENVIRONMENT_VARIABLE = "LINKAGES_CACHE_DIR"


def private_folder(name: str) -> Path:
    """A folder in $LINKAGES_CACHE_DIR or the user's cache folder, without links in its path.

    What is in it is run, so that nobody else may put something there, now or before: rights are not
    repaired, for there may already be files of others.
    """
    named = os.environ.get(ENVIRONMENT_VARIABLE)
    if named:
        above = Path(named)
    else:
        from platformdirs import user_cache_path

        above = user_cache_path("linkages")
    folder = (above / name).resolve()
    for path in (*reversed(folder.parents), folder):
        if not path.is_dir():
            path.mkdir(mode=stat.S_IRWXU, exist_ok=True)
    if hasattr(os, "geteuid"):  # elsewhere access-control lists protect the user's profile
        for path in (folder, *folder.parents):
            _require_private(path, path.stat(), inner=path == folder)
    return folder


def is_own(status: os.stat_result) -> bool:
    """Whether a file belongs to this user, and nobody else can write to it."""
    if not hasattr(os, "geteuid"):
        return stat.S_ISREG(status.st_mode)
    others = status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    return stat.S_ISREG(status.st_mode) and status.st_uid == os.geteuid() and not others


def _require_private(path: Path, status: os.stat_result, *, inner: bool) -> None:
    """Nobody else can put files into the folder itself, or exchange one of the folders above."""
    owners = {os.geteuid()} if inner else {os.geteuid(), 0, *_unmapped()}
    if status.st_uid not in owners:
        raise PermissionError(None, f"{path} belongs to another user")
    sticky = not inner and status.st_mode & stat.S_ISVTX  # as /tmp: others cannot rename there
    if status.st_mode & (stat.S_IWGRP | stat.S_IWOTH) and not sticky:
        raise PermissionError(
            None, f"others can write to {path}; if you trust what is there: chmod go-w {path}"
        )


def _unmapped() -> set[int]:
    """How root and others outside appear in a container in which they have no number."""
    try:
        if Path("/proc/self/uid_map").read_text(encoding="ascii").split() == _EVERYBODY:
            return set()
        return {int(Path("/proc/sys/fs/overflowuid").read_text(encoding="ascii"))}
    except (OSError, ValueError):
        return set()


_EVERYBODY = ["0", "0", str(2**32 - 1)]
