"""What the orientation of a body follows from: its own angle, a guide, a weld or gears."""

from __future__ import annotations

from dataclasses import dataclass

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
    """

    masters: tuple[str, ...]
    rigid: bool


def slaves(mechanism: Mechanism) -> dict[str, Relation]:
    """Bodies whose angle follows from those of others, with the relation that says how.

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
            if name in followers:
                found[name] = combined(followers[name])
            elif guide is None:
                found[name] = Orientation((name,), rigid=True)
            elif guide.body is None:
                found[name] = Orientation((), rigid=True)
            else:
                found[name] = orientation(guide.body)
        return found[name]

    def combined(relation: Relation) -> Orientation:
        others = [orientation(other) for other, _ in relation.parts]
        masters = tuple(dict.fromkeys(m for other in others for m in other.masters))
        unit = all(is_unit(ratio) for _, ratio in relation.parts)
        rigid = unit and len(others) <= 1 and all(other.rigid for other in others)
        return Orientation(masters, rigid)

    return {name: orientation(name) for name in mechanism.bodies}


def turned_bodies(mechanism: Mechanism) -> set[str]:
    """Bodies whose angle counts with its whole turns, for a spring or a gear depends on it."""
    found = {name for load in mechanism.loads for name in load.turned}
    for relation in mechanism.relations:
        if not all(is_unit(ratio) for _, ratio in relation.parts):
            found |= {relation.body, *(name for name, _ in relation.parts)}
    return found
