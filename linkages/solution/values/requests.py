"""Which outputs a solution can have, and which it has unless others are asked for."""

from __future__ import annotations

from collections.abc import Iterable

from linkages.kernel.outputs import VARIABLES, labels
from linkages.kernel.system import System
from linkages.reading.wording import suggestion

REACTION = "joint_reaction"
PIN = "pin_reaction"
REACTIONS = (REACTION, PIN)
"""Outputs that follow from the forces on all bodies at one time."""

STATE = "clearance_state"
LOSS = "impact_loss"
TOUCHES = "touches"
DISSIPATION = ("clearance_normal_dissipation", "clearance_friction_dissipation")


def requested(system: System, outputs: Iterable[str] | None) -> list[str]:
    """The outputs to compute: what was asked for, or the default set that the mechanism has.

    Raises
    ------
    ValueError
        For names that are no output, or that this mechanism does not have.
    """
    if outputs is None:
        return [name for name in available(system) if VARIABLES[name].default]
    if outputs == "all":
        return available(system)
    if not isinstance(outputs, Iterable):
        raise TypeError(f"outputs must be names, or 'all', found {outputs!r}")
    names = outputs.split(",") if isinstance(outputs, str) else [*outputs]
    own = available(system)
    for name in names:
        expected = f"; expected: {', '.join(own)}"
        if name not in VARIABLES:
            raise ValueError(f"unknown output {name!r}{suggestion(name, own) or expected}")
        if name not in own:
            raise ValueError(f"this mechanism has no {name}{expected}")
    if REACTION in names and PIN in own:  # of several bodies at a pin it shows the first
        names.insert(names.index(REACTION) + 1, PIN)
    return list(dict.fromkeys(names))


def available(system: System) -> list[str]:
    """All outputs that a mechanism has."""
    return [name for name in VARIABLES if _has(system, name)]


def _has(system: System, name: str) -> bool:
    variable = VARIABLES[name]
    if variable.compared and not labels(system.model, "clearance"):
        return False
    if variable.opening and not system.model.contacts:
        return False
    return all(labels(system.model, dim) for dim in variable.dims)
