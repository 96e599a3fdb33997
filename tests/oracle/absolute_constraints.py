"""Everything that holds the bodies of a mechanism together, as measures with prescribed values."""

import math
from dataclasses import dataclass

from absolute_bodies import GROUND, Layout
from absolute_measures import Measure, along_axis, angles, coordinate, gap, related
from time_functions import jet

from linkages.components.contributed.functions import Function, Number, constant
from linkages.components.mechanisms.mechanism import Mechanism

ZERO_LAW = constant(0.0)


@dataclass(frozen=True)
class Constraint:
    """A measure that a function of time prescribes (the same for all of its components).

    Parameters
    ----------
    kind
        ``"pin"``, ``"axis"``, ``"turn"``, ``"relation"`` or ``"drive"``.
    label
        The joint or body that it belongs to.
    measure
        What is prescribed; a pin's is the gap from its first body's point to the second's.
    law
        Its value in time.
    size
        Number of scalar equations.
    second
        The second body of a pin.
    """

    kind: str
    label: str
    measure: Measure
    law: Function = ZERO_LAW
    size: int = 1
    second: str = ""

    def prescribed(self, time: float) -> tuple[float, float, float]:
        return jet(self.law, time)


def constraints(mechanism: Mechanism, layout: Layout) -> list[Constraint]:
    """Pins, guides, relations and drives."""
    found = []
    for joint, (first, *others) in layout.points.items():
        found += [
            Constraint("pin", joint, gap(first, other), size=2, second=other.body or GROUND)
            for other in others
        ]
    for name, body in mechanism.bodies.items():
        guide = body.guide
        if guide is not None:
            turn = angles(layout, [(name, 1.0), (guide.body, -1.0)])
            found.append(Constraint("axis", name, along_axis(layout, name, math.pi / 2)))
            found.append(Constraint("turn", name, turn, Number(guide.angle)))
    for relation in mechanism.relations:
        measure = related(layout, relation)
        found.append(Constraint("relation", relation.body, measure, Number(relation.offset)))
    for name, prescribed in mechanism.prescribed.items():
        found.append(Constraint("drive", name, coordinate(layout, name), prescribed.law))
    return found
