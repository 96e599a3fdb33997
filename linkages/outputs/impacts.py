"""What ends of ways exert, energy that impacts have lost, and how often contacts close."""

from __future__ import annotations

from collections.abc import Callable

from linkages.kernel.model import Model
from linkages.kernel.outputs import Variable
from linkages.kernel.scalars import Scalar


def _forces(twists: bool) -> Callable[[Model], list[Scalar]]:
    return lambda model: [nodes.force for nodes in model.ends if nodes.end.twists == twists]


OUTPUTS = {
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
