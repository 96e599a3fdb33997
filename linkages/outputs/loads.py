"""Loads, springs and dampers: what they exert."""

from __future__ import annotations

from collections.abc import Callable

from linkages.kernel.model import Model
from linkages.kernel.outputs import Variable
from linkages.kernel.scalars import Scalar


def _of_loads(dim: str) -> Callable[[Model], list[Scalar]]:
    return lambda model: [load.acting for load in model.loads if load.dimension == dim]


OUTPUTS = {
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
