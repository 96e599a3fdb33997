"""Machine code of the loops: it is kept, and they are printed only where there is none."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache, cached_property
from importlib import import_module
from pathlib import Path
from threading import RLock
from typing import Any

from linkages.kernel.code import cache as kept_code
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

    @cached_property
    def _code(self) -> MachineCode:
        def written() -> str:
            from linkages.kernel.code.printed import text_of

            return text_of(getattr(import_module(self._module), self._name))

        with _LOADING:
            return MachineCode(f"{version()} {self._module} {self._name}", written)

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


@cache
def version() -> str:
    """What texts of steps and loops depend on: all that takes part in writing them."""
    digest = hashlib.sha256()
    solvers, kernel = Path(__file__).parents[1], Path(kept_code.__file__).parent
    for path in sorted([*solvers.rglob("*.py"), *kernel.glob("*.py")]):
        digest.update(path.read_bytes())
    return digest.hexdigest()


EVALUATE_STATE = Loaded("linkages.solvers.steps.many", "evaluate_state")
EVALUATE_STATES = Loaded("linkages.solvers.steps.many", "evaluate_states")
REPEAT = Loaded("linkages.solvers.steps.many", "repeat")
