"""Bars, plates, clearances, pins and bearings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import groupby
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.load_measures import GROUND, Distance
from linkages.components.contributed.normal_forces import RoundAtWall
from linkages.components.contributed.terms import UNSEEN, Body
from linkages.components.rigid_bodies import Weld
from linkages.plots.mechanism import roles
from linkages.plots.mechanism.placing import Frame, at_joint, body_direction, moved
from linkages.plots.mechanism.pose import Place, Pose
from linkages.plots.mechanism.shapes import (
    BOSS,
    CLEARANCE_RING,
    FOOT,
    FREE_END,
    MASS,
    PIN,
    SPACING,
    Anchor,
    Direction,
    Disc,
    Look,
    Shape,
    Stroke,
    Strokes,
    hatching,
)
from linkages.reading.paths import dotted

Array = NDArray[np.float64]

THICKNESS, CASING, WEDGE = 3.4, 1.3, 13.0  # points
WALL = 0.18  # of the picture: how far a straight wall reaches beyond what touches it
UNDER = 2.6  # how much wider a bar is that lies in line under another one that it is welded to
ORDER = {"bar": 0, "free": 1, "driven": 2}  # of drawing: what moves the others lies on top
INK, BODY = Look("ink"), Look("ink", 0.8, "pale")
BEARING: list[Stroke] = [[(0.0, 0.0), (-5.5, -9.5), (5.5, -9.5)]]
SOIL, SOLE = hatching(-9.0, 9.0, -9.5), hatching(-9.0, 9.0, 0.0)
"""Hatched ground under a bearing, and under a weld."""


def draw_links(pose: Pose) -> list[Shape]:
    """Plates, then bars, each with a casing; those that are free or driven on top."""
    result = list(anchored_outlines(pose))
    result.sort(
        key=lambda item: (ORDER[roles.body_role(pose.mechanism, item[0].name)], len(item[1]) < 3)
    )
    below = _hidden(pose)
    return [
        shape
        for body, corners, direction in result
        for shape in _link(pose, body, corners, direction, body.name in below)
    ]


def anchored_outlines(pose: Pose) -> Iterator[tuple[Body, tuple[Anchor, ...], Direction]]:
    """Each body that is a line or a plate, with its corners, n ≥ 2, and their direction.

    Bodies that carry a slot reach to its ends. Clearances and plain blocks are left out.
    """
    for name, body in pose.mechanism.bodies.items():
        if body.kind in (*UNSEEN, "block") or not pose.shown(name):
            continue
        frame = Frame(pose, body_direction(pose, name))
        known = {place: at_joint(joint) for joint, place in pose.shown(name).items()}
        if body.rotates and pose.angle(name) is not None:
            for ends in roles.slots_of(pose, name):
                known |= {(float(x), float(y)): frame.fixed((x, y), name) for x, y in ends}
        corners = roles.convex_hull(np.array(list(known)))
        if len(corners) > 1:
            yield body, tuple(known[float(x), float(y)] for x, y in corners), frame.direction


def _link(
    pose: Pose, body: Body, corners: tuple[Anchor, ...], direction: Direction, below: bool
) -> Iterator[Shape]:
    role = roles.body_role(pose.mechanism, body.name)
    if len(corners) > 2:
        look = Look(role, 0.6 * THICKNESS, role, 0.22, CASING)
        yield Strokes((corners,), look, direction, closed=True, name=body.name)
        return
    width = THICKNESS * (UNDER if below else 1.0)
    yield Strokes((corners,), Look(role, width, casing=CASING), direction, name=body.name)
    ends = {joint for anchor in corners for joint, _ in anchor.joints}
    for joint in pose.shown(body.name):
        if joint not in ends and pose.meeting[joint] > 1:  # one body that goes on beyond its pin
            yield Disc(at_joint(joint), Look(role, 0.0, role), points=BOSS, name=body.name)


def _hidden(pose: Pose) -> set[str]:
    """Bodies that lie in line with one that they turn with, and would be hidden under it."""
    result = set()
    for relation in pose.mechanism.relations:
        if len(relation.parts) != 1 or relation.parts[0][1].value != 1.0:
            continue
        pair = (relation.body, relation.parts[0][0])
        shared = [joint for joint in pose.shown(pair[0]) if joint in pose.shown(pair[1])]
        ways = [way_from(pose, bar, pose.positions[shared[0]]) for bar in pair if shared]
        first, second = ways if ways else (None, None)
        if first is not None and second is not None and np.cos(first - second) > 0.99:
            order = [ORDER[roles.body_role(pose.mechanism, bar)] for bar in pair]
            result.add(pair[1] if order[1] < order[0] else pair[0])
    return result


def draw_walls(pose: Pose, scale: float) -> list[Shape]:
    """Walls of contacts, hatched on the side of their bodies, and rounds that touch them.

    `scale` is in points per metre. Straight walls reach beyond what touches them now.
    """
    result: list[Shape] = []
    for _, entry in groupby(pose.mechanism.contacts, key=attrgetter("path")):
        rounds = [own.geometry for own in entry if isinstance(own.geometry, RoundAtWall)]
        if not rounds:
            continue
        geometry, name = rounds[0], dotted(rounds[0].size.path[:-1])
        wall, through = pose.mechanism.placed(geometry.wall, geometry.through)
        touching = [pose.mechanism.placed(own.body, own.joint) for own in rounds]
        if {through, *(joint for _, joint in touching)} - pose.positions.keys():
            continue
        angle = 0.0 if geometry.angle is None else geometry.angle.value
        frame = Frame(pose, body_direction(pose, wall, angle))
        if geometry.angle is None:
            edge = _circular(at_joint(through), geometry, scale)
        else:
            places = np.array([pose.positions[joint] for _, joint in touching])
            ways = (places - pose.positions[through]) / pose.unit
            along = ways @ (np.cos(frame.angle), np.sin(frame.angle))
            edge = _straight(at_joint(through), along, pose.extent / pose.unit, scale)
        result.append(Strokes(edge, INK, frame.direction, name=name))
        for body, joint in touching:
            if geometry.radius.value and body is not None:
                role = roles.body_role(pose.mechanism, body)
                look, radius = Look(role, 0.3 * THICKNESS, role, 0.22), geometry.radius.value
                result.append(Disc(at_joint(joint), look, metres=radius, name=body))
    return result


Anchors = tuple[tuple[Anchor, ...], ...]


def _straight(through: Anchor, along: Array, extent: float, scale: float) -> Anchors:
    """A wall about a point, and beyond others so many metres along it."""
    low, high = min(0.0, along.min()) - WALL * extent, max(0.0, along.max()) + WALL * extent
    count = max(2, int((high - low) * scale / SPACING))
    places = [replace(through, metres=(x, 0.0)) for x in np.linspace(low, high, count).tolist()]
    return ((places[0], places[-1]), *((place, moved(place, *FOOT)) for place in places[1:]))


def _circular(middle: Anchor, geometry: RoundAtWall, scale: float) -> Anchors:
    """A closed wall: what has it is outside, or inside."""
    radius, depth = geometry.circle.value, -FOOT[1] if geometry.inside else FOOT[1]
    count = max(36, int(2 * np.pi * radius * scale / SPACING))
    turns = np.linspace(0.0, 2 * np.pi, count + 1)
    ways = np.column_stack([np.cos(turns), np.sin(turns)]).tolist()
    rim = tuple(replace(middle, metres=(radius * x, radius * y)) for x, y in ways)
    feet = [
        (place, moved(place, depth * x - FOOT[0] * y, depth * y + FOOT[0] * x))
        for place, (x, y) in zip(rim[1:], ways[1:], strict=True)
    ]
    return (rim, *feet)


def draw_clearances(pose: Pose) -> list[Shape]:
    """A thin line from every journal to the middle of its bearing."""
    look = Look("clearance", 1.2)
    return [
        Strokes(((at_joint(joint), at_joint(displaced)),), look, name=joint)
        for displaced, joint in roles.clearance_ends(pose.mechanism).items()
        if {displaced, joint} <= set(pose.positions)
    ]


def way_from(pose: Pose, bar: str, place: Place) -> float | None:
    """From a joint to the middle of a body's other joints."""
    others = [] if bar == GROUND else [p for p in pose.shown(bar).values() if p != place]
    if not others:
        return None
    way = np.mean(others, axis=0) - place
    return float(np.arctan2(way[1], way[0]))


def draw_bearings(pose: Pose) -> list[Shape]:
    """Hatched ground under the joints that it holds."""
    result: list[Shape] = []
    for joint in pose.positions:
        if joint in pose.mechanism.ground and _held(pose, joint) and not _fixed(pose, joint):
            frame = Frame(pose, Direction(roles.ground_direction(pose, joint) + 0.5 * np.pi))
            result.append(frame.symbol(at_joint(joint), BEARING, BODY, closed=True, name=joint))
            result.append(frame.symbol(at_joint(joint), SOIL, INK, name=joint))
    return result


def draw_pins(pose: Pose) -> list[Shape]:
    """Pins, rings of clearances, and free ends."""
    mechanism, shown = pose.mechanism, pose.positions
    ends, feet = roles.clearance_ends(mechanism), mechanism.feet
    result: list[Shape] = []
    # free ends first: what turns on a pin at the same place is drawn over them
    for joint in sorted(shown, key=lambda name: pose.meeting[name] > 1):
        if joint in ends or joint in feet or _fixed(pose, joint):
            continue
        if joint in ends.values():
            ring = Look("clearance", 0.9, "paper")
            result.append(Disc(at_joint(joint), ring, points=CLEARANCE_RING, name=joint))
        pinned = joint in mechanism.ground and _held(pose, joint)
        free_end = not pinned and pose.meeting[joint] < 2
        radius, fill = (FREE_END, "ink") if free_end else (PIN, "paper")
        result.append(Disc(at_joint(joint), Look("ink", 0.9, fill), points=radius, name=joint))
    return result


def draw_masses(pose: Pose) -> list[Shape]:
    """Discs at joints that carry a concentrated mass."""
    return [
        Disc(at_joint(mass.joint), Look("ink", 0.9, "ink"), points=MASS, name=mass.joint)
        for mass in pose.mechanism.point_masses
        if mass.joint in pose.positions and mass.mass.value > 0.0
    ]


def draw_welds(pose: Pose) -> list[Shape]:
    """A filled corner between two bodies welded together, or the ground under one."""
    result: list[Shape] = []
    for joint, weld in welded(pose).items():
        first, second = (way_from(pose, bar, pose.positions[joint]) for bar in weld.bars)
        if weld.bars[0] == GROUND:
            if second is not None:
                frame = Frame(pose, Direction(second - 0.5 * np.pi))
                result.append(frame.symbol(at_joint(joint), SOLE, INK, name=joint))
        elif first is not None and second is not None:
            frame = Frame(pose, body_direction(pose, weld.bars[1]))
            role = roles.body_role(pose.mechanism, weld.bars[1])
            corner = [_corner(first - frame.angle, second - frame.angle)]
            look = Look(role, 0.8, role)
            result.append(frame.symbol(at_joint(joint), corner, look, closed=True, name=joint))
    return result


def _corner(first: float, second: float) -> Stroke:
    """Between two directions; a sleeve where they are in line."""
    ways = np.array([[np.cos(angle), np.sin(angle)] for angle in (first, second)])
    corner = np.vstack((np.zeros(2), WEDGE * ways))
    if abs(ways[0, 0] * ways[1, 1] - ways[0, 1] * ways[1, 0]) < 0.2:
        along, across = 0.5 * ways[0], 0.3 * np.array([-ways[0, 1], ways[0, 0]])
        corner = WEDGE * np.array(
            [along + across, along - across, across * -1 - along, across - along]
        )
    return [(float(x), float(y)) for x, y in corner]


def _held(pose: Pose, joint: str) -> bool:
    """Whether something turns at a joint or pulls at it: others are places that axes go through."""
    lines = (load.measure for load in pose.mechanism.loads if isinstance(load.measure, Distance))
    return joint in pose.meeting or any(joint in (line.first, line.second) for line in lines)


def _fixed(pose: Pose, joint: str) -> bool:
    """Whether a weld holds the only two bodies at a joint together: no pin is there."""
    mechanism = pose.mechanism
    if joint not in welded(pose) or joint in roles.clearance_ends(mechanism).values():
        return False
    return pose.meeting[joint] + (joint in mechanism.ground) == 2


def welded(pose: Pose) -> dict[str, Weld]:
    """Joints whose place is known, with the weld there."""
    welds = roles.parts_of(pose.mechanism, Weld)
    return {weld.name: weld for weld in welds if weld.name in pose.positions}
