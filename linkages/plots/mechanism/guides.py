"""Guides of sliders on the ground: rails along their travel, or rods in bushings."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.terms import Play
from linkages.plots.mechanism import outlining
from linkages.plots.mechanism.bodies import body_role
from linkages.plots.mechanism.frames import Frame, body_direction, mixed, moved
from linkages.plots.mechanism.links import CASING, THICKNESS
from linkages.plots.mechanism.outlining import BLOCK, SMALL_BLOCK
from linkages.plots.mechanism.pose import Pose, SliderAxis
from linkages.plots.mechanism.shapes import Anchor, Direction, Look, Shape, Strokes

Array = NDArray[np.float64]

AXIS_LINE = (9.0, 2.0, 1.5, 2.0)
RAIL = BLOCK[1] + 1.2  # points from the axis
HATCHED = RAIL + 4.0  # points from the axis to the end of hatching
BUSHING, APART = (9.0, 3.2), 30.0  # half length and half height; from the last place of the block
WALL = Look("clearance", 1.3)
"""What a block with room in its guide may touch."""

LEAST_ANGLE = 0.2
"""Sine of the angle between axes that cross: others run beside each other."""

ASIDE = 0.12
"""Of the picture: how far the ground lies beside an axis that has rails on the other side only."""


def travel_of(pose: Pose, name: str, axis: SliderAxis) -> tuple[float, float]:
    """Least and largest displacement in the units of the pose, the present one among them."""
    low, high = (pose.unit * value for value in pose.travel.get(name, (np.nan, np.nan)))
    return float(np.fmin(low, axis.reach)), float(np.fmax(high, axis.reach))


def grounded(pose: Pose, name: str) -> bool:
    """Whether a slider moves along an axis on the ground."""
    guide = pose.mechanism.bodies[name].guide
    return guide is not None and guide.body is None


def play_of(pose: Pose, name: str) -> Play | None:
    """The room of a slider in its guide, if it has some."""
    return next((play for play in pose.mechanism.plays if play.slider == name), None)


def pin_of(pose: Pose, name: str) -> Anchor:
    """Where the block of a slider is: with room in its guide, beside the axis."""
    return Anchor(((next(iter(pose.mechanism.bodies[block_of(pose, name)].points)), 1.0),))


def block_of(pose: Pose, name: str) -> str:
    """The body that has the joints of a slider."""
    play = play_of(pose, name)
    return name if play is None else play.block


def half_length(pose: Pose, name: str) -> float:
    """Of the block of a slider, in points."""
    return BLOCK[0] if grounded(pose, name) else SMALL_BLOCK[0]


def draw_guides(pose: Pose, scale: float) -> list[Shape]:
    """What guides sliders on the ground: it stands still. `scale` is in points per metre."""
    found: list[Shape] = []
    for name in pose.mechanism.bodies:
        axis = pose.axis(name) if grounded(pose, name) else None
        if axis is None:
            continue
        frame, (low, high) = Frame(pose, Direction(axis.angle)), travel_of(pose, name, axis)
        first, last = (frame.fixed(axis.at(reach), None) for reach in (low, high))
        line = Look("guide", 0.7, dashes=AXIS_LINE)
        beyond = 2 * BLOCK[0] + 20.0
        ends = moved(first, -beyond, 0.0), moved(last, beyond, 0.0)
        found.append(frame.line(ends, line, name))
        side = rod_side(pose, name, axis, scale)
        if side:
            centre = moved(last if side > 0 else first, side * APART, 0.0)
            found.append(_bushing(frame, centre, name))
            walls = [(moved(centre, -BUSHING[0], 0.0), moved(centre, BUSHING[0], 0.0))]
            away = BUSHING[1]
        else:
            pieces = _pieces(pose, name, axis, frame, scale)
            found.append(_rails(pose, frame, axis, pieces, name))
            walls, away = [(first, last) for first, last, _ in pieces], RAIL
        if play_of(pose, name) is not None:
            lines = (
                tuple(moved(end, 0.0, side * away) for end in ends)
                for ends in walls
                for side in (1.0, -1.0)
            )
            found.append(Strokes(tuple(lines), WALL, frame.direction, name=name))
    return found


def _bushing(frame: Frame, centre: Anchor, name: str) -> Strokes:
    upper = outlining.hatching(-BUSHING[0], BUSHING[0], -BUSHING[1])
    strokes = [*upper, *outlining.mirrored(upper)]
    return frame.symbol(centre, strokes, Look("ink"), name=name)


def _rails(pose: Pose, frame: Frame, axis: SliderAxis, pieces: list[Piece], name: str) -> Strokes:
    """Two lines along all of the travel, one of them hatched; that one alone beside a linkage."""
    along = np.array([np.cos(axis.angle), np.sin(axis.angle)])
    places = [pose.positions[j] for j in pose.mechanism.ground if j in pose.positions]
    across = [float(np.subtract(place, axis.origin) @ (-along[1], along[0])) for place in places]
    aside = float(np.mean(across or [0.0])) / pose.extent
    solid = 1.0 if aside < -ASIDE else -1.0
    strokes = []
    for left, right, length in pieces:
        strokes.append((moved(left, 0.0, solid * RAIL), moved(right, 0.0, solid * RAIL)))
        if abs(aside) <= ASIDE:
            strokes.append((moved(left, 0.0, -solid * RAIL), moved(right, 0.0, -solid * RAIL)))
        count = max(2, int(length / 3.4))
        for share in (np.arange(count) + 0.9) / count:
            foot = mixed(left, right, float(share))
            begin = moved(foot, 0.0, solid * RAIL)
            strokes.append((begin, moved(begin, -3.2, solid * 3.6)))
    return Strokes(tuple(strokes), Look("ink"), frame.direction, name=name)


class Piece(NamedTuple):
    """A part of rails: both of its ends on the axis, and its length in points."""

    first: Anchor
    last: Anchor
    length: float


def _pieces(pose: Pose, name: str, axis: SliderAxis, frame: Frame, scale: float) -> list[Piece]:
    """Rails along all of the travel, without what would bar the way of other sliders."""
    low, high = travel_of(pose, name, axis)
    ends = [(low, -2.0 * BLOCK[0])]
    for reach, half in sorted(_crossings(pose, name, axis, scale)):
        ends += [(reach, -half), (reach, half)]
    ends.append((high, 2.0 * BLOCK[0]))
    found = []
    for first, last in zip(ends[::2], ends[1::2], strict=True):
        length = (last[0] - first[0]) * scale + last[1] - first[1]
        if length > 0.0:
            left, right = (moved(frame.fixed(axis.at(r), None), p, 0.0) for r, p in (first, last))
            found.append(Piece(left, right, length))
    return found


def _crossings(
    pose: Pose, name: str, axis: SliderAxis, scale: float
) -> Iterator[tuple[float, float]]:
    """Where other sliders go across an axis, and half of what they need of it in points."""
    along = np.array([np.cos(axis.angle), np.sin(axis.angle)])
    own = travel_of(pose, name, axis)
    room = 2.0 * BLOCK[0] / scale
    for other in pose.mechanism.bodies:
        way = pose.axis(other) if other != name and grounded(pose, other) else None
        if way is None or rod_side(pose, other, way, scale):
            continue
        sine, cosine = np.sin(way.angle - axis.angle), np.cos(way.angle - axis.angle)
        if abs(sine) < LEAST_ANGLE:
            continue
        gap = way.origin - axis.origin
        there = float((along[1] * gap[0] - along[0] * gap[1]) / sine)
        here = float(gap @ along + there * cosine)
        least, most = travel_of(pose, other, way)
        if least - room < there < most + room and own[0] - room < here < own[1] + room:
            yield here, HATCHED * float((1.0 + abs(cosine)) / abs(sine))


def rod_side(pose: Pose, name: str, axis: SliderAxis, scale: float) -> int:
    """Where a slider on the ground is a rod in a bushing, instead of a block between rails.

    That is one that carries another slider's axis, and one whose rails would cross the ground: 1
    for a bushing beyond its largest displacement, -1 for one beyond the least, 0 for rails.
    """
    guides = (b.guide for b in pose.mechanism.bodies.values() if b.kind == "slider")
    carries = any(guide is not None and guide.body == name for guide in guides)
    along = np.array([np.cos(axis.angle), np.sin(axis.angle)])
    turning = {joint for body in pose.mechanism.bodies.values() for joint in body.points}
    ways = [
        np.subtract(pose.positions[joint], axis.origin)
        for joint in pose.mechanism.ground
        if joint in pose.positions and joint in turning
    ]
    low, high = travel_of(pose, name, axis)
    beside, room = (RAIL + 6.0) / scale, (2 * BLOCK[0] + 4.0) / scale
    reaches = [float(way @ along) for way in ways]
    crossed = [
        reach
        for way, reach in zip(ways, reaches, strict=True)
        if abs(way @ (-along[1], along[0])) < beside and low - room < reach < high + room
    ]
    if not carries and (not crossed or high == low):
        return 0
    return -1 if float(np.mean(reaches or [0.0])) > 0.5 * (low + high) + 1e-9 * pose.extent else 1


def draw_rods(pose: Pose, scale: float) -> list[Shape]:
    """Sliders on the ground that are rods in a bushing: they pass behind cranks."""
    found: list[Shape] = []
    for name in pose.mechanism.bodies:
        axis = pose.axis(name) if grounded(pose, name) else None
        side = rod_side(pose, name, axis, scale) if axis is not None else 0
        if axis is not None and side:
            (low, high), pin = travel_of(pose, name, axis), pin_of(pose, name)
            beyond = APART + BUSHING[0] + 5.0
            end = Anchor(pin.joints, (side * (high - low), 0.0), (side * beyond, 0.0))
            look = Look(body_role(pose.mechanism, name), THICKNESS, casing=CASING)
            frame = Frame(pose, body_direction(pose, name))
            found.append(frame.line((pin, end), look, name))
    return found
