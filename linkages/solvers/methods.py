"""The methods that `integrate` knows, by name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from linkages.solvers.dop853 import DOP853
from linkages.solvers.method import Method
from linkages.solvers.rk4 import RK4

METHODS: Mapping[str, Method] = MappingProxyType(
    {method.name: method for method in (DOP853, RK4)},
)
ADAPTIVE_METHODS = tuple(name for name, method in METHODS.items() if method.adaptive)
FIXED_STEP_METHODS = tuple(name for name, method in METHODS.items() if not method.adaptive)
