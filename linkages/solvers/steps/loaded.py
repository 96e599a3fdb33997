"""Machine code of the loops: it is kept, and Numba is imported only where there is none."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache, cached_property
from importlib import import_module, metadata
from itertools import chain
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

    @cached_property
    def _code(self) -> MachineCode:
        def written() -> str:
            from linkages.solvers.steps.compiled import exported

            return exported(getattr(import_module(self._module), self._name))

        with _LOADING:
            return MachineCode(f"{version()} {self._module} {self._name}", written)

    @property
    def address(self) -> int:
        """Where its machine code is."""
        return self._code.address(self._name)

    @cached_property
    def function(self) -> Callable[..., Any]:
        """It, with as many integers in place of a named tuple; other threads run meanwhile."""
        return self._code.function(self._name)

    def __call__(self, *arguments: Any) -> int:
        """Call it, with named tuples."""
        spread = (part if isinstance(part, tuple) else (part,) for part in arguments)
        return int(self.function(*chain.from_iterable(spread)))


@cache
def version() -> str:
    """What the machine code of loops depends on: Numba, and all that they may inline."""
    digest = hashlib.sha256(metadata.version("numba").encode())
    for path in sorted(Path(__file__).parents[1].rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


EVALUATE_STATE = Loaded("linkages.solvers.steps.many", "evaluate_state")
EVALUATE_STATES = Loaded("linkages.solvers.steps.many", "evaluate_states")
REPEAT = Loaded("linkages.solvers.steps.many", "repeat")
