"""The variational equations: tangents that are carried along with a motion."""

from __future__ import annotations

from collections.abc import Mapping

from linkages.kernel.graph.differentiation import derivative_along
from linkages.kernel.graph.scalars import Scalar, section
from linkages.kernel.model import Model
from linkages.kernel.numbers.layout import Layout


@section("variational equations")
def variations(model: Model, layout: Layout) -> list[Scalar]:
    """Second derivatives of tangents: the equations of motion, linearised in a direction.

    Parameters
    ----------
    model
        Its coordinates are those of the layout.
    layout
        Where the components of the tangents stand.

    Returns
    -------
    For each tangent n nodes.
    """
    if not layout.tangents:
        return []
    inputs, n = model.inputs, len(layout.free)
    directions: list[Mapping[int, Scalar]] = []
    for column in layout.tangent_rows[:n].T.tolist():
        places = {inputs.coordinate(i): inputs.coordinate(row) for i, row in enumerate(column)}
        speeds = {inputs.rate(i): inputs.rate(row) for i, row in enumerate(column)}
        directions.append({node.index: moved for node, moved in (places | speeds).items()})
    rows = derivative_along(model.free_accelerations, directions)
    return [rows[i][k] for k in range(layout.tangents) for i in range(n)]
