"""What can be carried along with a motion: tangents to it, and functions that events watch."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias

from linkages.kernel.differentiation import derivative_along
from linkages.kernel.model import Model
from linkages.kernel.scalars import Scalar, reachable

Watched: TypeAlias = Callable[[Model], Scalar]
"""The model → a function of position and velocity."""


class NeedsAccelerationsError(ValueError):
    """A watched function depends on accelerations."""


def variations(model: Model, count: int) -> list[Scalar]:
    """Second derivatives of tangents: the equations of motion, linearised in a direction.

    Parameters
    ----------
    model
        Its last ``count·n`` coordinates are the components of the tangents.
    count
        Number of tangents.

    Returns
    -------
    For each tangent n nodes.
    """
    if not count:
        return []
    inputs, n = model.inputs, len(model.topology.free)
    first = inputs.coordinates - count * n
    directions: list[Mapping[int, Scalar]] = []
    for k in range(count):
        places = {inputs.coordinate(i): inputs.coordinate(first + k * n + i) for i in range(n)}
        speeds = {inputs.rate(i): inputs.rate(first + k * n + i) for i in range(n)}
        directions.append({node.index: moved for node, moved in (places | speeds).items()})
    rows = derivative_along(model.free_accelerations, directions, "variational equations")
    return [rows[i][k] for k in range(count) for i in range(n)]


def rate_of(model: Model, value: Scalar) -> Scalar:
    """Derivative of a function with respect to time, along the motion.

    Raises
    ------
    NeedsAccelerationsError
        If it depends on accelerations, for its derivative would depend on jerks.
    """
    for node in reachable([value]):
        if node.operation == "input" and node.arguments[0] == "a":
            raise NeedsAccelerationsError("expected a function of position and velocity")
    inputs = model.inputs
    direction = {inputs.time.index: model.graph.one}
    for i, acceleration in enumerate(model.free_accelerations):
        direction[inputs.coordinate(i).index] = inputs.rate(i)
        direction[inputs.rate(i).index] = acceleration
    ((rate,),) = derivative_along([value], [direction], "rate of a watched function")
    return rate
