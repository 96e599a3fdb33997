"""Dynamics of planar linkages, from one definition file to a labelled solution.

>>> import linkages
>>> mechanism = linkages.load("ninebar.yaml", set={"clearances.r1.size": 1e-4})
>>> solution = linkages.simulate(mechanism, end=2.0)
>>> solution.data  # doctest: +SKIP
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from linkages.components.assembly import AssemblyHint
    from linkages.components.bar import Bar
    from linkages.components.clearance import Clearance
    from linkages.components.definition import load
    from linkages.components.drive import Drive
    from linkages.components.free import FreeAngle, FreePosition
    from linkages.components.gravity import UniformGravity
    from linkages.components.ground import GroundJoint
    from linkages.components.load import SliderForce
    from linkages.components.mechanism import Mechanism
    from linkages.components.plate import Plate
    from linkages.components.simulation import SimulationDefaults
    from linkages.components.slider import Slider
    from linkages.errors import ComputationError, InputError, LinkagesError
    from linkages.solution.simulate import simulate
    from linkages.solution.solution import IncompleteError, Solution

# Names are imported when they are first used: `import linkages` and `--help` stay fast.
_HOMES = {
    "AssemblyHint": "linkages.components.assembly",
    "Bar": "linkages.components.bar",
    "Clearance": "linkages.components.clearance",
    "ComputationError": "linkages.errors",
    "Drive": "linkages.components.drive",
    "FreeAngle": "linkages.components.free",
    "FreePosition": "linkages.components.free",
    "GroundJoint": "linkages.components.ground",
    "IncompleteError": "linkages.solution.solution",
    "InputError": "linkages.errors",
    "LinkagesError": "linkages.errors",
    "Mechanism": "linkages.components.mechanism",
    "Plate": "linkages.components.plate",
    "SimulationDefaults": "linkages.components.simulation",
    "Slider": "linkages.components.slider",
    "SliderForce": "linkages.components.load",
    "Solution": "linkages.solution.solution",
    "UniformGravity": "linkages.components.gravity",
    "load": "linkages.components.definition",
    "simulate": "linkages.solution.simulate",
}

__all__ = [
    "AssemblyHint",
    "Bar",
    "Clearance",
    "ComputationError",
    "Drive",
    "FreeAngle",
    "FreePosition",
    "GroundJoint",
    "IncompleteError",
    "InputError",
    "LinkagesError",
    "Mechanism",
    "Plate",
    "SimulationDefaults",
    "Slider",
    "SliderForce",
    "Solution",
    "UniformGravity",
    "load",
    "simulate",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("linkages")
    if name not in _HOMES:
        raise AttributeError(f"module 'linkages' has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
