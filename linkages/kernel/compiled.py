"""A compiled kernel: addresses of machine code and the array that it works on."""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType

import numpy as np

from linkages.kernel.cache import cached_module
from linkages.kernel.program import Program


@dataclass(frozen=True)
class CompiledKernel:
    """Machine code of one topology, bound to the numbers of one mechanism.

    Parameters
    ----------
    module
        The generated module; keeps the machine code alive.
    parameters
        Parameters, followed by what `prepare` derived from them.
    timed
        Number of values that depend on time alone.
    """

    module: ModuleType
    parameters: np.ndarray
    timed: int

    @property
    def clock(self) -> int:
        """Address of ``clock(t, p, timed)``."""
        return self.module.clock.address

    @property
    def rates(self) -> int:
        """Address of ``rates(y, p, timed, out)``."""
        return self.module.rates.address


def compile_kernel(program: Program, parameters: np.ndarray) -> CompiledKernel:
    """Compile a program (or take it from the cache) and prepare it for some numbers.

    Parameters
    ----------
    program
        The printed kernel.
    parameters
        Values in the order of the model's inputs, shape (parameters,).
    """
    module = cached_module(program.text)
    values = np.zeros(max(1, sum(program.parameters)))
    values[: program.parameters[0]] = parameters
    module.prepare.ctypes(_double_pointer(values))
    return CompiledKernel(module, values, program.timed)


def _double_pointer(values: np.ndarray) -> object:
    import ctypes

    return values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
