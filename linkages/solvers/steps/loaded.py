"""Machine code of the loops: it is kept, and Numba is imported only where there is none."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache
from importlib import import_module, metadata
from pathlib import Path
from threading import RLock
from typing import Any

from linkages.kernel.code.machine import MachineCode

_LOADING = RLock()


class Loaded:
    """A compiled function that Python calls, or whose address it hands on.

    Parameters
    ----------
    module, name
        Where it stands.
    """

    def __init__(self, module: str, name: str) -> None:
        self._module, self._name = module, name

    @property
    def address(self) -> int:
        """Where its machine code is."""
        return _code(self._module, self._name)[0].address(self._name)

    def __call__(self, *arguments: Any) -> int:
        """Call it, with named tuples spread; other threads run meanwhile."""
        _, function = _code(self._module, self._name)
        flat: list[Any] = []
        for argument in arguments:
            if isinstance(argument, tuple):
                flat += argument
            else:
                flat.append(argument)
        return int(function(*flat))


@cache
def version() -> str:
    """What the machine code of loops depends on: Numba, and all that they may inline."""
    digest = hashlib.sha256(metadata.version("numba").encode())
    for path in sorted(Path(__file__).parents[1].rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _code(module: str, name: str) -> tuple[MachineCode, Callable[..., Any]]:
    with _LOADING:
        return _loaded(module, name)


@cache
def _loaded(module: str, name: str) -> tuple[MachineCode, Callable[..., Any]]:
    def written() -> str:
        from linkages.solvers.steps.compiled import exported

        return exported(getattr(import_module(module), name))

    code = MachineCode(f"{version()} {module} {name}", written)
    return code, code.function(name)


EVALUATE_STATES = Loaded("linkages.solvers.steps.many", "evaluate_states")
REPEAT = Loaded("linkages.solvers.steps.many", "repeat")
