"""Revolute pairs: what holds bodies together at a joint."""

from __future__ import annotations

from dataclasses import dataclass

GROUND = "ground"


@dataclass(frozen=True, kw_only=True)
class Revolute:
    """Two bodies that share a joint and turn freely about it.

    The reaction of the pair is the force that `first` exerts on `second`.

    Parameters
    ----------
    joint
        Joint name.
    first, second
        Bodies; `first` may be the ground.
    """

    joint: str
    first: str
    second: str


def revolute_pairs(joint: str, bodies: tuple[str, ...]) -> tuple[Revolute, ...]:
    """A joint of k bodies as k − 1 revolute pairs, all with the first body.

    Parameters
    ----------
    joint
        Joint name.
    bodies
        The bodies that meet there, the ground first where it is one of them.
    """
    first, *others = bodies
    return tuple(Revolute(joint=joint, first=first, second=other) for other in others)
