"""What the orientation of a body follows from: its own angle, a guide, a weld or gears."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from linkages.components.mechanism import Mechanism
from linkages.components.terms import Relation


class ContestedRelationError(Exception):
    """All bodies of a weld or gear have their angle from elsewhere."""

    def __init__(self, relation: Relation) -> None:
        super().__init__(relation)
        self.relation = relation


@dataclass(frozen=True)
class Orientation:
    """What the orientation of a body depends on.

    Parameters
    ----------
    masters
        The bodies with an angle of their own that it depends on.
    rigid
        Whether it is the angle of its only master plus a constant (or a constant, without one).
    """

    masters: tuple[str, ...]
    rigid: bool


def slaves(mechanism: Mechanism, known: Collection[str]) -> dict[str, Relation]:
    """Bodies whose angle follows from those of others, with the relation that says how.

    A relation is solved for the body that it is written for, or for the first of the others if
    that one is driven, free, or the slave of another relation already.

    Raises
    ------
    ContestedRelationError
        If no body of a relation is left to follow.
    """
    found: dict[str, Relation] = {}
    for relation in mechanism.relations:
        members = (relation.body, *(name for name, _ in relation.parts))
        open_members = [m for m in members if m not in known and m not in found]
        if not open_members:
            raise ContestedRelationError(relation)
        found[open_members[0]] = relation
    return found


def is_unit(value: float) -> bool:
    """Whether a ratio is structure: a body that turns with another as if fixed to it."""
    return value == 1.0


def orientations(mechanism: Mechanism, followers: dict[str, Relation]) -> dict[str, Orientation]:
    """Orientation of every body.

    Parameters
    ----------
    mechanism
        The bodies.
    followers
        From `slaves`.
    """
    found: dict[str, Orientation] = {}

    def orientation(name: str) -> Orientation:
        if name not in found:
            guide = mechanism.bodies[name].guide
            if name in followers:
                found[name] = combined(name, followers[name])
            elif guide is None:
                found[name] = Orientation((name,), rigid=True)
            elif guide.body is None:
                found[name] = Orientation((), rigid=True)
            else:
                found[name] = orientation(guide.body)
        return found[name]

    def combined(name: str, relation: Relation) -> Orientation:
        members = (relation.body, *(other for other, _ in relation.parts))
        others = [orientation(m) for m in members if m != name]
        masters = tuple(dict.fromkeys(m for other in others for m in other.masters))
        unit = all(is_unit(ratio.value) for _, ratio in relation.parts)
        rigid = unit and len(others) <= 1 and all(other.rigid for other in others)
        return Orientation(masters, rigid)

    return {name: orientation(name) for name in mechanism.bodies}


def turned_bodies(mechanism: Mechanism) -> set[str]:
    """Bodies whose angle counts with its whole turns, for a spring or a gear depends on it."""
    found = {
        name
        for load in mechanism.loads
        if (stiffness := getattr(load, "stiffness", None)) is not None and not stiffness.absent
        for name in (getattr(load, "body", None), getattr(load, "reference", None))
        if name is not None
    }
    for relation in mechanism.relations:
        if not all(is_unit(ratio.value) for _, ratio in relation.parts):
            found |= {relation.body, *(name for name, _ in relation.parts)}
    return found
