"""What turns at a joint, and so between which bodies a friction acts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from linkages.components.contributed.functions import PRESSED
from linkages.components.contributed.measures import (
    Bearing,
    ClearanceFriction,
    Friction,
    JointFriction,
    Load,
    Turn,
)
from linkages.components.contributed.revolute import GROUND
from linkages.components.contributed.state_laws import leaves
from linkages.components.contributed.terms import Body, Displacement, Path


def turning_with(name: str, bodies: Mapping[str, Body]) -> str:
    """The body that turns with a body: itself, or what carries the axis of a slider in the end."""
    passed: set[str] = set()
    while name in bodies and name not in passed:
        guide = bodies[name].guide
        if guide is None:
            return name
        passed.add(name)
        name = guide.body or GROUND
    return GROUND


def meeting(joint: str, bodies: Mapping[str, Body], ground: Iterable[str]) -> tuple[str, ...]:
    """What can turn at a joint: bodies that turn, and the ground, each once, the ground first."""
    here = [turning_with(name, bodies) for name, body in bodies.items() if joint in body.points]
    found = [GROUND, *here] if joint in ground else here
    return tuple(sorted(dict.fromkeys(found), key=lambda name: name != GROUND))


def resolved(
    term: Friction,
    bodies: Mapping[str, Body],
    ground: Iterable[str],
    displacements: Iterable[Displacement],
) -> Load:
    """Return the load along an angle that a friction is.

    `bodies` have their joints as the definition names them, not displaced by clearances.
    """
    if isinstance(term, ClearanceFriction):
        second = term.clearance
        first = next(d.body for d in displacements if d.name == second)
    else:
        first, second = term.bodies or meeting(term.joint, bodies, ground)
    against = None if first == GROUND else first
    load = Load(Turn(second, against), term.law, term.path)
    if isinstance(term, ClearanceFriction):
        return load
    pressed = PRESSED in leaves(term.law)
    bearing = _bearing(term.joint, (second, first), bodies, ground) if pressed else None
    return replace(
        load, called=term.called, stores=term.stores, states=term.states, bearing=bearing
    )


def _bearing(
    joint: str, turning: tuple[str, str], bodies: Mapping[str, Body], ground: Iterable[str]
) -> Bearing:
    """The reaction on one of the bodies, but not on the one that loads at the joint belong to."""
    there = [name for name, body in bodies.items() if joint in body.points]
    others = there if joint in ground else there[1:]
    chosen = next((name for name in turning if name in others), others[0])
    return Bearing(chosen, joint)


def ambiguity(
    term: JointFriction, bodies: Mapping[str, Body], ground: Iterable[str]
) -> tuple[Path, str] | None:
    """What is wrong where a joint does not tell between which bodies its friction acts."""
    if term.bodies is not None:
        return None
    found = meeting(term.joint, bodies, ground)
    if len(found) == 2:
        return None
    listed = ", ".join(found)
    if len(found) > 2:
        example = f"bars: [{found[0]}, {found[1]}]"
        message = f"{len(found)} bodies turn at joint {term.joint!r} ({listed})"
        return term.path, f"{message}; expected 'bars' to name two of them, such as {example}"
    message = f"nothing turns at joint {term.joint!r} against {listed or 'anything'}"
    return (*term.path, "joint"), f"{message}; expected a joint of two bodies"
