"""Consistency checks across the components of a mechanism; all findings are reported."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import combinations

from linkages.components.contributed.component import Component
from linkages.components.contributed.contact_laws import ambiguity, meeting
from linkages.components.contributed.load_measures import GROUND, End
from linkages.components.contributed.normal_forces import (
    FollowerOnCam,
    RigidContact,
    RoundAtWall,
)
from linkages.components.contributed.terms import Body, Relation
from linkages.components.mechanisms.declared_names import (
    Declared,
    expected_one_of,
    formula_findings,
)
from linkages.reading.paths import KeyPath, dotted

Finding = tuple[KeyPath, str]

ALIKE = 1e-9
"""Sine of the angle between walls that count as parallel."""


def coordinate_findings(declared: Declared) -> list[Finding]:
    """Coordinates with two laws, and relations that follow from each other."""
    return [*_driven_and_free(declared), *_related_twice(declared), *_cycles(declared.relations)]


def _driven_and_free(declared: Declared) -> list[Finding]:
    return [
        (path, f"the coordinate of {name!r} is both driven and free; expected one of the two")
        for name in declared.driven
        if name in declared.free
        for path in (declared.driven[name], declared.free[name])
    ]


def _related_twice(declared: Declared) -> list[Finding]:
    result: list[Finding] = []
    seen: set[str] = set()
    cams = {relation.body for relation in declared.relations if relation.profile is not None}
    remedy = "turn the relation round, with the inverse ratio"
    for relation in declared.relations:
        name = relation.body
        body = declared.by_name.get(name)
        what = "angle" if body is None or body.rotates else "position"
        start = f"the {what} of {name!r} follows from this relation"
        if name in seen:
            result.append((relation.path, f"{start} and from another one; expected one: {remedy}"))
        elif name in declared.driven or name in declared.free:
            what = "driven" if name in declared.driven else "free"
            result.append((relation.path, f"{start} and is {what}; expected one of the two"))
        for other, _ in relation.parts:
            if other in cams:
                message = f"{other!r} follows a cam; expected one that nothing else is tied to"
                result.append((relation.path, message))
        seen.add(name)
    return result


def _cycles(relations: list[Relation]) -> list[Finding]:
    follows = {r.body: tuple(name for name, _ in r.parts) for r in relations}
    result: list[Finding] = []
    reported: set[str] = set()
    for relation in relations:
        chain = cycle(follows, relation.body)
        if not chain:
            follows.pop(relation.body, None)  # it is on no way of others back to themselves
        elif not reported & set(chain):
            reported |= set(chain)
            listed = " → ".join((*chain, chain[0]))
            result.append((relation.path, f"coordinates follow from each other: {listed}"))
    return result


def cycle(graph: dict[str, tuple[str, ...]], start: str) -> tuple[str, ...]:
    """The names on a way through a graph from a name back to it; none if there is no such way."""
    before: dict[str, str] = {}
    waiting = [start]
    while waiting:
        last = waiting.pop()
        for name in graph.get(last, ()):
            if name == start:
                way = [last]
                while way[-1] != start:
                    way.append(before[way[-1]])
                return tuple(reversed(way))
            if name not in before:
                before[name] = last
                waiting.append(name)
    return ()


def sliders_on_air(declared: Declared) -> list[Finding]:
    """Sliders whose joint nothing else knows."""
    return [
        ((*path, "joint"), expected_one_of(joint, declared.joints, "joint"))
        for path, joint in declared.air
    ]


def loose_sliders(declared: Declared) -> list[Finding]:
    """Blocks that cannot turn for want of inertia, and sliders that have room twice."""
    result: list[Finding] = []
    first: dict[str, str] = {}
    for path, play in declared.plays:
        body = declared.by_name.get(play.slider)
        if body is None or play.slider in declared.faulty:
            continue
        if play.slider in first:
            message = f"{first[play.slider]!r} gives slider {play.slider!r} room already"
            result.append(((*path, "slider"), f"{message}; expected another slider"))
        elif body.inertia.absent and len(body.points) == 1:
            message = f"{play.slider!r} turns in its guide; expected a slider with an 'inertia'"
            result.append(((*path, "slider"), message))
        first.setdefault(play.slider, play.name)
    return result


def circular_guides(declared: Declared) -> list[Finding]:
    """Sliders that slide on themselves, or on what has their joint."""
    graph: dict[str, tuple[str, ...]] = {
        name: (body.guide.body,)
        for name, body in declared.by_name.items()
        if body.guide is not None and body.guide.body is not None
    }
    result: list[Finding] = []
    reported: set[str] = set()
    for path, body in declared.bodies:
        chain = cycle(graph, body.name)
        if chain and not reported & set(chain):
            reported |= set(chain)
            listed = " → ".join((*chain, chain[0]))
            result.append(((*path, "on"), f"expected an axis carried by another body: {listed}"))
        for name in () if chain else graph.get(body.name, ()):
            joint, carrier = next(iter(body.points)), declared.by_name.get(name)
            if carrier is not None and joint in carrier.points:
                message = f"{name!r} has joint {joint!r} itself; expected a joint that slides on it"
                result.append(((*path, "joint"), message))
    return result


__all__ = ["Declared", "Finding", "findings"]


def findings(components: Sequence[Component], declared: Declared) -> list[Finding]:
    """Everything that is inconsistent, as pairs of a path and a sentence."""
    result = [problem for component in components for problem in component.problems()]
    if declared.complete:
        result += _unknown_names(components, declared)
        result += _missing_points(components, declared)
        result += _carried_elsewhere(components, declared)
        result += sliders_on_air(declared)
        result += _ambiguous_frictions(declared)
        result += formula_findings(components, declared)
    result += _repeated_entries(components, declared)
    result += _repeated_names(declared)
    result += _misplaced_clearances(declared)
    result += _walls_of_clearances(declared)
    result += _rubbing_in_the_open(declared)
    result += _pressed_in_the_open(declared)
    result += _held_twice(declared)
    result += _cams_off_their_pivots(declared)
    result += loose_sliders(declared)
    result += circular_guides(declared)
    result += coordinate_findings(declared)
    return result


def _unknown_names(components: Sequence[Component], declared: Declared) -> list[Finding]:
    result: list[Finding] = []
    for references in (component.references() for component in components):
        for path, joint in references.joints:
            if joint not in declared.joints:
                result.append((path, expected_one_of(joint, declared.joints, "joint")))
        for path, joint in references.ground:
            if joint not in declared.ground:
                result.append((path, expected_one_of(joint, declared.ground, "ground joint")))
        for path, joint in references.moving:
            if joint in declared.ground:
                result.append((path, f"joint {joint!r} is fixed to the ground; expected another"))
            elif joint not in declared.joints:
                result.append((path, expected_one_of(joint, declared.joints, "joint")))
        for path, name, kinds in references.bodies:
            if not declared.kinds.get(name, set()) & set(kinds):
                of_kind = [n for n, own in declared.kinds.items() if own & set(kinds)]
                message = expected_one_of(name, of_kind, kinds[0])
                if remedy := declared.instead.get(name):
                    message = f"unknown {kinds[0]} {name!r}: {remedy}"
                result.append((path, message))
    return result


def _missing_points(components: Sequence[Component], declared: Declared) -> list[Finding]:
    """Joints that a body lacks which should have them."""
    result: list[Finding] = []
    references = [component.references() for component in components]
    for path, name, joint in (p for r in references for p in r.points):
        body = declared.by_name.get(name)
        if body is not None and name not in declared.faulty and joint not in body.points:
            result.append((path, _lacks(body, joint)))
    for path, name, joint in (p for r in references for p in r.meeting):
        if joint not in declared.joints or joint in declared.uncertain:
            continue
        here = meeting(joint, declared.by_name, declared.ground)
        if name not in here and (name == GROUND or name in declared.by_name):
            listed = ", ".join(here)
            result.append((path, f"{name!r} does not turn at joint {joint!r}; found {listed}"))
    return result


def _carried_elsewhere(
    components: Sequence[Component], declared: Declared
) -> Iterator[tuple[KeyPath, str]]:
    """Sliders whose axis something else carries than it should."""
    references = [component.references() for component in components]
    for path, name, carrier in (c for r in references for c in r.carried):
        body = declared.by_name.get(name)
        if body is not None and body.guide is not None and body.guide.body != carrier:
            own = body.guide.body or GROUND
            expected = f"expected what carries the axis of {name!r}: {own}"
            yield path, f"{expected}, found {carrier or GROUND}"


def _lacks(body: Body, joint: str) -> str:
    what = "slider" if body.kind == "slider" else "bar"
    return f"{what} {body.name!r} has no joint {joint!r}; it has {', '.join(body.points)}"


def _repeated_entries(components: Sequence[Component], declared: Declared) -> list[Finding]:
    """Entries at one place of the definition, which only Python code can make.

    Bodies are left to `_repeated_names`, which knows more places.
    """
    named = {path for path, _ in (*declared.bodies, *declared.displacements)}
    seen: set[KeyPath] = set()
    result: list[Finding] = []
    for path in (component.path for component in components):
        if path in seen and path not in named:
            result.append((path, "given already; expected once"))
        seen.add(path)
    return result


def _repeated_names(declared: Declared) -> list[Finding]:
    places = [(path, body.name) for path, body in declared.bodies]
    places += [(path, term.name) for path, term in declared.displacements]
    places += [(path, term.name) for path, term in declared.plays]
    places += [(term.path, term.name) for term in declared.actuations]
    counts = Counter(name for _, name in places)
    seen: set[str] = set()
    result: list[Finding] = []
    for path, name in places:
        if name in seen:
            result.append((path, f"the name {name!r} is taken already; expected a new one"))
        seen.add(name)
    if "ground" in counts:
        path = next(path for path, name in places if name == "ground")
        result.append((path, "the name 'ground' stands for the frame; expected another one"))
    return result


def _misplaced_clearances(declared: Declared) -> list[Finding]:
    bodies = {body.name: body for _, body in declared.bodies}
    result: list[Finding] = []
    taken: dict[tuple[str, str], str] = {}

    def welds(joint: str) -> list[Relation]:
        return [r for r in declared.relations if r.path == ("welds", joint)]

    for path, term in declared.displacements:
        body = bodies.get(term.body)
        if body is None:
            continue
        if term.joint not in body.points:
            result.append(((*path, "joint"), _lacks(body, term.joint)))
        elif (term.joint, term.body) in taken:
            other = taken[term.joint, term.body]
            result.append((path, f"clearance {other!r} is between the same joint and bar"))
        elif any(w.body == term.body or term.body in dict(w.parts) for w in welds(term.joint)):
            result.append((path, f"bar {body.name!r} is welded at joint {term.joint!r}"))
        elif _only_one_at(term.joint, declared):
            result.append((path, f"nothing but bar {body.name!r} is at joint {term.joint!r}"))
        taken[term.joint, term.body] = term.name
    return result


def _walls_of_clearances(declared: Declared) -> list[Finding]:
    """Contacts that results could not tell from clearances."""
    message = "a clearance has this name, and results name both; expected another name"
    taken = {name for name, kinds in declared.kinds.items() if "clearance" in kinds}
    return [(wall.path, message) for wall in declared.walls if wall.name in taken]


def _rubbing_in_the_open(declared: Declared) -> list[Finding]:
    """Friction against the link of a clearance that has none."""
    return [
        (
            (*term.path, "clearance"),
            f"clearance {term.clearance!r} opens, so no link turns in it; expected 'friction' "
            "beside its 'contact'",
        )
        for term in declared.rubbing
        if term.clearance in declared.opening
    ]


def _pressed_in_the_open(declared: Declared) -> list[Finding]:
    """Frictions that follow a reaction where there is none: in a clearance, or during impacts."""
    joints = {term.joint: term.name for _, term in declared.displacements}
    sliders = {term.slider: term.name for _, term in declared.plays}
    result: list[Finding] = []
    for path, place in declared.pressed:
        if (name := joints.get(place) or sliders.get(place)) is not None:
            message = f"clearance {name!r} opens {place!r}; expected 'friction' of its contact"
            result.append((path, message))
        elif declared.rigid:
            rigid = declared.rigid[0]
            remedy = (
                "'stiffness' (and 'damping') in place of 'restitution'"
                if isinstance(rigid, End)
                else "a 'contact' with a stiffness, such as 'kelvin-voigt'"
            )
            message = (
                f"impacts of {rigid.name!r} have impulses, which friction under a reaction "
                f"does not follow; expected {remedy} there"
            )
            result.append((path, message))
    return result


def _held_twice(declared: Declared) -> list[Finding]:
    """Rigid contacts under friction of one body at walls along which it slips alike."""
    rough = [
        (term.path, term.geometry)
        for term in declared.walls
        if isinstance(term.geometry, RoundAtWall)
        if isinstance(term.normal, RigidContact) and term.normal.friction is not None
    ]
    result: list[Finding] = []
    for (first, one), (second, other) in combinations(rough, 2):
        if first == second or (one.body, one.wall) != (other.body, other.wall):
            continue
        if one.angle is None or other.angle is None:
            alike = one.angle is other.angle and one.through == other.through
        else:
            alike = abs(math.sin(one.angle.value - other.angle.value)) < ALIKE
        if alike:
            message = (
                f"{dotted(first)} has a wall along which {one.body!r} slips alike, so that nothing "
                "says which of them holds it by friction; expected one entry with all 'points' of "
                "a wall, or a 'contact' with a stiffness"
            )
            result.append((second, message))
    return result


def _cams_off_their_pivots(declared: Declared) -> list[Finding]:
    """Cams that followers may leave, without a pivot of their own, or beside other cams."""
    result: list[Finding] = []
    lifted = {r.body: r.path for r in declared.relations if r.profile is not None}
    for term in declared.walls:
        cam = term.geometry
        if not isinstance(cam, FollowerOnCam) or cam.cam not in declared.by_name:
            continue
        if (other := lifted.setdefault(cam.slider, term.path)) != term.path:
            message = (
                f"{dotted(other)} lifts {cam.slider!r} already; expected one cam of a follower"
            )
            result.append(((*term.path, "slider"), message))
        held = [joint for joint in declared.by_name[cam.cam].points if joint in declared.ground]
        if not held and declared.complete and cam.cam not in declared.faulty:
            message = "followers leave cams on fixed pivots only; expected a joint of the ground on"
            result.append(((*term.path, "bar"), f"{message} {cam.cam!r}"))
        moved = [(t.name, t.body, t.joint in held) for _, t in declared.displacements]
        loose = [("bar", name) for name, body, own in moved if own and body == cam.cam]
        loose += [("slider", p.name) for _, p in declared.plays if p.slider == cam.slider]
        for key, name in loose:
            message = f"clearance {name!r} gives it room; expected that, or 'contact' on the cam"
            result.append(((*term.path, key), message))
    return result


def _only_one_at(joint: str, declared: Declared) -> bool:
    if joint in declared.ground or joint in declared.uncertain or not declared.complete:
        return False
    return sum(joint in body.points for _, body in declared.bodies) < 2


def _ambiguous_frictions(declared: Declared) -> list[Finding]:
    result = (
        ambiguity(term, declared.by_name, declared.ground)
        for term in declared.frictions
        if term.joint in declared.joints - declared.uncertain
    )
    return [finding for finding in result if finding is not None]
