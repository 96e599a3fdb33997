"""Consistency checks across the components of a mechanism; all findings are reported."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import combinations

from linkages.components.contributed.component import Component
from linkages.components.contributed.contact_laws import ambiguity, meeting
from linkages.components.contributed.load_measures import GROUND, End
from linkages.components.contributed.normal_forces import (
    FollowerOnCam,
    RigidContact,
    RoundAtWall,
)
from linkages.components.contributed.terms import Body
from linkages.components.mechanisms.declared_names import (
    Declared,
    expected_one_of,
    formula_findings,
)
from linkages.reading.paths import KeyPath, dotted

Finding = tuple[KeyPath, str]
Findings = Iterator[Finding]

ALIKE = 1e-9
"""Sine of the angle between walls that count as parallel."""

__all__ = ["Declared", "Finding", "findings"]


def findings(components: Sequence[Component], declared: Declared) -> list[Finding]:
    """Everything that is inconsistent, as pairs of a path and a sentence."""
    result = [problem for component in components for problem in component.problems()]
    checks = (*(_OF_WHOLE_DEFINITIONS if declared.complete else ()), *_CHECKS)
    return [*result, *(found for check in checks for found in check(components, declared))]


def _unknown_names(components: Sequence[Component], declared: Declared) -> Findings:
    for references in (component.references() for component in components):
        for path, joint in references.joints:
            if joint not in declared.joints:
                yield path, expected_one_of(joint, declared.joints, "joint")
        for path, joint in references.ground:
            if joint not in declared.ground:
                yield path, expected_one_of(joint, declared.ground, "ground joint")
        for path, joint in references.moving:
            if joint in declared.ground:
                yield path, f"joint {joint!r} is fixed to the ground; expected another"
            elif joint not in declared.joints:
                yield path, expected_one_of(joint, declared.joints, "joint")
        for path, name, kinds in references.bodies:
            if not declared.kinds.get(name, set()) & set(kinds):
                of_kind = [n for n, own in declared.kinds.items() if own & set(kinds)]
                message = expected_one_of(name, of_kind, kinds[0])
                if remedy := declared.instead.get(name):
                    message = f"unknown {kinds[0]} {name!r}: {remedy}"
                yield path, message


def _missing_points(components: Sequence[Component], declared: Declared) -> Findings:
    """Joints that a body lacks which should have them."""
    references = [component.references() for component in components]
    for path, name, joint in (p for r in references for p in r.points):
        body = declared.by_name.get(name)
        if body is not None and name not in declared.faulty and joint not in body.points:
            yield path, _lacks(body, joint)
    for path, name, joint in (p for r in references for p in r.meeting):
        if joint not in declared.joints or joint in declared.uncertain:
            continue
        here = meeting(joint, declared.by_name, declared.ground)
        if name not in here and (name == GROUND or name in declared.by_name):
            listed = ", ".join(here)
            yield path, f"{name!r} does not turn at joint {joint!r}; found {listed}"


def _carried_elsewhere(components: Sequence[Component], declared: Declared) -> Findings:
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


def _sliders_on_air(_: Sequence[Component], declared: Declared) -> Findings:
    """Sliders whose joint nothing else knows."""
    for path, joint in declared.air:
        yield (*path, "joint"), expected_one_of(joint, declared.joints, "joint")


def _ambiguous_frictions(_: Sequence[Component], declared: Declared) -> Findings:
    for term in declared.frictions:
        if term.joint in declared.joints - declared.uncertain and (
            finding := ambiguity(term, declared.by_name, declared.ground)
        ):
            yield finding


def _repeated_entries(components: Sequence[Component], declared: Declared) -> Findings:
    """Entries at one place of the definition, which only Python code can make.

    Bodies are left to `_repeated_names`, which knows more places.
    """
    named = {path for path, _ in (*declared.bodies, *declared.displacements)}
    seen: set[KeyPath] = set()
    for path in (component.path for component in components):
        if path in seen and path not in named:
            yield path, "given already; expected once"
        seen.add(path)


def _repeated_names(_: Sequence[Component], declared: Declared) -> Findings:
    places = [(path, body.name) for path, body in declared.bodies]
    places += [(path, term.name) for path, term in declared.displacements]
    places += [(path, play.name) for path, play in declared.plays]
    places += [(term.path, term.name) for term in declared.actuations]
    seen: set[str] = set()
    for path, name in places:
        if name in seen:
            yield path, f"the name {name!r} is taken already; expected a new one"
        seen.add(name)
    if GROUND in seen:
        path = next(path for path, name in places if name == GROUND)
        yield path, "the name 'ground' stands for the frame; expected another one"


def _misplaced_clearances(_: Sequence[Component], declared: Declared) -> Findings:
    bodies = {body.name: body for _, body in declared.bodies}
    taken: dict[tuple[str, str], str] = {}
    for path, term in declared.displacements:
        body, joint = bodies.get(term.body), term.joint
        if body is None:
            continue
        welds = [r for r in declared.relations if r.path == ("welds", joint)]
        if joint not in body.points:
            yield (*path, "joint"), _lacks(body, joint)
        elif (joint, term.body) in taken:
            other = taken[joint, term.body]
            yield path, f"clearance {other!r} is between the same joint and bar"
        elif any(w.body == term.body or term.body in dict(w.parts) for w in welds):
            yield path, f"bar {body.name!r} is welded at joint {joint!r}"
        elif _only_one_at(joint, declared):
            yield path, f"nothing but bar {body.name!r} is at joint {joint!r}"
        taken[joint, term.body] = term.name


def _only_one_at(joint: str, declared: Declared) -> bool:
    if joint in declared.ground or joint in declared.uncertain or not declared.complete:
        return False
    return sum(joint in body.points for _, body in declared.bodies) < 2


def _walls_of_clearances(_: Sequence[Component], declared: Declared) -> Findings:
    """Contacts that results could not tell from clearances."""
    for wall in declared.walls:
        if "clearance" in declared.kinds.get(wall.name, ()):
            message = "a clearance has this name, and results name both; expected another name"
            yield wall.path, message


def _rubbing_in_the_open(_: Sequence[Component], declared: Declared) -> Findings:
    """Friction against the link of a clearance that has none."""
    for term in declared.rubbing:
        if term.clearance in declared.opening:
            yield (
                (*term.path, "clearance"),
                f"clearance {term.clearance!r} opens, so no link turns in it; expected 'friction' "
                "beside its 'contact'",
            )


def _pressed_in_the_open(_: Sequence[Component], declared: Declared) -> Findings:
    """Frictions that follow a reaction where there is none: in a clearance, or during impacts."""
    loose = {term.slider: term.name for _, term in declared.plays}
    loose |= {term.joint: term.name for _, term in declared.displacements}
    for path, place in declared.pressed:
        if place in loose:
            name = loose[place]
            yield path, f"clearance {name!r} opens {place!r}; expected 'friction' of its contact"
        elif declared.rigid:
            rigid = declared.rigid[0]
            remedy = (
                "'stiffness' (and 'damping') in place of 'restitution'"
                if isinstance(rigid, End)
                else "a 'contact' with a stiffness, such as 'kelvin-voigt'"
            )
            yield (
                path,
                f"impacts of {rigid.name!r} have impulses, which friction under a reaction "
                f"does not follow; expected {remedy} there",
            )


def _held_twice(_: Sequence[Component], declared: Declared) -> Findings:
    """Rigid contacts under friction of one body at walls along which it slips alike."""
    rough = [
        (term.path, term.geometry)
        for term in declared.walls
        if isinstance(term.geometry, RoundAtWall)
        if isinstance(term.normal, RigidContact) and term.normal.friction is not None
    ]
    for (first, one), (second, other) in combinations(rough, 2):
        if first == second or (one.body, one.wall) != (other.body, other.wall):
            continue
        if one.angle is None or other.angle is None:
            alike = one.angle is other.angle and one.through == other.through
        else:
            alike = abs(math.sin(one.angle.value - other.angle.value)) < ALIKE
        if alike:
            yield (
                second,
                f"{dotted(first)} has a wall along which {one.body!r} slips alike, so that nothing "
                "says which of them holds it by friction; expected one entry with all 'points' of "
                "a wall, or a 'contact' with a stiffness",
            )


def _cams_off_their_pivots(_: Sequence[Component], declared: Declared) -> Findings:
    """Cams that followers may leave, without a pivot of their own, or beside other cams."""
    lifted = {r.body: r.path for r in declared.relations if r.profile is not None}
    for term in declared.walls:
        cam = term.geometry
        if not isinstance(cam, FollowerOnCam) or cam.cam not in declared.by_name:
            continue
        if (other := lifted.setdefault(cam.slider, term.path)) != term.path:
            message = f"lifts {cam.slider!r} already; expected one cam of a follower"
            yield (*term.path, "slider"), f"{dotted(other)} {message}"
        held = [joint for joint in declared.by_name[cam.cam].points if joint in declared.ground]
        if not held and declared.complete and cam.cam not in declared.faulty:
            message = "followers leave cams on fixed pivots only; expected a joint of the ground on"
            yield (*term.path, "bar"), f"{message} {cam.cam!r}"
        moved = [(t.name, t.body, t.joint in held) for _, t in declared.displacements]
        loose = [("bar", name) for name, body, own in moved if own and body == cam.cam]
        loose += [("slider", p.name) for _, p in declared.plays if p.slider == cam.slider]
        for key, name in loose:
            message = f"clearance {name!r} gives it room; expected that, or 'contact' on the cam"
            yield (*term.path, key), message


def _loose_sliders(_: Sequence[Component], declared: Declared) -> Findings:
    """Blocks that cannot turn for want of inertia, and sliders that have room twice."""
    first: dict[str, str] = {}
    for path, play in declared.plays:
        body = declared.by_name.get(play.slider)
        if body is None or play.slider in declared.faulty:
            continue
        if play.slider in first:
            message = f"{first[play.slider]!r} gives slider {play.slider!r} room already"
            yield (*path, "slider"), f"{message}; expected another slider"
        elif body.inertia.absent and len(body.points) == 1:
            message = f"{play.slider!r} turns in its guide; expected a slider with an 'inertia'"
            yield (*path, "slider"), message
        first.setdefault(play.slider, play.name)


def _circular_guides(_: Sequence[Component], declared: Declared) -> Findings:
    """Sliders that slide on themselves, or on what has their joint."""
    graph: dict[str, tuple[str, ...]] = {
        name: (body.guide.body,)
        for name, body in declared.by_name.items()
        if body.guide is not None and body.guide.body is not None
    }
    reported: set[str] = set()
    for path, body in declared.bodies:
        chain = _cycle(graph, body.name)
        if chain and not reported & set(chain):
            reported |= set(chain)
            listed = " → ".join((*chain, chain[0]))
            yield (*path, "on"), f"expected an axis carried by another body: {listed}"
        for name in () if chain else graph.get(body.name, ()):
            joint, carrier = next(iter(body.points)), declared.by_name.get(name)
            if carrier is not None and joint in carrier.points:
                message = f"{name!r} has joint {joint!r} itself; expected a joint that slides on it"
                yield (*path, "joint"), message


def _driven_and_free(_: Sequence[Component], declared: Declared) -> Findings:
    for name in declared.driven:
        for path in (declared.driven[name], declared.free[name]) if name in declared.free else ():
            message = "is both driven and free; expected one of the two"
            yield path, f"the coordinate of {name!r} {message}"


def _related_twice(_: Sequence[Component], declared: Declared) -> Findings:
    seen: set[str] = set()
    cams = {relation.body for relation in declared.relations if relation.profile is not None}
    remedy = "turn the relation round, with the inverse ratio"
    for relation in declared.relations:
        name = relation.body
        body = declared.by_name.get(name)
        what = "angle" if body is None or body.rotates else "position"
        start = f"the {what} of {name!r} follows from this relation"
        if name in seen:
            yield relation.path, f"{start} and from another one; expected one: {remedy}"
        elif name in declared.driven or name in declared.free:
            what = "driven" if name in declared.driven else "free"
            yield relation.path, f"{start} and is {what}; expected one of the two"
        for other in (part for part, _ in relation.parts if part in cams):
            message = f"{other!r} follows a cam; expected one that nothing else is tied to"
            yield relation.path, message
        seen.add(name)


def _cycles(_: Sequence[Component], declared: Declared) -> Findings:
    follows = {r.body: tuple(name for name, _ in r.parts) for r in declared.relations}
    reported: set[str] = set()
    for relation in declared.relations:
        chain = _cycle(follows, relation.body)
        if not chain:
            follows.pop(relation.body, None)  # it is on no way of others back to themselves
        elif not reported & set(chain):
            reported |= set(chain)
            listed = " → ".join((*chain, chain[0]))
            yield relation.path, f"coordinates follow from each other: {listed}"


def _cycle(graph: dict[str, tuple[str, ...]], start: str) -> tuple[str, ...]:
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


_Check = Callable[[Sequence[Component], Declared], Findings]

_OF_WHOLE_DEFINITIONS: tuple[_Check, ...] = (
    _unknown_names, _missing_points, _carried_elsewhere, _sliders_on_air, _ambiguous_frictions,
    formula_findings,
)  # fmt: skip
"""Those that say something only where all names are known."""

_CHECKS: tuple[_Check, ...] = (
    _repeated_entries, _repeated_names, _misplaced_clearances, _walls_of_clearances,
    _rubbing_in_the_open, _pressed_in_the_open, _held_twice, _cams_off_their_pivots,
    _loose_sliders, _circular_guides, _driven_and_free, _related_twice, _cycles,
)  # fmt: skip
