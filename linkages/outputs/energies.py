"""Efforts of drives, energies, powers and their balance; forces of stops and losses of impacts."""

from __future__ import annotations

from collections.abc import Callable

from linkages.kernel.model import Model
from linkages.kernel.outputs import Variable
from linkages.kernel.scalars import Scalar


def _efforts(model: Model) -> list[Scalar]:
    if not model.actuators:
        return model.required_forces(model.accelerations, model.topology.driven, model.acting)
    return [model.required_force(model.accelerations, partial) for partial in model.drive_partials]


def _forces(twists: bool) -> Callable[[Model], list[Scalar]]:
    return lambda model: [nodes.force for nodes in model.ends if nodes.end.twists == twists]


OUTPUTS = {
    "drive_effort": Variable(
        ("drive",), "N m", "driving torque", _efforts, ("N", "driving force"), default=True
    ),
    "kinetic_energy": Variable(
        (), "J", "kinetic energy", lambda m: [0.5 * m.inertia.product(m.velocities, m.velocities)],
    ),
    "potential_energy": Variable((), "J", "potential energy", lambda m: [m.potential_energy]),
    "drive_power": Variable((), "W", "power of all drives", lambda m: [m.driven_power]),
    "load_power": Variable((), "W", "power of all loads", lambda m: [m.load_power]),
    "energy_residual": Variable(
        (), "J", "energy gained beyond the work of drives and loads", None,
        smooth=False, noise=True,
    ),
    "stop_force": Variable(
        ("stop",), "N", "force of a stop that rests", _forces(False),
        default=True, smooth=False, unbounded=True,
    ),
    "stop_torque": Variable(
        ("torsional_stop",), "N m", "torque of a stop that rests", _forces(True),
        default=True, smooth=False, unbounded=True,
    ),
    "impact_loss": Variable(
        ("contact",), "J", "energy that rigid impacts have lost", None, smooth=False
    ),
    "touches": Variable(("touch",), "1", "touches since the start", None, smooth=False),
}  # fmt: skip
