"""What becomes of a state where a switch changes: new memories, new rates, and their tangents."""

from __future__ import annotations

from linkages.kernel.graph.differentiation import derivative_along
from linkages.kernel.graph.scalars import Scalar, section
from linkages.kernel.model import Model
from linkages.kernel.numbers.layout import Layout
from linkages.kernel.variations import tangent_directions


def jump_places(model: Model) -> tuple[int, ...]:
    """For each switch the place of its first new rate among the values kept, or −1; shape (m,)."""
    place, found = len(model.switches.memories), []
    for switch in model.switches.switches:
        found.append(place if switch.jump else -1)
        place += len(switch.jump)
    return tuple(found)


@section("what becomes of the state where a switch changes")
def transition_nodes(model: Model, layout: Layout) -> list[Scalar]:
    """New memories and new rates, from the state before a change.

    With tangents these values are followed by their rates along the motion before the change, by
    their derivatives along each tangent, and by those of the functions of all switches: values (v),
    rates (v), derivatives (v, k), derivatives of functions (m, k).

    Parameters
    ----------
    model
        Its accelerations have been built.
    layout
        Where the tangents stand.
    """
    switches = model.switches
    values = [memory.node for memory in switches.memories]
    values += [rate for switch in switches.switches for rate in switch.jump]
    if not layout.tangents:
        return values
    accelerations = [model.inputs.acceleration(i) for i in range(len(layout.coordinates))]
    rates = switches.rates(values, accelerations)
    moved = derivative_along([*values, *switches.watched], tangent_directions(model, layout))
    for place, memory in enumerate(switches.memories):
        if memory.alike:
            rates[place], moved[place] = model.graph.zero, [model.graph.zero] * layout.tangents
    return [*values, *rates, *(entry for row in moved for entry in row)]
