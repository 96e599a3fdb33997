"""Machine code from LLVM's assembly language, and the cache folder of compiled kernels."""

from __future__ import annotations

import ctypes
import ctypes.util
import hashlib
import itertools
import logging
import os
import re
import tempfile
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from linkages.reading.output_files import ENVIRONMENT_VARIABLE, is_own, private_folder


def kept(
    key: str, suffix: str, make: Callable[[], bytes], *, anew: bool = False
) -> tuple[bytes, bool]:
    """What was made for a key, from the cache if possible, and whether it was there.

    Files appear whole or not at all. One of other content, or of another user, is made anew.
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

    None, with a warning, where it cannot be made, or somebody else could put code there.
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


LOGGER = logging.getLogger(__name__)

LONG_TEXT = 3_000_000
"""Characters of one function that compile for about ten seconds, see `_equivalent`."""

SIMPLER_TEXT = 300_000
"""Characters above which level 1 makes the same instructions as fast, in two thirds of the time."""

_FORMAT = "3"  # of what is kept
_NUMBERS = itertools.count()  # of libraries: no two have one name
_DEFINED = re.compile(r"^define (i64|double|void) @(\w+)\((.*)\) {$", re.MULTILINE)
_VARIABLE = re.compile(r" = alloca (\w+|<\d+ x \w+>)$", re.MULTILINE)
_DECLARED = re.compile(r"^declare double @(\w+)\(", re.MULTILINE)  # intrinsics have dots
_NEEDED = ("fma", "floor", "rint", "fmod", "pow", "memset", "memcpy", "memmove")
"""By intrinsics, where the processor has no instruction for them."""
_TYPES: dict[str, Any] = {
    "i64": ctypes.c_int64,
    "double": ctypes.c_double,
    "ptr": ctypes.c_void_p,
    "void": None,
}

_MEMORY: dict[str, Any] = {
    "memset": ctypes.memset,
    "memcpy": ctypes.memmove,  # which may do more
    "memmove": ctypes.memmove,
}


class MachineCode:
    """Compiled module of LLVM's assembly language, in memory as long as this lives."""

    def __init__(self, text: str) -> None:
        begin = time.perf_counter()
        key = "\n".join([_FORMAT, *_host(), text])
        content, known = kept(key, ".o", lambda: _compiled(text))
        try:
            self._link(content, key)
        except Exception:  # whatever its reader raises for something else
            if not known:
                raise
            content, known = kept(key, ".o", lambda: _compiled(text), anew=True)
            self._link(content, key)
        how = "was known" if known else "is new and was compiled"
        LOGGER.info("kernel %s %s, %.2f s", digest_of(key), how, time.perf_counter() - begin)

    def _link(self, content: bytes, key: str) -> None:
        defined, needed, image = content.split(b"\n", 2)
        library = _llvm().JITLibraryBuilder().add_object_img(image)
        self._types = {name: types for name, *types in map(str.split, defined.decode().split(";"))}
        for name in self._types:
            library.export_symbol(name)
        for name in needed.decode().split():
            library.import_symbol(name, _library_function(name))
        self._held = library.link(_linker(), f"{digest_of(key)}-{next(_NUMBERS)}")

    def address(self, name: str) -> int:
        """Address of one of its functions."""
        return int(self._held[name])

    def function(self, name: str) -> Callable[..., Any]:
        """One of its functions; while it runs other threads may."""
        types = (_TYPES[word] for word in self._types[name])
        return ctypes.CFUNCTYPE(*types)(self.address(name))


@cache
def _llvm() -> Any:
    """The compiler, which mechanisms that are driven throughout do without."""
    import llvmlite.binding

    llvmlite.binding.initialize_native_target()
    llvmlite.binding.initialize_native_asmprinter()
    return llvmlite.binding


@cache
def _host() -> tuple[str, str, str]:
    """Version of the compiler, and the processor: machine code depends on them."""
    version = ".".join(map(str, _llvm().llvm_version_info))
    return version, _llvm().get_host_cpu_name(), _llvm().get_host_cpu_features().flatten()


@cache
def has_wide_registers() -> bool:
    """Whether registers of this processor have 512 bits."""
    return bool(_llvm().get_host_cpu_features().get("avx512f"))


def _target(level: int = 2) -> Any:
    llvm = _llvm()
    _, name, features = _host()
    target = llvm.Target.from_default_triple()
    return target.create_target_machine(cpu=name, features=features, opt=level, jit=True)


@cache
def _linker() -> Any:
    return _llvm().create_lljit_compiler(_target())


def _equivalent(text: str) -> float:
    """Characters of a single function that would compile for as long as all functions of a text.

    The time of a function grows like its length to the 1.5.
    """
    return sum(len(function) ** 1.5 for function in text.split("\n}\n")) ** (2 / 3)


def _compiled(text: str) -> bytes:
    """A line of what it defines, a line of what it needs, and its machine code."""
    if _equivalent(text) > LONG_TEXT:
        LOGGER.warning(
            "compiling %.1f million characters of equations, which can take minutes; the result is "
            "kept for the next run",
            len(text) / 1e6,
        )
    level = 1 if len(text) > SIMPLER_TEXT else 2
    module = _llvm().parse_assembly(text)
    module.verify()
    if _VARIABLE.search(text):
        _keep_in_registers(module)
    defined = [
        " ".join([name, item, *(argument.split()[0] for argument in arguments.split(","))])
        for item, name, arguments in _DEFINED.findall(text)
    ]
    lines = f"{';'.join(defined)}\n{' '.join([*_DECLARED.findall(text), *_NEEDED])}\n"
    return lines.encode() + bytes(_target(level).emit_object(module))


def _keep_in_registers(module: Any) -> None:
    """Take variables out of memory; no operation changes."""
    llvm = _llvm()
    passes, options = llvm.create_new_function_pass_manager(), llvm.create_pipeline_tuning_options()
    passes.add_sroa_pass()
    builder = llvm.create_pass_builder(_target(), options)
    for function in module.functions:
        if not function.is_declaration:
            passes.run(function, builder)


@cache
def _library_function(name: str) -> int:
    if name.startswith("mem"):
        return int(ctypes.cast(_MEMORY[name], ctypes.c_void_p).value or 0)
    result = ctypes.util.find_library("m") or ("ucrtbase" if os.name == "nt" else None)
    library = ctypes.CDLL(result)
    return int(ctypes.cast(getattr(library, name), ctypes.c_void_p).value or 0)
