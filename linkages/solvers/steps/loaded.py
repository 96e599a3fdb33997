"""Machine code of the loops: each is printed and loaded where it is first used.

Machine code is kept under the hash of its text, which has all constants that it was printed with.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from importlib import import_module
from threading import RLock
from typing import Any

from linkages.kernel.code.machine import MachineCode

_LOADING = RLock()


class Loaded:
    """A printed function that Python calls, or whose address it hands on.

    Parameters
    ----------
    module, name
        Where it stands.
    """

    def __init__(self, module: str, name: str) -> None:
        self._module, self._name = module, name
        self._kept: MachineCode | None = None

    @property
    def _code(self) -> MachineCode:
        # Loaded once and for all: others have its addresses. From Python 3.12 on two threads may
        # compute a cached property at the same time, and what one of them found is freed.
        with _LOADING:
            if self._kept is None:
                from linkages.kernel.code.printed import text_of

                text = text_of(getattr(import_module(self._module), self._name))
                self._kept = MachineCode(text)
            return self._kept

    @property
    def address(self) -> int:
        """Where its machine code is."""
        return self._code.address(self._name)

    @cached_property
    def function(self) -> Callable[..., Any]:
        """It, with addresses in place of named tuples; other threads run meanwhile."""
        return self._code.function(self._name)

    def __call__(self, *arguments: Any) -> int:
        """Call it."""
        return int(self.function(*arguments))


EVALUATE_STATE = Loaded("linkages.solvers.steps.many", "evaluate_state")
EVALUATE_STATES = Loaded("linkages.solvers.steps.many", "evaluate_states")
REPEAT = Loaded("linkages.solvers.steps.many", "repeat")
