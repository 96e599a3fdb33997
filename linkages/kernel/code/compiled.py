"""A compiled kernel: addresses of machine code and the array that it works on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.program import Program


@dataclass(frozen=True)
class CompiledKernel:
    """Machine code of one topology, bound to the numbers of one mechanism.

    Parameters
    ----------
    code
        Keeps the machine code alive.
    parameters
        Parameters, followed by what `prepare` derived from them.
    timed
        Number of values that depend on time alone.
    held
        Number of modes, and of what is remembered: the last entries of `parameters`.
    """

    code: MachineCode
    parameters: np.ndarray
    timed: int
    held: int = 0

    @property
    def clock(self) -> int:
        """Address of ``clock(t, p, timed)``."""
        return self.code.address("clock")

    @property
    def rates(self) -> int:
        """Address of ``rates(y, p, timed, out)``."""
        return self.code.address("rates")


@dataclass(frozen=True)
class Printed:
    """A program in LLVM's assembly language, with what is needed to call it.

    Parameters
    ----------
    assembly, parameters, timed, held
        As `linkages.kernel.code.program.Program` has them.
    """

    assembly: str
    parameters: tuple[int, int]
    timed: int
    held: int = 0

    @classmethod
    def of(cls, program: Program) -> Printed:
        """Without the nodes that it was printed from."""
        return cls(program.assembly, program.parameters, program.timed, program.held)


def bind_kernel(program: Program | Printed, parameters: np.ndarray) -> CompiledKernel:
    """Compile a program (or take it from the cache) and prepare it for some numbers.

    Parameters
    ----------
    program
        The printed kernel.
    parameters
        Values in the order of the model's inputs, shape (parameters,).
    """
    code, prepare = _loaded(program.assembly)
    values = np.zeros(max(1, sum(program.parameters) + program.held))
    values[: program.parameters[0]] = parameters
    prepare(values.ctypes.data)
    return CompiledKernel(code, values, program.timed, program.held)


@lru_cache(maxsize=256)
def _loaded(assembly: str) -> tuple[MachineCode, Callable[[int], int]]:
    """The machine code of a text, which is found without hashing it again, and its ``prepare``."""
    code = MachineCode(assembly)
    return code, code.function("prepare")
