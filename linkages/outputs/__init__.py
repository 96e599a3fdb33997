"""Outputs that stand in files of their own: found by themselves."""

from __future__ import annotations

from collections.abc import Callable

from linkages.kernel.model import Model
from linkages.kernel.outputs import labels
from linkages.kernel.scalars import Scalar, Vector


def along_motion(model: Model) -> dict[int, Scalar]:
    """Input of the equations → its rate: of time, of free coordinates and of their rates."""
    inputs, free = model.inputs, range(len(model.topology.free))
    moving = {inputs.time.index: model.graph.one}
    moving |= {inputs.coordinate(i).index: inputs.rate(i) for i in free}
    return moving | {inputs.rate(i).index: inputs.acceleration(i) for i in free}


Value = Callable[[Model, str], Scalar | Vector]


def of_each(dim: str, value: Value) -> Callable[[Model], list[Scalar]]:
    """A value of each element of a dimension, both components of one that is a vector."""

    def nodes(model: Model) -> list[Scalar]:
        result = [value(model, name) for name in labels(model, dim)]
        parts = ((v.x, v.y) if isinstance(v, Vector) else (v,) for v in result)
        return [part for own in parts for part in own]

    return nodes
