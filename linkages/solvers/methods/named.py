"""The methods that `integrate` knows, by name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from linkages.solvers.methods.dop853 import DOP853
from linkages.solvers.methods.gauss8 import GAUSS8
from linkages.solvers.methods.method import Method
from linkages.solvers.methods.radau import RADAU
from linkages.solvers.methods.rk4 import RK4
from linkages.solvers.methods.tsit5 import TSIT5
from linkages.solvers.methods.vern9 import VERN9

METHODS: Mapping[str, Method] = MappingProxyType(
    {method.name: method for method in (DOP853, TSIT5, VERN9, RADAU, RK4, GAUSS8)},
)
ADAPTIVE_METHODS = tuple(name for name, method in METHODS.items() if method.adaptive)
FIXED_STEP_METHODS = tuple(name for name, method in METHODS.items() if not method.adaptive)
