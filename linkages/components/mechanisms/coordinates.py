"""Whether each coordinate has one law: driven, free, or related to others."""

from __future__ import annotations

from linkages.components.contributed.terms import Path, Relation
from linkages.components.mechanisms.declared import Declared

Finding = tuple[Path, str]


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
    found: list[Finding] = []
    seen: set[str] = set()
    cams = {relation.body for relation in declared.relations if relation.profile is not None}
    remedy = "turn the relation round, with the inverse ratio"
    for relation in declared.relations:
        name = relation.body
        body = declared.by_name.get(name)
        what = "angle" if body is None or body.rotates else "position"
        start = f"the {what} of {name!r} follows from this relation"
        if name in seen:
            found.append((relation.path, f"{start} and from another one; expected one: {remedy}"))
        elif name in declared.driven or name in declared.free:
            what = "driven" if name in declared.driven else "free"
            found.append((relation.path, f"{start} and is {what}; expected one of the two"))
        for other, _ in relation.parts:
            if other in cams:
                message = f"{other!r} follows a cam; expected one that nothing else is tied to"
                found.append((relation.path, message))
        seen.add(name)
    return found


def _cycles(relations: list[Relation]) -> list[Finding]:
    follows = {relation.body: relation for relation in relations}
    found: list[Finding] = []
    reported: set[str] = set()
    for relation in relations:
        chain = cycle({b: tuple(n for n, _ in r.parts) for b, r in follows.items()}, relation.body)
        if chain and not reported & set(chain):
            reported |= set(chain)
            listed = " → ".join((*chain, chain[0]))
            found.append((relation.path, f"coordinates follow from each other: {listed}"))
    return found


def cycle(graph: dict[str, tuple[str, ...]], start: str) -> tuple[str, ...]:
    """The names on a way through a graph from a name back to it; none if there is no such way."""
    open_ways: list[tuple[str, ...]] = [(start,)]
    passed: set[str] = set()
    while open_ways:
        way = open_ways.pop()
        for name in graph.get(way[-1], ()):
            if name == start:
                return way
            if name not in passed:
                passed.add(name)
                open_ways.append((*way, name))
    return ()
