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
    For each tangent n nodes, and one for each internal state.
    """
    if not layout.tangents:
        return []
    n = layout.moved
    rows = derivative_along(model.changes, tangent_directions(model, layout))
    return [rows[i][k] for k in range(layout.tangents) for i in range(n)]


def tangent_directions(model: Model, layout: Layout) -> list[Mapping[int, Scalar]]:
    """For each tangent the rates of inputs along it: of the state, memories, and what is fed."""
    inputs, n = model.inputs, len(layout.free)
    memories = range(len(model.switches.memories))
    directions: list[Mapping[int, Scalar]] = []
    fed = inputs.fed(layout.fed) or [{}] * layout.tangents
    for column, places in enumerate(layout.tangent_rows[n:].T.tolist()):
        rows = [place - layout.size for place in places]
        moved = {inputs.coordinate(i): inputs.coordinate(row) for i, row in enumerate(rows[:n])}
        moved |= {inputs.rate(i): inputs.rate(row) for i, row in enumerate(rows)}
        first = column * len(memories)
        moved |= {inputs.memory(r): inputs.memory_tangent(first + r) for r in memories}
        directions.append({node.index: rate for node, rate in moved.items()} | fed[column])
    return directions
