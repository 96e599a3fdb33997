"""Which outputs a solution can have, and which it has unless others are asked for."""

from __future__ import annotations

from collections.abc import Iterable

from linkages.kernel.outputs import VARIABLES, Variable, labels
from linkages.kernel.system import System
from linkages.reading.wording import suggestion

_ERRORS = {
    f"slider_{name}_error": Variable(
        ("slider",), units, f"{words} error against the ideal mechanism", lambda _: []
    )
    for name, units, words in (
        ("position", "m", "displacement"),
        ("velocity", "m/s", "velocity"),
        ("acceleration", "m/s^2", "acceleration"),
    )
}

REACTION = "joint_reaction"

DERIVED: dict[str, Variable] = {
    **_ERRORS,
    REACTION: Variable(("joint", "axis"), "N", "joint reaction", lambda _: []),
    "energy_residual": Variable(
        (), "J", "energy gained beyond the work of drives and loads", lambda _: []
    ),
}
"""Outputs that need more than the motion at one time."""

ALL = {**VARIABLES, **DERIVED}

DEFAULT = (
    "bar_angle",
    "bar_speed",
    "bar_acceleration",
    "slider_position",
    "slider_velocity",
    "slider_acceleration",
    *_ERRORS,
    "clearance_angle",
    "clearance_speed",
    "clearance_acceleration",
    "clearance_force",
    "joint_position",
    "joint_velocity",
    "joint_acceleration",
    "drive_effort",
    "load_force",
    "load_torque",
    "closure_residual",
)
"""Kinematics, efforts and loads."""


def requested(system: System, outputs: Iterable[str] | None) -> list[str]:
    """The outputs to compute: what was asked for, or the default set that the mechanism has.

    Raises
    ------
    ValueError
        For names that are no output, or that this mechanism does not have.
    """
    if outputs is None:
        return [name for name in DEFAULT if _has(system, name)]
    names = list(ALL) if outputs == "all" else [outputs] if isinstance(outputs, str) else [*outputs]
    unknown = [name for name in names if name not in ALL]
    if unknown:
        near = suggestion(unknown[0], ALL)
        raise ValueError(f"unknown output {unknown[0]!r}{near or '; expected: ' + ', '.join(ALL)}")
    missing = [name for name in names if not _has(system, name)]
    if missing and outputs != "all":
        raise ValueError(f"this mechanism has no {missing[0]}")
    return [name for name in dict.fromkeys(names) if name not in missing]


def available(system: System) -> list[str]:
    """All outputs that a mechanism has."""
    return [name for name in ALL if _has(system, name)]


def _has(system: System, name: str) -> bool:
    if name in _ERRORS and not labels(system.model, "clearance"):
        return False
    return all(labels(system.model, dim) for dim in ALL[name].dims)
