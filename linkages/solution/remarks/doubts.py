"""What a definition says but hardly means."""

from __future__ import annotations

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.solution.remarks.forgotten_units import forgotten_units, longest
from linkages.solution.remarks.law_ranges import law_notes
from linkages.topology.graph import bodies_at, single_joints

LARGEST_PLAY = 0.05
"""Of the length of a bar; a larger clearance is less like play in a joint than like a link."""


def doubts(mechanism: Mechanism) -> list[str]:
    """A sentence for each clearance, number, name and law that hardly is what was meant."""
    return [
        *_large_clearances(mechanism),
        *_pressed_starts(mechanism),
        *forgotten_units(mechanism),
        *_capitals(mechanism),
        *law_notes(mechanism),
    ]


def _large_clearances(mechanism: Mechanism) -> list[str]:
    """Clearances that are large beside the bar whose end they displace."""
    found = []
    for clearance in mechanism.clearances:
        bar = mechanism.bodies[clearance.bar]
        size, length = clearance.size, longest(bar)
        if size > LARGEST_PLAY * length:
            found.append(
                f"clearance {clearance.name} of {size:g} m is large beside {bar.name} of "
                f"{length:g} m; numbers without a unit are metres"
            )
    return found


def _pressed_starts(mechanism: Mechanism) -> list[str]:
    """Pins and corners of blocks that start within a wall."""
    return [
        f"clearance {own.name} starts pressed in by {own.deepest:.3g} m: more than its size of "
        f"{own.size:g} m lets it"
        for own in mechanism.opening
        if own.deepest > 0.0
    ]


def _capitals(mechanism: Mechanism) -> list[str]:
    """Joints on one body only that are called like another one but for capitals."""
    joints = list(bodies_at(mechanism))
    found = []
    for joint, body in reversed(single_joints(mechanism).items()):
        near = [j for j in joints if j != joint and j.casefold() == joint.casefold()]
        if near and near[0] not in mechanism.bodies[body].points:
            found.append(f"joint {joint} is on one body only, {body}; did you mean {near[0]!r}?")
            joints.remove(joint)
    return found
