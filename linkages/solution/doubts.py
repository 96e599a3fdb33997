"""What a definition says but hardly means."""

from __future__ import annotations

from itertools import combinations
from math import dist

from linkages.components.mechanism import Mechanism
from linkages.components.terms import Body
from linkages.solution.law_ranges import law_notes

LARGEST_PLAY = 0.05
"""Of the length of a bar; a larger clearance is less like play in a joint than like a link."""


def doubts(mechanism: Mechanism) -> list[str]:
    """A sentence for each clearance that is large beside the bar whose end it displaces.

    Others follow for tables that leave the range of their values, or jump.
    """
    bodies = mechanism.bodies.values()
    found = []
    for link in (body for body in bodies if body.kind == "clearance"):
        _, displaced = link.points
        bar = next(body for body in bodies if body is not link and displaced in body.points)
        size, length = _length(link), _length(bar)
        if size > LARGEST_PLAY * length:
            found.append(
                f"clearance {link.name} of {size:g} m is large beside {bar.name} of {length:g} m; "
                "numbers without a unit are metres"
            )
    return [*found, *law_notes(mechanism)]


def _length(body: Body) -> float:
    """The largest distance between two of its joints."""
    places = [(x.value, y.value) for x, y in body.points.values()]
    return max((dist(one, other) for one, other in combinations(places, 2)), default=0.0)
