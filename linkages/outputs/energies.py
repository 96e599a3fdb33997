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


def _kinetic_energy(model: Model) -> list[Scalar]:
    return [0.5 * model.inertia.product(model.velocities, model.velocities)]


def _potential_energy(model: Model) -> list[Scalar]:
    return [model.potential_energy]


def _drive_power(model: Model) -> list[Scalar]:
    return [model.driven_power]


def _load_power(model: Model) -> list[Scalar]:
    return [model.load_power]


def _forces(twists: bool) -> Callable[[Model], list[Scalar]]:
    return lambda model: [nodes.force for nodes in model.ends if nodes.end.twists == twists]


OUTPUTS = {
    "drive_effort": Variable(
        ("drive",), "N m", "driving torque", _efforts, ("N", "driving force"), default=True
    ),
    "kinetic_energy": Variable((), "J", "kinetic energy", _kinetic_energy),
    "potential_energy": Variable((), "J", "potential energy", _potential_energy),
    "drive_power": Variable((), "W", "power of all drives", _drive_power),
    "load_power": Variable((), "W", "power of all loads", _load_power),
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
