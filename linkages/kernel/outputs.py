"""Output variables that follow from time, state and accelerations: one entry each.

A variable is a list of nodes of the model, so what is not asked for is not computed, and the same
nodes serve NumPy (samples) and compiled code.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from linkages.kernel.model import Model
from linkages.kernel.scalars import Scalar
from linkages.kernel.vectors import Vector
from linkages.topology.jacobian import ground_loop

AXES = ("x", "y")


@dataclass(frozen=True)
class Variable:
    """An output.

    Parameters
    ----------
    dims
        Dimensions beside time.
    units, long_name
        For labels.
    nodes
        The model → one node per element, the last dimension running fastest.
    """

    dims: tuple[str, ...]
    units: str
    long_name: str
    nodes: Callable[[Model], list[Scalar]]


def labels(model: Model, dim: str) -> tuple[str, ...]:
    """Coordinate labels of a dimension."""
    if dim == "axis":
        return AXES
    if dim == "joint":
        return model.topology.joints
    if dim == "drive":
        return model.topology.driven
    kinds = {"bar": ("bar", "plate"), "slider": ("slider",), "clearance": ("clearance",)}[dim]
    return tuple(n for n, body in model.mechanism.bodies.items() if body.kind in kinds)


def _angle(model: Model, name: str) -> Scalar:
    """A driven or free angle as it is; a dependent one in [−π, π]."""
    if name in model.topology.driven:
        return model.positions.prescribed(name)[0]
    if name in model.topology.free:
        return model.inputs.coordinate(model.topology.free.index(name))
    unit = model.positions.unit(name)
    return model.graph.atan2(unit.y, unit.x)


def _components(vectors: Sequence[Vector]) -> list[Scalar]:
    return [component for vector in vectors for component in (vector.x, vector.y)]


def _of_bodies(dim: str, field: str) -> Callable[[Model], list[Scalar]]:
    return lambda model: [getattr(model, field).bodies[name] for name in labels(model, dim)]


def _of_joints(field: str) -> Callable[[Model], list[Scalar]]:
    return lambda model: _components(
        [getattr(model, field).joints[joint] for joint in labels(model, "joint")]
    )


def _angles(dim: str) -> Callable[[Model], list[Scalar]]:
    return lambda model: [_angle(model, name) for name in labels(model, dim)]


def _efforts(model: Model) -> list[Scalar]:
    return [
        model.required_force(model.accelerations, model.partial(name))
        for name in model.topology.driven
    ]


def _clearance_forces(model: Model) -> list[Scalar]:
    """Tension: the force that would be needed to lengthen the link, reversed."""
    return [
        -model.required_force(model.accelerations, model.partial(name, stretch=name))
        for name in labels(model, "clearance")
    ]


def _kinetic_energy(model: Model) -> list[Scalar]:
    return [0.5 * model.inertia.product(model.velocities, model.velocities)]


def _potential_energy(model: Model) -> list[Scalar]:
    return [-model.gravity.dot(model.inertia.moment_of_mass())]


def _drive_power(model: Model) -> list[Scalar]:
    rates = [model.known_rates[name] for name in model.topology.driven]
    powers = (effort * rate for effort, rate in zip(_efforts(model), rates, strict=True))
    return [model.graph.total(powers)]


def _load_power(model: Model) -> list[Scalar]:
    return [model.load_power]


def _closure(model: Model) -> list[Scalar]:
    """Both components of Φ for every loop, from the angles and displacements themselves."""

    def along(body: str, start: str | None, end: str | None) -> Vector:
        guide = model.mechanism.bodies[body].guide
        if guide is not None:
            place = model.positions.axis(guide) * model.positions.displacements[body]
            place = place + model.positions.origin(guide)
            return place if start is None else -place
        assert start is not None
        assert end is not None
        angle = _angle(model, body)
        unit = Vector(model.graph.cos(angle), model.graph.sin(angle))
        return unit.times(model.positions.in_frame(body, start, end))

    residuals = []
    for loop in (loop for block in model.topology.solved_blocks for loop in block.loops):
        total = Vector(model.graph.zero, model.graph.zero)
        for sign, way in zip((1.0, -1.0), ground_loop(model.topology, loop), strict=True):
            if way and way[0].start in model.mechanism.ground:
                total = total + model.positions.joints[way[0].start] * sign
            for step in way:
                total = total + along(step.body, step.start, step.end) * sign
        residuals.append(total)
    return _components(residuals)


VARIABLES: dict[str, Variable] = {
    "bar_angle": Variable(("bar",), "rad", "angle", _angles("bar")),
    "bar_speed": Variable(("bar",), "rad/s", "angular speed", _of_bodies("bar", "velocities")),
    "bar_acceleration": Variable(
        ("bar",), "rad/s^2", "angular acceleration", _of_bodies("bar", "accelerations")
    ),
    "slider_position": Variable(
        ("slider",),
        "m",
        "displacement",
        lambda m: [m.positions.displacements[name] for name in labels(m, "slider")],
    ),
    "slider_velocity": Variable(("slider",), "m/s", "velocity", _of_bodies("slider", "velocities")),
    "slider_acceleration": Variable(
        ("slider",), "m/s^2", "acceleration", _of_bodies("slider", "accelerations")
    ),
    "clearance_angle": Variable(("clearance",), "rad", "clearance angle", _angles("clearance")),
    "clearance_speed": Variable(
        ("clearance",), "rad/s", "clearance speed", _of_bodies("clearance", "velocities")
    ),
    "clearance_acceleration": Variable(
        ("clearance",),
        "rad/s^2",
        "clearance acceleration",
        _of_bodies("clearance", "accelerations"),
    ),
    "clearance_force": Variable(
        ("clearance",), "N", "force along the clearance link", _clearance_forces
    ),
    "joint_position": Variable(("joint", "axis"), "m", "joint position", _of_joints("positions")),
    "joint_velocity": Variable(
        ("joint", "axis"), "m/s", "joint velocity", _of_joints("velocities")
    ),
    "joint_acceleration": Variable(
        ("joint", "axis"), "m/s^2", "joint acceleration", _of_joints("accelerations")
    ),
    "drive_effort": Variable(("drive",), "N m", "driving torque", _efforts),
    "kinetic_energy": Variable((), "J", "kinetic energy", _kinetic_energy),
    "potential_energy": Variable((), "J", "potential energy", _potential_energy),
    "drive_power": Variable((), "W", "power of all drives", _drive_power),
    "load_power": Variable((), "W", "power of all loads", _load_power),
    "closure_residual": Variable((), "m", "largest residual of the closure equations", _closure),
}
