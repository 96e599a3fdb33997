"""Bodies of a drawing: bars, plates and clearances."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.revolute import GROUND
from linkages.components.contributed.terms import PLAYING, Body
from linkages.plots.mechanism import outlining
from linkages.plots.mechanism.bodies import (
    body_role,
    clearance_ends,
    convex_hull,
    slots_of,
)
from linkages.plots.mechanism.frames import Frame, body_direction
from linkages.plots.mechanism.placing import placed
from linkages.plots.mechanism.pose import Place, Pose
from linkages.plots.mechanism.shapes import Anchor, Direction, Disc, Look, Shape, Strokes

Array = NDArray[np.float64]

THICKNESS, CASING = 3.4, 1.3  # points
UNDER = 2.6
"""How much wider a bar is that lies in line under another one that it is welded to."""

ORDER = {"bar": 0, "free": 1, "driven": 2}
"""Of drawing: what moves the others lies on top."""


def draw_links(pose: Pose) -> list[Shape]:
    """Plates, then bars, each with a casing; those that are free or driven on top."""
    found = list(anchored_outlines(pose))
    found.sort(key=lambda item: (ORDER[body_role(pose.mechanism, item[0].name)], len(item[1]) < 3))
    below = _hidden(pose)
    return [
        shape
        for body, corners, direction in found
        for shape in _link(pose, body, corners, direction, body.name in below)
    ]


def anchored_outlines(pose: Pose) -> Iterator[tuple[Body, tuple[Anchor, ...], Direction]]:
    """Each body that is a line or a plate, with its corners, n ≥ 2, and their direction.

    Bodies that carry a slot reach to its ends. Clearances and plain blocks are left out.
    """
    for name, body in pose.mechanism.bodies.items():
        if body.kind in (*PLAYING, "block") or not pose.shown(name):
            continue
        frame = Frame(pose, body_direction(pose, name))
        known = {place: frame.at(joint) for joint, place in pose.shown(name).items()}
        if body.rotates and pose.angle(name) is not None:
            for ends in slots_of(pose, name):
                known |= {(float(x), float(y)): frame.fixed((x, y), name) for x, y in ends}
        corners = convex_hull(np.array(list(known)))
        if len(corners) > 1:
            yield body, tuple(known[float(x), float(y)] for x, y in corners), frame.direction


def outlines(pose: Pose) -> Iterator[tuple[Body, Array]]:
    """Each body that is a line or a plate, with the present places of its corners, shape (n, 2)."""
    for body, corners, direction in anchored_outlines(pose):
        yield body, placed(pose, corners, direction, 0.0)


def _link(
    pose: Pose, body: Body, corners: tuple[Anchor, ...], direction: Direction, below: bool
) -> Iterator[Shape]:
    role = body_role(pose.mechanism, body.name)
    if len(corners) > 2:
        look = Look(role, 0.6 * THICKNESS, role, 0.22, CASING)
        yield Strokes((corners,), look, direction, closed=True, name=body.name)
        return
    width = THICKNESS * (UNDER if below else 1.0)
    yield Strokes((corners,), Look(role, width, casing=CASING), direction, name=body.name)
    ends = {joint for anchor in corners for joint, _ in anchor.joints}
    meeting = [joint for other in pose.mechanism.bodies.values() for joint in other.points]
    for joint in pose.shown(body.name):
        if joint not in ends and meeting.count(joint) > 1:
            eye = Look(role, 0.0, role)  # one body that goes on beyond its pin
            yield Disc(Anchor(((joint, 1.0),)), eye, points=outlining.BOSS, name=body.name)


def _hidden(pose: Pose) -> set[str]:
    """Bodies that lie in line with one that they turn with, and would be hidden under it."""
    found = set()
    for relation in pose.mechanism.relations:
        if len(relation.parts) != 1 or relation.parts[0][1].value != 1.0:
            continue
        pair = (relation.body, relation.parts[0][0])
        shared = [joint for joint in pose.shown(pair[0]) if joint in pose.shown(pair[1])]
        ways = [way_from(pose, bar, pose.positions[shared[0]]) for bar in pair if shared]
        first, second = ways if ways else (None, None)
        if first is not None and second is not None and np.cos(first - second) > 0.99:
            order = [ORDER[body_role(pose.mechanism, bar)] for bar in pair]
            found.add(pair[1] if order[1] < order[0] else pair[0])
    return found


def draw_clearances(pose: Pose) -> list[Shape]:
    """A thin line from every journal to the middle of its bearing."""
    look = Look("clearance", 1.2)
    return [
        Strokes(((Anchor(((joint, 1.0),)), Anchor(((displaced, 1.0),))),), look, name=joint)
        for displaced, joint in clearance_ends(pose.mechanism).items()
        if {displaced, joint} <= set(pose.positions)
    ]


def way_from(pose: Pose, bar: str, place: Place) -> float | None:
    """From a joint to the middle of a body's other joints."""
    others = [] if bar == GROUND else [p for p in pose.shown(bar).values() if p != place]
    if not others:
        return None
    way = np.mean(others, axis=0) - place
    return float(np.arctan2(way[1], way[0]))
