"""How well loops close."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.model import Model
from linkages.kernel.outputs import Variable, components
from linkages.kernel.scalars import Scalar, Vector
from linkages.topology.assur_groups import Step
from linkages.topology.topology import ground_loop


def _closure(model: Model) -> list[Scalar]:
    """Both components of Φ for every loop, from the angles and displacements themselves."""
    units: dict[str | None, Vector] = {}

    def along(step: Step) -> Vector:
        master, own = model.positions.frames.rotation(step.body)
        vector = own.times(model.positions.in_frame(step.body, step.start, step.end))
        if master is None:
            return vector
        if master not in units:
            angle = model.positions.angle(master)
            units[master] = Vector(model.graph.cos(angle), model.graph.sin(angle))
        return units[master].times(vector)

    residuals = []
    for loop in model.topology.closing:
        total = Vector(model.graph.zero, model.graph.zero)
        for sign, way in zip((1.0, -1.0), ground_loop(model.topology, loop), strict=True):
            place = way[0].start if way else loop.apex
            if place in model.mechanism.anchors:
                total = total + model.positions.joints[place] * sign
            for step in way:
                total = total + along(step) * sign
        residuals.append(total)
    return components(residuals)


def _largest(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.abs(rows).max(axis=0, initial=0.0)[None])


OUTPUTS = {
    "closure_residual": Variable(
        (), "m", "closure error", _closure,
        default=True, smooth=False, noise=True, reduced=_largest,
    ),
}  # fmt: skip
