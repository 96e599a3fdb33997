"""Folders of the user's cache, into which nobody else can put anything."""

from __future__ import annotations

import os
import stat
from pathlib import Path

ENVIRONMENT_VARIABLE = "LINKAGES_CACHE_DIR"


def private_folder(name: str) -> Path:
    """A folder in $LINKAGES_CACHE_DIR or the user's cache folder, without links in its path.

    What is in it is run, so that nobody else may put something there, now or before: rights are not
    repaired, for there may already be files of others.

    Raises
    ------
    OSError
        If it cannot be made, or others can write to it or exchange it. The message has the reason
        and, where there is one, the remedy.
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
