"""Compiled kernels as Python sees them, for methods that step in Python."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

POINTER = ctypes.POINTER(ctypes.c_double)
CLOCK = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_double, POINTER, POINTER)
RATES = ctypes.CFUNCTYPE(ctypes.c_int64, POINTER, POINTER, POINTER, POINTER)


class Kernel(Protocol):
    """What `Flow` and `Companion` have in common."""

    @property
    def clock(self) -> int: ...  # noqa: D102
    @property
    def rates(self) -> int: ...  # noqa: D102
    @property
    def parameters(self) -> NDArray[np.float64]: ...  # noqa: D102
    @property
    def timed_size(self) -> int: ...  # noqa: D102


def caller(kernel: Kernel, size: int) -> Callable[[float, NDArray], tuple[int, NDArray]]:
    """A function of time and state that returns the status and `size` numbers of a kernel."""
    clock, rates = CLOCK(kernel.clock), RATES(kernel.rates)
    parameters, timed = kernel.parameters, np.zeros(max(1, kernel.timed_size))

    def evaluate(t: float, y: NDArray) -> tuple[int, NDArray]:
        state, out = np.ascontiguousarray(y, dtype=np.float64), np.zeros(size)
        status = clock(t, _address(parameters), _address(timed))
        if status == 0:
            status = rates(_address(state), _address(parameters), _address(timed), _address(out))
        return status, out

    return evaluate


def _address(array: NDArray) -> Any:
    return array.ctypes.data_as(POINTER)
