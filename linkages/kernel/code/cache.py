"""Where generated kernels are kept: a folder of the user that nobody else can write to."""

from __future__ import annotations

import hashlib
import os
import tempfile
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path

from linkages.reading.private import ENVIRONMENT_VARIABLE, is_own, private_folder


def kept(
    key: str, suffix: str, make: Callable[[], bytes], *, anew: bool = False
) -> tuple[bytes, bool]:
    """What was made for a key, from the cache if it has been made before, and whether it was.

    Writers do not disturb each other: a file appears whole or not at all. One whose content is not
    what was written, or that is of another user, is made anew.

    Parameters
    ----------
    key
        All that the content depends on; the file's name is its hash.
    suffix
        Of the file.
    make
        Makes the content.
    anew
        Whether what is kept is of no use.
    """
    folder = cache_folder()
    if folder is None:
        return make(), False
    path = folder / f"linkages_kernel_{digest_of(key)}{suffix}"
    with suppress(OSError, ValueError), path.open("rb") as file:  # not there, or not ours
        if is_own(os.fstat(file.fileno())) and not anew:
            seal, content = file.read().split(b"\n", 1)
            if seal == _seal(content):
                return content, True
    content = make()
    with suppress(OSError):  # a full disk costs time, no more
        handle, temporary = tempfile.mkstemp(dir=folder, suffix=".tmp")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(_seal(content) + b"\n" + content)
            Path(temporary).replace(path)
        except OSError:
            Path(temporary).unlink(missing_ok=True)
    return content, False


def digest_of(key: str) -> str:
    """A short hash."""
    return hashlib.sha256(key.encode()).hexdigest()[:20]


def _seal(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()


@cache
def cache_folder() -> Path | None:
    """The folder for generated code, in $LINKAGES_CACHE_DIR or the user's cache folder.

    None, with a warning, where it cannot be made, or somebody else could put code there: kernels
    are compiled anew in each run then.
    """
    try:
        folder = private_folder("kernels")
        probe, name = tempfile.mkstemp(dir=folder)
        os.close(probe)
        Path(name).unlink()
    except OSError as error:
        reason = error.strerror or str(error)
        place = f"{error.filename}: " if error.filename else ""
        message = (
            f"compiled kernels are not kept ({place}{reason}); otherwise set "
            f"{ENVIRONMENT_VARIABLE} to a folder of your own"
        )
        # no line of this package: it has nothing to do with the reason
        warnings.warn_explicit(message, UserWarning, "linkages", 0)
        return None
    return folder
