"""Whether sliders have something to slide on, something at their joints, and what room needs."""

from __future__ import annotations

from linkages.components.mechanisms.coordinates import Finding, cycle
from linkages.components.mechanisms.declared import Declared, expected_one_of


def sliders_on_air(declared: Declared) -> list[Finding]:
    """Sliders whose joint nothing else knows."""
    return [
        ((*path, "joint"), expected_one_of(joint, declared.joints, "joint"))
        for path, joint in declared.air
    ]


def loose_sliders(declared: Declared) -> list[Finding]:
    """Blocks that cannot turn for want of inertia, and sliders that have room twice."""
    found: list[Finding] = []
    first: dict[str, str] = {}
    for path, play in declared.plays:
        body = declared.by_name.get(play.slider)
        if body is None or play.slider in declared.faulty:
            continue
        if play.slider in first:
            message = f"{first[play.slider]!r} gives slider {play.slider!r} room already"
            found.append(((*path, "slider"), f"{message}; expected another slider"))
        elif body.inertia.absent and len(body.points) == 1:
            message = f"{play.slider!r} turns in its guide; expected a slider with an 'inertia'"
            found.append(((*path, "slider"), message))
        first.setdefault(play.slider, play.name)
    return found


def circular_guides(declared: Declared) -> list[Finding]:
    """Sliders that slide on themselves, or on what has their joint."""
    graph: dict[str, tuple[str, ...]] = {
        name: (body.guide.body,)
        for name, body in declared.by_name.items()
        if body.guide is not None and body.guide.body is not None
    }
    found: list[Finding] = []
    reported: set[str] = set()
    for path, body in declared.bodies:
        chain = cycle(graph, body.name)
        if chain and not reported & set(chain):
            reported |= set(chain)
            listed = " → ".join((*chain, chain[0]))
            found.append(((*path, "on"), f"expected an axis carried by another body: {listed}"))
        for name in () if chain else graph.get(body.name, ()):
            joint, carrier = next(iter(body.points)), declared.by_name.get(name)
            if carrier is not None and joint in carrier.points:
                message = f"{name!r} has joint {joint!r} itself; expected a joint that slides on it"
                found.append(((*path, "joint"), message))
    return found
