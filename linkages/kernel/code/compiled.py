"""A compiled kernel: addresses of machine code and the array that it works on."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import CFUNCTYPE, c_int64, c_void_p
from dataclasses import dataclass
from functools import lru_cache
from types import ModuleType

import numpy as np

from linkages.kernel.code.cache import cached_module
from linkages.kernel.code.program import Program


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


@dataclass(frozen=True)
class Printed:
    """The text of a program with what is needed to call it.

    Parameters
    ----------
    text, parameters, timed
        As `linkages.kernel.code.program.Program` has them.
    """

    text: str
    parameters: tuple[int, int]
    timed: int

    @classmethod
    def of(cls, program: Program) -> Printed:
        """Without the nodes that it was printed from."""
        return cls(program.text, program.parameters, program.timed)


def bind_kernel(program: Program | Printed, parameters: np.ndarray) -> CompiledKernel:
    """Compile a program (or take it from the cache) and prepare it for some numbers.

    Parameters
    ----------
    program
        The printed kernel.
    parameters
        Values in the order of the model's inputs, shape (parameters,).
    """
    module, prepare = _loaded(program.text)
    values = np.zeros(max(1, sum(program.parameters)))
    values[: program.parameters[0]] = parameters
    prepare(values.ctypes.data)
    return CompiledKernel(module, values, program.timed)


@lru_cache(maxsize=256)
def _loaded(text: str) -> tuple[ModuleType, Callable[[int], int]]:
    """The module of a text, which is found without hashing it again, and its ``prepare``."""
    module = cached_module(text)
    call = CFUNCTYPE(c_int64, c_void_p)(module.prepare.address)
    return module, call
