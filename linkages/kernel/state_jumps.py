"""Jumps of state at mode changes, variational equations, and the Jacobian."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from linkages.kernel.code.program import Program, write_program
from linkages.kernel.differentiation import derivative, derivative_along
from linkages.kernel.layout import Layout
from linkages.kernel.model import Model
from linkages.kernel.scalars import Scalar, section


@section("variational equations")
def variations(model: Model, layout: Layout) -> list[Scalar]:
    """Second derivatives of tangents: the equations of motion, linearised in a direction."""
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


def jump_places(model: Model) -> tuple[int, ...]:
    """For each switch the place of its first new rate among the values kept, or −1; shape (m,)."""
    place, result = len(model.switches.memories), []
    for switch in model.switches.switches:
        result.append(place if switch.jump else -1)
        place += len(switch.jump)
    return tuple(result)


class Constraint(NamedTuple):
    """A function of time and state that is constant while a mode lasts, also along neighbours.

    It is in force where the mode is 0 if the switch sticks, and +1 if that of a contact presses.
    `touch` is the switch that closes this contact, or −1.
    """

    function: Scalar
    mode: int
    touch: int


def constraints(model: Model, layout: Layout) -> list[Constraint]:
    """What modes keep constant: functions that stick at zero, gaps of contacts and their rates.

    None where tangents are derivatives by numbers: those are not asked how they grow.
    """
    if not layout.tangents or layout.fed:
        return []
    switches = model.switches
    result = [
        Constraint(switch.function, number, -1)
        for number, switch in enumerate(switches.switches)
        if switch.stick
    ]
    for contact in model.rigid:
        press, touch = switches.number(contact.pressing), switches.number(contact.touching)
        own = contact.gap.indentation, contact.speed
        result += [Constraint(function, press, touch) for function in own]
    return result


@section("what becomes of the state where a switch changes")
def transition_nodes(model: Model, layout: Layout) -> list[Scalar]:
    """New memories and new rates, from the state before a change.

    With tangents follow their rates along the motion before the change, their derivatives along
    each tangent, those of the functions of all switches, and the gradients of constraints: values
    (v), rates (v), derivatives (v, k), derivatives of functions (m, k), gradients (c, free places
    and rates).
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
        if memory.insensitive:
            rates[place], moved[place] = model.graph.zero, [model.graph.zero] * layout.tangents
    # by integrals of internal states they are zero
    count, inputs = layout.moved, model.inputs
    state = [*map(inputs.coordinate, range(count)), *map(inputs.rate, range(count))]
    gradients = derivative([own.function for own in constraints(model, layout)], state)
    return [*values, *rates, *(entry for row in [*moved, *gradients] for entry in row)]


@section("derivatives of the accelerations")
def jacobian_nodes(model: Model, accelerations: Sequence[Scalar]) -> list[list[Scalar]]:
    """Derivatives of accelerations with respect to the state, shape (n, 2n)."""
    inputs, places = model.inputs, range(model.inputs.coordinates)
    state = [*map(inputs.coordinate, places), *map(inputs.rate, places)]
    return derivative(accelerations, state)


def write_jacobian(model: Model, accelerations: Sequence[Scalar]) -> Program:
    """Generate the kernel of the derivatives of accelerations, with its own parameters and clock.

    Its ``rates`` writes ``∂a_i/∂y_j`` to ``out[2n·i + j]``, followed by margins and their rates.
    """
    entries = [entry for row in jacobian_nodes(model, accelerations) for entry in row]
    return write_program(model, entries)
