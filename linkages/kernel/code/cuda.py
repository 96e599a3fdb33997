"""NVIDIA's driver: kernels in PTX on a graphics processor, through the driver's interface in C.

References
----------
NVIDIA: CUDA Driver API Reference Manual (``cuInit``, ``cuModuleLoadData``, ``cuLaunchKernel``).
"""

from __future__ import annotations

import ctypes
import os
from ctypes import byref, c_char_p, c_int, c_size_t, c_uint, c_uint64, c_void_p
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.errors import LinkagesError

THREADS = 64
"""Of a block: few, so that each may have many registers."""

_LIBRARY = "nvcuda.dll" if os.name == "nt" else "libcuda.so.1"


class DeviceError(LinkagesError):
    """There is no graphics processor, or it refused something."""


class Device:
    """The first graphics processor, with the kernels of a module; a context manager.

    Parameters
    ----------
    text
        In PTX.

    Raises
    ------
    DeviceError
        There is no driver, no processor, or the driver cannot compile the text.
    """

    def __init__(self, text: str) -> None:
        self._context, self._module, number = c_void_p(), c_void_p(), c_int()
        self._arrays: list[c_uint64] = []
        _call("cuInit", c_uint(0))
        _call("cuDeviceGet", byref(number), c_int(0))
        _call("cuCtxCreate_v2", byref(self._context), c_uint(0), number)
        try:
            _call("cuModuleLoadData", byref(self._module), c_char_p(text.encode()))
        except DeviceError:
            self.close()
            raise

    def __enter__(self) -> Device:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free all arrays and the module."""
        for array in self._arrays:
            _call("cuMemFree_v2", array)
        self._arrays.clear()
        _call("cuCtxDestroy_v2", self._context)

    def put(self, values: NDArray[Any]) -> c_uint64:
        """Address of a copy of an array on the processor."""
        values = np.ascontiguousarray(values)
        address = c_uint64()
        _call("cuMemAlloc_v2", byref(address), c_size_t(values.nbytes))
        self._arrays.append(address)
        source = c_void_p(values.ctypes.data)
        _call("cuMemcpyHtoD_v2", address, source, c_size_t(values.nbytes))
        return address

    def get(self, address: c_uint64, into: NDArray[Any]) -> None:
        """Copy an array from the processor, when all kernels have ended."""
        if not into.flags.c_contiguous:
            raise ValueError("expected an array without gaps to copy into")
        size = c_size_t(into.nbytes)
        _call("cuMemcpyDtoH_v2", c_void_p(into.ctypes.data), address, size)

    def run(self, kernel: str, arrays: list[c_uint64], count: int) -> None:
        """Start a kernel for some states.

        Parameters
        ----------
        kernel
            Its name in the module.
        arrays
            Addresses of its arguments, in their order.
        count
            Number of states, its last argument.
        """
        function = c_void_p()
        _call("cuModuleGetFunction", byref(function), self._module, c_char_p(kernel.encode()))
        given = [*arrays, c_uint64(count)]
        pointers = (c_void_p * len(given))(*(ctypes.addressof(value) for value in given))
        blocks = -(-count // THREADS)
        sizes = (blocks, 1, 1, THREADS, 1, 1, 0)  # of the grid, of a block, of shared memory
        _call("cuLaunchKernel", function, *map(c_uint, sizes), None, pointers, None)


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
    except OSError as error:
        raise DeviceError(
            f"no driver of an NVIDIA graphics processor was found ({_LIBRARY}); "
            "expected a machine that has one, or a run on the processor"
        ) from error
