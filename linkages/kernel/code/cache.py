"""Where generated kernels are kept: a folder of the user that nobody else can write to."""

from __future__ import annotations

import hashlib
import importlib.util
import logging
import os
import stat
import sys
import tempfile
import threading
import time
import warnings
from functools import cache
from pathlib import Path
from types import ModuleType

LOGGER = logging.getLogger(__name__)
ENVIRONMENT_VARIABLE = "LINKAGES_CACHE_DIR"

_STAMP = 1e9  # seconds since 1970

# A module is entered before it has been executed: no other thread may find it in between.
_LOADING = threading.RLock()


def cached_module(text: str) -> ModuleType:
    """Import a generated module, from the cache if it has been written before.

    The name of the file is a hash of its text, so a changed generator or topology never meets an
    old file. Writers do not disturb each other: a file appears whole or not at all, and one that
    exists with the right text is left alone, so that Numba finds its compiled code beside it.

    Parameters
    ----------
    text
        Python source.
    """
    digest = hashlib.sha256(text.encode()).hexdigest()[:20]
    name = f"linkages_kernel_{digest}"
    with _LOADING:
        if name not in sys.modules:
            path, begin = cache_folder() / f"{name}.py", time.perf_counter()
            known = _holds(path, text)
            if not known:
                _write(path, text)
            _import(name, path)
            how = "was known" if known else "is new and was compiled"
            LOGGER.info("kernel %s %s, %.2f s", path, how, time.perf_counter() - begin)
    return sys.modules[name]


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


def _holds(path: Path, text: str) -> bool:
    try:
        return path.read_bytes() == text.encode()
    except OSError:
        return False


def _write(path: Path, text: str) -> None:
    handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".tmp")
    with os.fdopen(handle, "w", encoding="utf-8", newline="\n") as file:
        file.write(text)
    # Older versions of Numba outdate machine code when the time stamp of its source changes.
    # Writers of one text replace each other's file; what was compiled meanwhile must stay valid.
    os.utime(temporary, (_STAMP, _STAMP))
    Path(temporary).replace(path)


def _import(name: str, path: Path) -> None:
    """Import a file as `name`; Numba looks the module up while it runs, so it is entered first."""
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
