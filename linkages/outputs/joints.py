"""Joints: where they are, how they move, what they transmit."""

from __future__ import annotations

from collections.abc import Callable

from linkages.kernel.model import Model
from linkages.kernel.outputs import Variable, components, labels
from linkages.kernel.scalars import Scalar


def _of_joints(field: str) -> Callable[[Model], list[Scalar]]:
    return lambda model: components(
        [getattr(model, field).joints[joint] for joint in labels(model, "joint")]
    )


OUTPUTS = {
    "joint_position": Variable(
        ("joint", "axis"), "m", "joint position", _of_joints("positions"),
        default=True, rate="joint_velocity",
    ),
    "joint_velocity": Variable(
        ("joint", "axis"), "m/s", "joint velocity", _of_joints("velocities"),
        default=True, rate="joint_acceleration", magnitude=True,
    ),
    "joint_acceleration": Variable(
        ("joint", "axis"), "m/s^2", "joint acceleration", _of_joints("accelerations"),
        default=True, magnitude=True,
    ),
    "joint_reaction": Variable(
        ("joint", "axis"), "N", "joint reaction", None, magnitude=True
    ),
    "pin_reaction": Variable(
        ("pin", "axis"), "N", "pin reaction", None, magnitude=True
    ),
}  # fmt: skip
