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
    from linkages.chaos.bifurcation import bifurcation
    from linkages.chaos.lyapunov import lyapunov
    from linkages.chaos.maps import chaos_map
    from linkages.chaos.section import poincare
    from linkages.components.assembly import AssemblyHint
    from linkages.components.bar import Bar
    from linkages.components.clearance import Clearance
    from linkages.components.damper import GuideDamper, LineDamper
    from linkages.components.definition import load, loads
    from linkages.components.drive import Drive, SliderDrive
    from linkages.components.free import FreeAngle, FreePosition
    from linkages.components.gear import Gear
    from linkages.components.gravity import UniformGravity
    from linkages.components.ground import GroundJoint
    from linkages.components.load import JointForce, SliderForce
    from linkages.components.mass import JointMass
    from linkages.components.mechanism import Mechanism
    from linkages.components.plate import Plate
    from linkages.components.simulation import SimulationDefaults
    from linkages.components.slider import Slider
    from linkages.components.spring import JointSpring
    from linkages.components.torque import BarTorque, TorqueBetweenBars
    from linkages.components.torsional_damper import ClearanceDamper, DamperBetweenBars, JointDamper
    from linkages.components.torsional_spring import BarSpring, SpringBetweenBars
    from linkages.components.weld import Weld
    from linkages.errors import ComputationError, InputError, Interrupted, LinkagesError
    from linkages.plots import charts
    from linkages.plots.animation import animate
    from linkages.solution.opened import Opened, open  # noqa: A004
    from linkages.solution.propagator import Propagator
    from linkages.solution.rhs import Equations, compile  # noqa: A004
    from linkages.solution.simulate import simulate
    from linkages.solution.solution import IncompleteError, Solution

# Names are imported when they are first used: `import linkages` and `--help` stay fast.
_HOMES = {
    "open": "linkages.solution.opened",
    "compile": "linkages.solution.rhs",
    "Propagator": "linkages.solution.propagator",
    "Opened": "linkages.solution.opened",
    "Equations": "linkages.solution.rhs",
    "AssemblyHint": "linkages.components.assembly",
    "Bar": "linkages.components.bar",
    "BarSpring": "linkages.components.torsional_spring",
    "BarTorque": "linkages.components.torque",
    "Clearance": "linkages.components.clearance",
    "ClearanceDamper": "linkages.components.torsional_damper",
    "ComputationError": "linkages.errors",
    "DamperBetweenBars": "linkages.components.torsional_damper",
    "Drive": "linkages.components.drive",
    "FreeAngle": "linkages.components.free",
    "FreePosition": "linkages.components.free",
    "Gear": "linkages.components.gear",
    "GroundJoint": "linkages.components.ground",
    "GuideDamper": "linkages.components.damper",
    "IncompleteError": "linkages.solution.solution",
    "InputError": "linkages.errors",
    "Interrupted": "linkages.errors",
    "JointDamper": "linkages.components.torsional_damper",
    "JointForce": "linkages.components.load",
    "JointMass": "linkages.components.mass",
    "JointSpring": "linkages.components.spring",
    "LineDamper": "linkages.components.damper",
    "LinkagesError": "linkages.errors",
    "Mechanism": "linkages.components.mechanism",
    "Plate": "linkages.components.plate",
    "SimulationDefaults": "linkages.components.simulation",
    "Slider": "linkages.components.slider",
    "SliderDrive": "linkages.components.drive",
    "SliderForce": "linkages.components.load",
    "Solution": "linkages.solution.solution",
    "SpringBetweenBars": "linkages.components.torsional_spring",
    "TorqueBetweenBars": "linkages.components.torque",
    "UniformGravity": "linkages.components.gravity",
    "Weld": "linkages.components.weld",
    "animate": "linkages.plots.animation",
    "bifurcation": "linkages.chaos.bifurcation",
    "chaos_map": "linkages.chaos.maps",
    "charts": "linkages.plots",
    "load": "linkages.components.definition",
    "loads": "linkages.components.definition",
    "lyapunov": "linkages.chaos.lyapunov",
    "poincare": "linkages.chaos.section",
    "simulate": "linkages.solution.simulate",
}

__all__ = [
    "AssemblyHint",
    "Bar",
    "BarSpring",
    "BarTorque",
    "Clearance",
    "ClearanceDamper",
    "ComputationError",
    "DamperBetweenBars",
    "Drive",
    "Equations",
    "FreeAngle",
    "FreePosition",
    "Gear",
    "GroundJoint",
    "GuideDamper",
    "IncompleteError",
    "InputError",
    "Interrupted",
    "JointDamper",
    "JointForce",
    "JointMass",
    "JointSpring",
    "LineDamper",
    "LinkagesError",
    "Mechanism",
    "Opened",
    "Plate",
    "Propagator",
    "SimulationDefaults",
    "Slider",
    "SliderDrive",
    "SliderForce",
    "Solution",
    "SpringBetweenBars",
    "TorqueBetweenBars",
    "UniformGravity",
    "Weld",
    "animate",
    "bifurcation",
    "chaos_map",
    "charts",
    "compile",
    "load",
    "loads",
    "lyapunov",
    "open",
    "poincare",
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
