"""Joints: positions, motion, jerk, reactions; forces and torques of loads, springs and dampers."""

from __future__ import annotations

from collections.abc import Callable

from linkages.kernel.differentiation import derivative_along
from linkages.kernel.model import Model
from linkages.kernel.outputs import Variable
from linkages.kernel.scalars import Scalar, section
from linkages.outputs import along_motion, of_each


def _of_joints(field: str) -> Callable[[Model], list[Scalar]]:
    return of_each("joint", lambda model, joint: getattr(model, field).joints[joint])


def _of_loads(dim: str) -> Callable[[Model], list[Scalar]]:
    return lambda model: [load.acting for load in model.loads if load.dimension == dim]


def _jerks(model: Model) -> list[Scalar]:
    """Third derivatives of the positions of all joints, x and y of one after the other.

    Accelerations are functions of time, of the free coordinates and rates, and of the second
    derivatives of these; all of them move along the motion.
    """
    moving, inputs = along_motion(model), model.inputs
    with section("jerks of the free coordinates"):
        rates = derivative_along(model.free_accelerations, [moving])
    moving |= {inputs.acceleration(i).index: rate for i, (rate,) in enumerate(rates)}
    parts = _of_joints("accelerations")(model)
    with section("jerks of joints"):
        return [rate for (rate,) in derivative_along(parts, [moving])]


OUTPUTS = {
    "joint_jerk": Variable(
        ("joint", "axis"), "m/s^3", "joint jerk", _jerks, magnitude=True, jerking=True
    ),
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
    "guide_reaction": Variable(("slider",), "N", "side thrust of a guide", None),
    "guide_moment": Variable(("slider",), "N m", "moment of a guide", None),
    "load_force": Variable(
        ("force",), "N", "load force", _of_loads("force"),
        default=True, smooth=False, unbounded=True,
    ),
    "load_torque": Variable(
        ("torque",), "N m", "load torque", _of_loads("torque"),
        default=True, smooth=False, unbounded=True,
    ),
    "spring_force": Variable(("spring",), "N", "force of a spring or damper", _of_loads("spring")),
    "torsional_spring_torque": Variable(
        ("torsional_spring",),
        "N m",
        "torque of a torsional spring or damper",
        _of_loads("torsional_spring"),
    ),
}  # fmt: skip
