"""What stands at the joints of a drawing: bearings, pins, masses and welds."""

from __future__ import annotations

import numpy as np

from linkages.components.contributed.measures import Distance
from linkages.components.contributed.revolute import GROUND
from linkages.components.weld import Weld
from linkages.plots.mechanism import outlining
from linkages.plots.mechanism.bodies import body_role, clearance_ends, ground_direction
from linkages.plots.mechanism.frames import Frame, body_direction
from linkages.plots.mechanism.links import way_from
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.shapes import Anchor, Direction, Disc, Look, Shape


def draw_bearings(pose: Pose) -> list[Shape]:
    """Hatched ground under the joints that it holds."""
    found: list[Shape] = []
    for joint in pose.positions:
        if joint in pose.mechanism.ground and _held(pose, joint) and not _fixed(pose, joint):
            frame = Frame(pose, Direction(ground_direction(pose, joint) + 0.5 * np.pi))
            triangle = [[(0.0, 0.0), (-5.5, -9.5), (5.5, -9.5)]]
            centre, look = frame.at(joint), Look("ink", 0.8, "pale")
            found.append(frame.symbol(centre, triangle, look, closed=True, name=joint))
            strokes = outlining.hatching(-9.0, 9.0, -9.5)
            found.append(frame.symbol(centre, strokes, Look("ink"), name=joint))
    return found


def draw_pins(pose: Pose) -> list[Shape]:
    """Pins, rings of clearances, and free ends."""
    mechanism, shown = pose.mechanism, pose.positions
    ends, feet = clearance_ends(mechanism), mechanism.feet
    meeting = [joint for body in mechanism.bodies.values() for joint in body.points]
    found: list[Shape] = []
    # free ends first: what turns on a pin at the same place is drawn over them
    for joint in sorted(shown, key=lambda name: meeting.count(name) > 1):
        if joint in ends or joint in feet or _fixed(pose, joint):
            continue
        centre = Anchor(((joint, 1.0),))
        if joint in ends.values():
            ring = Look("clearance", 0.9, "paper")
            found.append(Disc(centre, ring, points=outlining.CLEARANCE_RING, name=joint))
        pinned = joint in mechanism.ground and _held(pose, joint)
        free_end = not pinned and meeting.count(joint) < 2
        radius, fill = (outlining.FREE_END, "ink") if free_end else (outlining.PIN, "paper")
        found.append(Disc(centre, Look("ink", 0.9, fill), points=radius, name=joint))
    return found


def draw_masses(pose: Pose) -> list[Shape]:
    """Discs at joints that carry a concentrated mass."""
    look = Look("ink", 0.9, "ink")
    return [
        Disc(Anchor(((mass.joint, 1.0),)), look, points=outlining.MASS, name=mass.joint)
        for mass in pose.mechanism.point_masses
        if mass.joint in pose.positions and mass.mass.value > 0.0
    ]


def draw_welds(pose: Pose) -> list[Shape]:
    """A filled corner between two bodies welded together, or the ground under one."""
    found: list[Shape] = []
    for joint, weld in welded(pose).items():
        place = pose.positions[joint]
        first, second = (way_from(pose, bar, place) for bar in weld.bars)
        if weld.bars[0] == GROUND:
            if second is not None:
                frame = Frame(pose, Direction(second - 0.5 * np.pi))
                strokes = outlining.hatching(-9.0, 9.0, 0.0)
                found.append(frame.symbol(frame.at(joint), strokes, Look("ink"), name=joint))
        elif first is not None and second is not None:
            frame = Frame(pose, body_direction(pose, weld.bars[1]))
            role = body_role(pose.mechanism, weld.bars[1])
            corner = _corner(first - frame.angle, second - frame.angle)
            look = Look(role, 0.8, role)
            found.append(frame.symbol(frame.at(joint), [corner], look, closed=True, name=joint))
    return found


def _corner(first: float, second: float) -> outlining.Stroke:
    """Between two directions; a sleeve where they are in line."""
    ways = np.array([[np.cos(angle), np.sin(angle)] for angle in (first, second)])
    corner = np.vstack((np.zeros(2), outlining.WEDGE * ways))
    if abs(ways[0, 0] * ways[1, 1] - ways[0, 1] * ways[1, 0]) < 0.2:
        across = 0.3 * np.array([-ways[0, 1], ways[0, 0]])
        ends = 0.5 * np.array([1.0, 1.0, -1.0, -1.0])[:, None] * ways[0]
        corner = outlining.WEDGE * (ends + np.array([1.0, -1.0, -1.0, 1.0])[:, None] * across)
    return [(float(x), float(y)) for x, y in corner]


def _held(pose: Pose, joint: str) -> bool:
    """Whether something turns at a joint or pulls at it: others are places that axes go through."""
    mechanism = pose.mechanism
    lines = (load.measure for load in mechanism.loads if isinstance(load.measure, Distance))
    return any(joint in body.points for body in mechanism.bodies.values()) or any(
        joint in (line.first, line.second) for line in lines
    )


def _fixed(pose: Pose, joint: str) -> bool:
    """Whether a weld holds the only two bodies at a joint together: no pin is there."""
    mechanism = pose.mechanism
    if joint not in welded(pose) or joint in clearance_ends(mechanism).values():
        return False
    meeting = [name for body in mechanism.bodies.values() for name in body.points]
    return meeting.count(joint) + (joint in mechanism.ground) == 2


def welded(pose: Pose) -> dict[str, Weld]:
    """Joints whose place is known, with the weld there."""
    welds = (part for part in pose.mechanism.components if isinstance(part, Weld))
    return {weld.name: weld for weld in welds if weld.name in pose.positions}
