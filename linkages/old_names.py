"""Modules under the names that they had up to version 0.1, for one release.

They are those that pages named, from which plug-ins and scripts import.
"""

from __future__ import annotations

import sys
import warnings
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

MOVED = {
    "chaos.verdicts.findings": "chaos.findings",
    "components.contributed.listed": "components.contributed.component",
    "components.contributed.measures": "components.contributed.load_measures",
    "components.contributed.references": "components.contributed.component",
    "components.contributed.restitutions": "components.contributed.normal_forces",
    "components.load": "components.external_loads",
    "components.mechanisms.schema": "components.mechanisms.registry",
    "components.spring": "components.springs",
    "kernel.code.llvm": "kernel.code.writer",
    "kernel.code.printed": "kernel.code.procedure",
    "kernel.code.ptx": "kernel.code.cuda",
    "kernel.numbers.layout": "kernel.layout",
    "solution.functions.propagator": "solution.propagator",
    "solution.moving.many": "solution.many",
    "solution.moving.march": "solution.march",
    "solution.moving.plan": "solution.plan",
    "solution.opened": "opened",
    "solvers.coefficients.tableau": "solvers.tableau",
    "solvers.methods.collocation": "solvers.method",
    "solvers.methods.explicit": "solvers.explicit_methods",
    "solvers.methods.method": "solvers.method",
}
"""Old path → new path, without the name of the package."""

GONE = (
    "chaos.verdicts",
    "kernel.numbers",
    "solution.functions",
    "solution.moving",
    "solvers.coefficients",
    "solvers.methods",
)
"""Packages of old paths. They have nothing but these, so that no module is loaded twice."""


class MovedModules(MetaPathFinder, Loader):
    """Finds a module by its old name: the same module object, with a warning."""

    def find_spec(self, fullname: str, *_: Any) -> ModuleSpec | None:
        """Return a specification for old names only."""
        old = fullname.removeprefix("linkages.")
        if old in GONE:
            return ModuleSpec(fullname, None, is_package=True)  # a namespace without folders
        return ModuleSpec(fullname, self) if old in MOVED else None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """Return the module under its new name."""
        new = f"linkages.{MOVED[spec.name.removeprefix('linkages.')]}"
        message = f"{spec.name} is now {new}; the old name goes with the next release"
        warnings.warn(message, DeprecationWarning, stacklevel=2)
        module = import_module(new)
        spec.loader_state = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Leave the module as it was: importing has replaced its specification."""
        assert module.__spec__ is not None
        module.__spec__ = module.__spec__.loader_state


def keep_old_names() -> None:
    """Let modules be imported by their old names."""
    sys.meta_path.insert(0, MovedModules())
