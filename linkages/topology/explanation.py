"""Why constraints and coordinates of a mechanism do not match: the most likely cause first."""

from __future__ import annotations

from collections import Counter

from linkages.components.contributed.terms import Hint, Path
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError
from linkages.reading.wording import listed, nearest
from linkages.topology.decomposition import StructureError
from linkages.topology.graph import gruebler_mobility, single_joints

Finding = tuple[Path, str]

_JOINTS = {"bar": "joints", "plate": "points", "slider": "joint"}
"""Key under which a body names its joints."""


def explained(mechanism: Mechanism, error: InputError) -> InputError:
    """An error of mobility or assembly, after what most likely causes it.

    A joint that one body has only and whose name is near that of another, bars between ground
    joints, and drives beyond the mobility are looked for, in this order.
    """
    found = _misspelt(mechanism) or _grounded(mechanism) or _overdriven(mechanism)
    if found is None:
        return error
    path, message = found
    otherwise = "; ".join(problem.message for problem in error.problems)
    stop = "" if message.endswith("?") else "."
    return mechanism.error([(path, f"{message}{stop} Otherwise: {otherwise}")])


def _misspelt(mechanism: Mechanism) -> Finding | None:
    used = _used(mechanism)
    singles = single_joints(mechanism)
    joints = {joint for body in mechanism.bodies.values() for joint in body.points}
    styles = Counter(joint.isupper() for joint in joints)
    # of two names the odd one has unusual capitals, or comes later
    later_first = [*reversed(singles.items())]
    for joint, name in sorted(later_first, key=lambda single: styles[single[0].isupper()]):
        body = mechanism.bodies[name]
        near = nearest(joint, sorted((joints | set(mechanism.ground)) - set(body.points)))
        if near is not None and joint not in used:
            message = f"joint {joint!r} is on one body only, {name}; did you mean {near!r}?"
            return (*body.path, _JOINTS[body.kind]), message
    return None


def _used(mechanism: Mechanism) -> set[str]:
    """Joints that loads, masses and the like name: they may well be on one body only."""
    return {
        joint
        for component in mechanism.components
        if not any(isinstance(term, Hint) for term in component.terms())
        for _, joint in (*component.references().joints, *component.references().moving)
    }


def _grounded(mechanism: Mechanism) -> Finding | None:
    for name, body in mechanism.bodies.items():
        fixed = [joint for joint in body.points if joint in mechanism.ground]
        if body.rotates and len(fixed) > 1:
            return body.path, (
                f"{name} cannot move: its joints {listed(fixed, 'and')} are fixed to the ground; "
                "expected under 'joints' only those that do not move"
            )
    return None


def _overdriven(mechanism: Mechanism) -> Finding | None:
    mobility = gruebler_mobility(mechanism)
    driven, free = list(mechanism.prescribed), list(mechanism.initial)
    surplus = len(driven) + len(free) - mobility
    if mobility < 1 or surplus < 1:
        return None  # without a mobility by count it is redundancy that lets a mechanism move
    paths = [e.path for e in mechanism.initial.values()]
    paths += [e.path for e in mechanism.prescribed.values()]
    message = f"{mobility_words(mechanism, mobility)}; remove {surplus} of them"
    return paths[-1], message


def mobility_words(mechanism: Mechanism, mobility: int) -> str:
    """How many coordinates may be given, and which are."""
    driven, free = list(mechanism.prescribed), list(mechanism.initial)
    are = "coordinate is" if len(driven) == 1 else "coordinates are"
    names = [f" ({', '.join(names)})" if names else "" for names in (driven, free)]
    found = f"mobility is {mobility}, but {len(driven)} {are} driven{names[0]}"
    return f"{found} and {len(free)} free{names[1]}"


def wrong_mobility(mechanism: Mechanism, mobility: int) -> InputError:
    """Drives and free coordinates do not match the mobility."""
    driven, free = len(mechanism.prescribed), len(mechanism.initial)
    if driven + free > mobility:
        remedy = "expected as many as the mobility: remove a drive or a free coordinate"
    else:
        remedy = (
            "expected as many as the mobility: add a drive, or name a bar under 'free' with its "
            "initial angle"
        )
        ends = ", ".join(f"{j} (of {body})" for j, body in single_joints(mechanism).items())
        if ends:
            remedy += f"; or is one of the joints mistyped that a single body has: {ends}?"
    path: Path = ("drives",) if mechanism.prescribed else ("free",) if mechanism.initial else ()
    return mechanism.error([(path, f"{mobility_words(mechanism, mobility)}; {remedy}")])


def undetermined(mechanism: Mechanism, error: StructureError) -> InputError:
    """Some coordinates follow from no equation."""
    found: list[Finding] = [
        (mechanism.bodies[body].path, f"nothing determines the coordinate of {body!r}")
        for body in error.surplus
    ]
    if error.contested:
        joints = ", ".join(error.contested)
        message = (
            f"more constraints than coordinates at {joints}; expected the drives and free "
            "coordinates to be independent of each other"
        )
        found.append(((), message))
    return mechanism.error(found)
