"""What the orientation of a body and its coordinate follow from: itself, a guide, a relation."""

from __future__ import annotations

from dataclasses import dataclass, replace

from linkages.components.contributed.terms import Parameter, Relation
from linkages.components.mechanisms.mechanism import Mechanism


@dataclass(frozen=True)
class Orientation:
    """What the orientation of a body depends on.

    Parameters
    ----------
    masters
        The bodies with an angle of their own that it depends on.
    rigid
        Whether it is the angle of its only master plus a constant (or a constant, without one).
    moved
        The bodies with a coordinate of their own that the body's coordinate depends on: of one that
        turns the same, of one that slides itself, unless its displacement follows from others.
    """

    masters: tuple[str, ...]
    rigid: bool
    moved: tuple[str, ...]


def slaves(mechanism: Mechanism) -> dict[str, Relation]:
    """Bodies whose coordinate follows from those of others, with the relation that says how.

    None of them is driven or free, or follows twice: `Mechanism` refuses that.
    """
    return {relation.body: relation for relation in mechanism.relations}


def is_unit(ratio: Parameter) -> bool:
    """Whether a ratio is structure: a body that turns with another as if fixed to it."""
    return ratio.value == 1.0 and not ratio.kept


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
            follows = combined(followers[name]) if name in followers else None
            own = Orientation((name,), rigid=True, moved=(name,)) if follows is None else follows
            if guide is None:
                found[name] = own
            elif guide.body is None:
                found[name] = Orientation((), rigid=True, moved=own.moved)
            else:
                found[name] = replace(orientation(guide.body), moved=own.moved)
        return found[name]

    def combined(relation: Relation) -> Orientation:
        others = [orientation(other) for other, _ in relation.parts]
        moved = tuple(dict.fromkeys(m for other in others for m in other.moved))
        turn = all(mechanism.bodies[name].rotates for name, _ in relation.parts)
        unit = turn and all(is_unit(ratio) for _, ratio in relation.parts)
        rigid = unit and len(others) <= 1 and all(other.rigid for other in others)
        return Orientation(moved, rigid, moved)

    return {name: orientation(name) for name in mechanism.bodies}


def turned_bodies(mechanism: Mechanism) -> set[str]:
    """Bodies whose angle counts with its whole turns, for a spring or a relation depends on it."""
    found = {name for load in mechanism.loads for name in load.turned}
    for relation in mechanism.relations:
        tied = [relation.body, *(name for name, _ in relation.parts)]
        turning = {name for name in tied if mechanism.bodies[name].rotates}
        if len(turning) < len(tied) or not all(is_unit(ratio) for _, ratio in relation.parts):
            found |= turning
    return found
