"""Jerk: the rate of acceleration, which makes followers bounce and passengers sick."""

from __future__ import annotations

from linkages.kernel.differentiation import derivative_along
from linkages.kernel.model import Model
from linkages.kernel.outputs import Variable
from linkages.kernel.scalars import Scalar, section


def jerks(model: Model) -> list[Scalar]:
    """Third derivatives of the positions of all joints, x and y of one after the other.

    Accelerations are functions of time, of the free coordinates and rates, and of the second
    derivatives of these; all of them move along the motion.
    """
    inputs, free = model.inputs, range(len(model.topology.free))
    moving = {inputs.time.index: model.graph.one}
    moving |= {inputs.coordinate(i).index: inputs.rate(i) for i in free}
    moving |= {inputs.rate(i).index: inputs.acceleration(i) for i in free}
    with section("jerks of the free coordinates"):
        rates = derivative_along(model.free_accelerations, [moving])
    moving |= {inputs.acceleration(i).index: rates[i][0] for i in free}
    vectors = [model.accelerations.joints[joint] for joint in model.topology.joints]
    parts = [part for vector in vectors for part in (vector.x, vector.y)]
    with section("jerks of joints"):
        return [rate for (rate,) in derivative_along(parts, [moving])]


OUTPUTS = {
    "joint_jerk": Variable(
        ("joint", "axis"), "m/s^3", "joint jerk", jerks, magnitude=True, jerking=True
    ),
}  # fmt: skip
