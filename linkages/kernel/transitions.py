"""What becomes of a state where a switch changes: new memories, new rates, and their tangents."""

from __future__ import annotations

from typing import NamedTuple

from linkages.kernel.graph.differentiation import derivative, derivative_along
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


class Constraint(NamedTuple):
    """A function of time and state that is constant while a mode lasts, also along neighbours.

    Parameters
    ----------
    function
        Its gradient by the state is a direction in which there are no neighbours.
    mode
        Number of the switch whose mode says whether it is in force: where it is 0 if the switch
        sticks, where it is +1 if it is that of a contact that presses.
    touch
        Number of the switch of the same contact that closes it; −1 for a switch that sticks.
    """

    function: Scalar
    mode: int
    touch: int


def constraints(model: Model, layout: Layout) -> list[Constraint]:
    """What modes keep constant: functions that stick at zero, gaps of contacts and their rates.

    None where tangents are derivatives by numbers: those are not asked how they grow.

    Parameters
    ----------
    model
        Its accelerations have been built.
    layout
        Where the tangents stand.
    """
    if not layout.tangents or layout.fed:
        return []
    switches, walls = model.switches, model.walls
    found = [
        Constraint(switch.function, number, -1)
        for number, switch in enumerate(switches.switches)
        if switch.stick
    ]
    for contact in walls.contacts:
        press, touch = switches.number(contact.pressing), switches.number(contact.touching)
        own = contact.gap.indentation, contact.speed
        found += [Constraint(function, press, touch) for function in own]
    return found


@section("what becomes of the state where a switch changes")
def transition_nodes(model: Model, layout: Layout) -> list[Scalar]:
    """New memories and new rates, from the state before a change.

    With tangents these values are followed by their rates along the motion before the change, by
    their derivatives along each tangent, by those of the functions of all switches, and by the
    gradients of constraints as tangents stand: values (v), rates (v), derivatives (v, k),
    derivatives of functions (m, k), gradients (c, places and rates of free coordinates).

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
    gradients = _gradients(model, layout)
    return [*values, *rates, *(entry for row in [*moved, *gradients] for entry in row)]


def _gradients(model: Model, layout: Layout) -> list[list[Scalar]]:
    """Derivatives of constraints by the state; those by integrals of internal states are zero."""
    count, inputs = layout.moved, model.inputs
    state = [*map(inputs.coordinate, range(count)), *map(inputs.rate, range(count))]
    return derivative([own.function for own in constraints(model, layout)], state)
