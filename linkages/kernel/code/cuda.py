"""NVIDIA's driver: kernels in PTX on a graphics processor, through the driver's interface in C.

References
----------
NVIDIA: CUDA Driver API Reference Manual (``cuInit``, ``cuModuleLoadDataEx``, ``cuLaunchKernel``).
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Sequence
from ctypes import byref, c_char_p, c_int, c_size_t, c_uint, c_uint64, c_void_p
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.errors import LinkagesError

THREADS = 64
"""Of a block: few, so that each may have many registers."""

LEAST_CAPABILITY = 6, 0
"""Of processors that LLVM and today's drivers know."""

_LATEST = 8, 0
"""For which code is written at most: processors that came later run it as well."""

_LIBRARY = "nvcuda.dll" if os.name == "nt" else "libcuda.so.1"
_LOG = 8192  # bytes of what the driver says of a text
# numbers of the driver's interface
_SLEEP_WHILE_WAITING = 4
_MULTIPROCESSORS, _RESIDENT, _MAJOR, _MINOR = 16, 39, 75, 76
_LOCAL, _REGISTERS = 3, 4
_ERROR_LOG, _ERROR_LOG_SIZE = 5, 6


class DeviceError(LinkagesError):
    """There is no graphics processor, or it refused something."""


class Device:
    """A graphics processor; a context manager. Any thread may use it, one at a time.

    Parameters
    ----------
    number
        Which of several.

    Attributes
    ----------
    name
        As its maker calls it.
    architecture
        That code for it is written for.
    multiprocessors, resident
        How many it has, and most threads on each.

    Raises
    ------
    DeviceError
        There is no driver, no processor, or it is too old.
    """

    def __init__(self, number: int = 0) -> None:
        self._context, self._device = c_void_p(), c_int()
        count, name = c_int(), ctypes.create_string_buffer(256)
        _call("cuInit", c_uint(0))
        _call("cuDeviceGetCount", byref(count))
        if not count.value:
            raise DeviceError("the driver knows no graphics processor; expected one of NVIDIA")
        _call("cuDeviceGet", byref(self._device), c_int(number))
        _call("cuDeviceGetName", name, c_int(len(name)), self._device)
        self.name = name.value.decode(errors="replace")
        capability = self._number(_MAJOR), self._number(_MINOR)
        if capability < LEAST_CAPABILITY:
            found, least = (".".join(map(str, c)) for c in (capability, LEAST_CAPABILITY))
            raise DeviceError(f"{self.name} has compute capability {found}; expected {least}")
        major, minor = min(capability, _LATEST)
        self.architecture = f"sm_{major}{minor}"
        self.multiprocessors = self._number(_MULTIPROCESSORS)
        self.resident = self._number(_RESIDENT)
        _call("cuCtxCreate_v2", byref(self._context), c_uint(_SLEEP_WHILE_WAITING), self._device)

    def _number(self, attribute: int) -> int:
        found = c_int()
        _call("cuDeviceGetAttribute", byref(found), c_int(attribute), self._device)
        return found.value

    def __enter__(self) -> Device:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Give back all that it holds."""
        if self._context:
            _call("cuCtxDestroy_v2", self._context)
        self._context = c_void_p()

    @property
    def free(self) -> int:
        """Bytes of its memory that nobody has."""
        free, whole = c_size_t(), c_size_t()
        self._call("cuMemGetInfo_v2", byref(free), byref(whole))
        return free.value

    def load(self, text: str, name: str) -> DeviceKernel:
        """A kernel of a text in PTX, which the driver compiles.

        Raises
        ------
        DeviceError
            The driver cannot; its message has what it says of the text.
        """
        module, function = c_void_p(), c_void_p()
        log = ctypes.create_string_buffer(_LOG)
        options = (c_int * 2)(_ERROR_LOG, _ERROR_LOG_SIZE)
        values = (c_void_p * 2)(ctypes.addressof(log), _LOG)
        code = c_char_p(text.encode())
        try:
            self._call("cuModuleLoadDataEx", byref(module), code, c_uint(2), options, values)
        except DeviceError as error:
            said = log.value.decode(errors="replace").strip()
            raise DeviceError(f"{error}\n{said}".strip()) from None
        self._call("cuModuleGetFunction", byref(function), module, c_char_p(name.encode()))
        return DeviceKernel(self, function)

    def reserve(self, size: int) -> int:
        """Address of so many bytes; `release` gives them back."""
        address = c_uint64()
        self._call("cuMemAlloc_v2", byref(address), c_size_t(max(1, size)))
        return address.value

    def release(self, addresses: Sequence[int]) -> None:
        """Give back memory."""
        for address in addresses:
            self._call("cuMemFree_v2", c_uint64(address))

    def put(self, values: NDArray[Any], address: int) -> None:
        """Copy an array to the processor."""
        values = np.ascontiguousarray(values)
        source, size = c_void_p(values.ctypes.data), c_size_t(values.nbytes)
        self._call("cuMemcpyHtoD_v2", c_uint64(address), source, size)

    def get(self, address: int, into: NDArray[Any]) -> None:
        """Copy an array from the processor, when all kernels have ended."""
        if not into.flags.c_contiguous:
            raise ValueError("expected an array without gaps to copy into")
        target, size = c_void_p(into.ctypes.data), c_size_t(into.nbytes)
        self._call("cuMemcpyDtoH_v2", target, c_uint64(address), size)

    def _call(self, name: str, *arguments: Any) -> None:
        """Call a function of the driver for this processor, which belongs to no thread."""
        _call("cuCtxSetCurrent", self._context)
        _call(name, *arguments)


class DeviceKernel:
    """A kernel that a graphics processor has loaded; `Device.load` makes it.

    Attributes
    ----------
    registers, local
        Of a thread: registers, and bytes of memory of its own.
    threads
        How many the processor runs at the same time.
    """

    def __init__(self, device: Device, function: c_void_p) -> None:
        self._device, self._function = device, function
        self.registers, self.local = self._number(_REGISTERS), self._number(_LOCAL)
        blocks = c_int()
        device._call(
            "cuOccupancyMaxActiveBlocksPerMultiprocessor",
            byref(blocks), function, c_int(THREADS), c_size_t(0),
        )  # fmt: skip
        self.threads = device.multiprocessors * blocks.value * THREADS

    def _number(self, attribute: int) -> int:
        found = c_int()
        self._device._call("cuFuncGetAttribute", byref(found), c_int(attribute), self._function)
        return found.value

    def run(self, arguments: Sequence[int], count: int) -> None:
        """Run some threads, and wait for them.

        Parameters
        ----------
        arguments
            Addresses and integers, in the order of the kernel's.
        count
            Number of threads, its last argument.
        """
        given = [*map(c_uint64, arguments), c_uint64(count)]
        pointers = (c_void_p * len(given))(*(ctypes.addressof(value) for value in given))
        # of the grid, of a block, of shared memory
        sizes = (-(-count // THREADS), 1, 1, THREADS, 1, 1, 0)
        call = self._device._call
        call("cuLaunchKernel", self._function, *map(c_uint, sizes), None, pointers, None)
        call("cuCtxSynchronize")


def _call(name: str, *arguments: Any) -> None:
    """Call a function of the driver."""
    driver = _driver()
    status = getattr(driver, name)(*arguments)
    if status == 0:
        return
    text = c_char_p()
    driver.cuGetErrorString(c_int(status), byref(text))
    said = (text.value or b"an unknown error").decode()
    raise DeviceError(f"the driver of the graphics processor refused {name} ({status}): {said}")


@cache
def _driver() -> Any:
    try:
        return ctypes.CDLL(_LIBRARY)
    except OSError:
        raise DeviceError(
            f"no driver of an NVIDIA graphics processor was found ({_LIBRARY}); "
            "expected a machine that has one, or a computation on the CPU"
        ) from None
