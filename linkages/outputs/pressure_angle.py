"""Pressure angle of cams: how far the force on a follower leans away from the follower's way."""

from __future__ import annotations

from linkages.kernel.model import Model
from linkages.kernel.outputs import Variable
from linkages.kernel.scalars import Scalar


def pressure_angles(model: Model) -> list[Scalar]:
    """Between the normal of a cam and the axis of its follower, which translates on a roller.

    tan φ = (ds/dθ − ε)/(s + √((R_base + R_roller)² − ε²)), R. L. Norton, *Cam Design and
    Manufacturing Handbook*, 2nd ed., 2009.
    """
    result, positions, inputs = [], model.positions, model.inputs
    for name, size in model.mechanism.cams.items():
        offset = inputs.parameter(model.topology.slaves[name].offset)
        lift = positions.displacement(name) - offset
        radius = inputs.parameter(size.base) + inputs.parameter(size.roller)
        aside = inputs.parameter(size.eccentricity)
        height = model.graph.sqrt(radius * radius - aside * aside)
        leaning = positions.slope(name) - aside
        result.append(model.graph.apply("atan2", leaning, lift + height))
    return result


OUTPUTS = {
    "pressure_angle": Variable(("cam",), "rad", "pressure angle", pressure_angles, smooth=False)
}
