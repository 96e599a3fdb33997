"""Machine code from LLVM's assembly language, and addresses of its functions in this process."""

from __future__ import annotations

import ctypes
import ctypes.util
import itertools
import logging
import os
import re
import time
from functools import cache
from typing import Any

from linkages.kernel.code.cache import digest_of, kept

LOGGER = logging.getLogger(__name__)

_NUMBERS = itertools.count()  # of libraries: no two have one name
_DEFINED = re.compile(r"^define (?:i64|void) @(\w+)\(", re.MULTILINE)
_DECLARED = re.compile(r"^declare double @(\w+)\(", re.MULTILINE)  # intrinsics have dots
_NEEDED = ("fma", "floor", "rint", "fmod")  # by intrinsics where the processor has no instruction


class MachineCode:
    """A module that has been compiled, in memory as long as this lives.

    Parameters
    ----------
    text
        In LLVM's assembly language.
    """

    def __init__(self, text: str) -> None:
        begin = time.perf_counter()
        key = "\n".join([*_host(), text])
        image, known = kept(key, ".o", lambda: _compiled(text))
        library = _llvm().JITLibraryBuilder().add_object_img(image)
        for name in _DEFINED.findall(text):
            library.export_symbol(name)
        for name in (*_DECLARED.findall(text), *_NEEDED):
            library.import_symbol(name, _library_function(name))
        self._held = library.link(_linker(), f"{digest_of(key)}-{next(_NUMBERS)}")
        how = "was known" if known else "is new and was compiled"
        LOGGER.info("kernel %s %s, %.2f s", digest_of(key), how, time.perf_counter() - begin)

    def address(self, name: str) -> int:
        """Address of one of its functions."""
        return int(self._held[name])


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


def _target() -> Any:
    llvm = _llvm()
    _, name, features = _host()
    target = llvm.Target.from_default_triple()
    return target.create_target_machine(cpu=name, features=features, opt=2, jit=True)


@cache
def _linker() -> Any:
    return _llvm().create_lljit_compiler(_target())


def _compiled(text: str) -> bytes:
    module = _llvm().parse_assembly(text)
    module.verify()
    return bytes(_target().emit_object(module))


@cache
def _library_function(name: str) -> int:
    """Address of a function of the C library."""
    found = ctypes.util.find_library("m") or ("ucrtbase" if os.name == "nt" else None)
    library = ctypes.CDLL(found)
    return int(ctypes.cast(getattr(library, name), ctypes.c_void_p).value or 0)
