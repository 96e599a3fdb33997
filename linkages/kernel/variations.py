"""The variational equations: tangents that are carried along with a motion."""

from __future__ import annotations

from collections.abc import Mapping

from linkages.kernel.differentiation import derivative_along
from linkages.kernel.model import Model
from linkages.kernel.scalars import Scalar, section


@section("variational equations")
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
    rows = derivative_along(model.free_accelerations, directions)
    return [rows[i][k] for k in range(count) for i in range(n)]
