"""Where generated kernels are kept: a folder of the user that nobody else can write to."""

from __future__ import annotations

import hashlib
import os
import stat
import tempfile
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path

ENVIRONMENT_VARIABLE = "LINKAGES_CACHE_DIR"


def kept(key: str, suffix: str, make: Callable[[], bytes]) -> tuple[bytes, bool]:
    """What was made for a key, from the cache if it has been made before, and whether it was.

    Writers do not disturb each other: a file appears whole or not at all. One whose content is not
    what was written is made anew.

    Parameters
    ----------
    key
        All that the content depends on; the file's name is its hash.
    suffix
        Of the file.
    make
        Makes the content.
    """
    path = cache_folder() / f"linkages_kernel_{digest_of(key)}{suffix}"
    try:
        seal, content = path.read_bytes().split(b"\n", 1)
        if seal == _seal(content):
            return content, True
    except (OSError, ValueError):
        pass  # not there, or not ours
    content = make()
    handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".tmp")
    with os.fdopen(handle, "wb") as file:
        file.write(_seal(content) + b"\n" + content)
    Path(temporary).replace(path)
    return content, False


def digest_of(key: str) -> str:
    """A short hash."""
    return hashlib.sha256(key.encode()).hexdigest()[:20]


def _seal(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()


@cache
def cache_folder() -> Path:
    """The folder for generated code, in $LINKAGES_CACHE_DIR or the user's cache folder.

    Where neither can be made private, a temporary folder serves this process alone, with a
    warning: kernels are then compiled anew in each run.
    """
    wanted = _wanted_folder()
    try:
        wanted.mkdir(mode=stat.S_IRWXU, parents=True, exist_ok=True)
        _make_private(wanted)
    except OSError as error:
        warnings.warn(
            f"cannot keep compiled kernels in {wanted} ({error.strerror or error}); "
            f"set {ENVIRONMENT_VARIABLE} to a folder of your own",
            stacklevel=2,
        )
        return Path(tempfile.mkdtemp(prefix="linkages-"))
    return wanted


def _wanted_folder() -> Path:
    named = os.environ.get(ENVIRONMENT_VARIABLE)
    if named:
        return Path(named) / "kernels"  # a folder of our own: its permissions are changed
    from platformdirs import user_cache_path

    return user_cache_path("linkages") / "kernels"


def _make_private(folder: Path) -> None:
    """Code is imported from here: it must be the user's own, writable by nobody else."""
    if os.name == "nt":  # the user's profile is private by its access-control list
        return
    status = folder.stat()
    if status.st_uid != os.getuid():
        raise PermissionError(None, "it belongs to another user")
    if stat.S_IMODE(status.st_mode) != stat.S_IRWXU:
        folder.chmod(stat.S_IRWXU)
    probe, name = tempfile.mkstemp(dir=folder)
    os.close(probe)
    Path(name).unlink()
