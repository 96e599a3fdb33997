"""Guides of sliders: rails, rods in bushings, blocks and slots."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.terms import Guide, Play
from linkages.plots.mechanism.links import CASING, THICKNESS
from linkages.plots.mechanism.placing import Frame, at_joint, body_direction, mixed, moved
from linkages.plots.mechanism.pose import LEAST, Pose, SliderAxis, along_carrier
from linkages.plots.mechanism.roles import body_role
from linkages.plots.mechanism.shapes import (
    BLOCK,
    FOOT,
    ROOM,
    SMALL_BLOCK,
    SPACING,
    Anchor,
    Direction,
    Look,
    Shape,
    Strokes,
    arc,
    hatching,
    mirrored,
    rectangle,
)

Array = NDArray[np.float64]

AXIS_LINE = (9.0, 2.0, 1.5, 2.0)
RAIL = BLOCK[1] + 1.2  # points from the axis
HATCHED = RAIL + 4.0  # points from the axis to the end of hatching
BUSHING, APART = (9.0, 3.2), 30.0  # half length and half height; from the last place of the block
WALL = Look("clearance", 1.3)  # what a block with room in its guide may touch
LEAST_ANGLE = 0.2  # sine of the angle between axes that cross: others run beside each other
ASIDE = 0.12
"""Of the picture: how far the ground lies beside an axis that has rails on the other side only."""

BARREL = 5.5  # points: half the height of a cylinder


def travel_of(pose: Pose, name: str, axis: SliderAxis) -> tuple[float, float]:
    """Least and largest displacement in the units of the pose, the present one among them."""
    low, high = (pose.unit * value for value in pose.travel.get(name, (np.nan, np.nan)))
    return float(np.fmin(low, axis.reach)), float(np.fmax(high, axis.reach))


def guide_of(pose: Pose, name: str) -> Guide:
    """The guide of a slider."""
    guide = pose.mechanism.bodies[name].guide
    assert guide is not None
    return guide


def grounded(pose: Pose, name: str) -> bool:
    """Whether a slider moves along an axis on the ground."""
    guide = pose.mechanism.bodies[name].guide
    return guide is not None and guide.body is None


def play_of(pose: Pose, name: str) -> Play | None:
    """The room of a slider in its guide, if it has some."""
    return next((play for play in pose.mechanism.plays if play.slider == name), None)


def pin_of(pose: Pose, name: str) -> Anchor:
    """Where the block of a slider is: with room in its guide, beside the axis."""
    return at_joint(next(iter(pose.mechanism.bodies[block_of(pose, name)].points)))


def block_of(pose: Pose, name: str) -> str:
    """The body that has the joints of a slider."""
    play = play_of(pose, name)
    return name if play is None else play.block


def half_length(pose: Pose, name: str) -> float:
    """Of the block of a slider, in points."""
    return BLOCK[0] if grounded(pose, name) else SMALL_BLOCK[0]


def _sliders(pose: Pose) -> Iterator[tuple[str, SliderAxis]]:
    """Sliders whose axes are known."""
    for name, body in pose.mechanism.bodies.items():
        axis = pose.axis(name) if body.guide is not None else None
        if axis is not None:
            yield name, axis


def draw_guides(pose: Pose, scale: float) -> list[Shape]:
    """What guides sliders on the ground: it stands still. `scale` is in points per metre."""
    result: list[Shape] = []
    for name, axis in _sliders(pose):
        if not grounded(pose, name):
            continue
        frame, (low, high) = Frame(pose, Direction(axis.angle)), travel_of(pose, name, axis)
        first, last = (frame.fixed(axis.at(reach), None) for reach in (low, high))
        line, beyond = Look("guide", 0.7, dashes=AXIS_LINE), 2 * BLOCK[0] + 20.0
        result.append(
            frame.line((moved(first, -beyond, 0.0), moved(last, beyond, 0.0)), line, name)
        )
        side = rod_side(pose, name, axis, scale)
        if side:
            centre = moved(last if side > 0 else first, side * APART, 0.0)
            upper = hatching(-BUSHING[0], BUSHING[0], -BUSHING[1])
            strokes = [*upper, *mirrored(upper)]
            result.append(frame.symbol(centre, strokes, Look("ink"), name=name))
            walls = [(moved(centre, -BUSHING[0], 0.0), moved(centre, BUSHING[0], 0.0))]
            away = BUSHING[1]
        else:
            pieces = _pieces(pose, name, axis, frame, scale)
            result.append(_rails(pose, frame, axis, pieces, name))
            walls, away = [(first, last) for first, last, _ in pieces], RAIL
        if play_of(pose, name) is not None:
            lines = (
                tuple(moved(end, 0.0, side * away) for end in ends)
                for ends in walls
                for side in (1.0, -1.0)
            )
            result.append(Strokes(tuple(lines), WALL, frame.direction, name=name))
    return result


Pieces = list[tuple[Anchor, Anchor, float]]
"""Parts of rails: both of their ends on the axis, and their lengths in points."""


def _rails(pose: Pose, frame: Frame, axis: SliderAxis, pieces: Pieces, name: str) -> Strokes:
    """Two lines along all of the travel, one of them hatched; that one alone beside a linkage."""
    along = np.array([np.cos(axis.angle), np.sin(axis.angle)])
    places = [pose.positions[j] for j in pose.mechanism.ground if j in pose.positions]
    across = [float(np.subtract(place, axis.origin) @ (-along[1], along[0])) for place in places]
    aside = float(np.mean(across or [0.0])) / pose.extent
    solid = 1.0 if aside < -ASIDE else -1.0
    strokes = []
    for left, right, length in pieces:
        strokes += [
            (moved(left, 0.0, side * RAIL), moved(right, 0.0, side * RAIL))
            for side in ((solid, -solid) if abs(aside) <= ASIDE else (solid,))
        ]
        count = max(2, int(length / SPACING))
        for share in (np.arange(count) + 0.9) / count:
            begin = moved(mixed(left, right, float(share)), 0.0, solid * RAIL)
            strokes.append((begin, moved(begin, FOOT[0], -solid * FOOT[1])))
    return Strokes(tuple(strokes), Look("ink"), frame.direction, name=name)


def _pieces(pose: Pose, name: str, axis: SliderAxis, frame: Frame, scale: float) -> Pieces:
    """Rails along all of the travel, without what would bar the way of other sliders."""
    low, high = travel_of(pose, name, axis)
    ends = [(low, -2.0 * BLOCK[0])]
    for reach, half in sorted(_crossings(pose, name, axis, scale)):
        ends += [(reach, -half), (reach, half)]
    ends.append((high, 2.0 * BLOCK[0]))
    result = []
    for first, last in zip(ends[::2], ends[1::2], strict=True):
        length = (last[0] - first[0]) * scale + last[1] - first[1]
        if length > 0.0:
            left, right = (moved(frame.fixed(axis.at(r), None), p, 0.0) for r, p in (first, last))
            result.append((left, right, length))
    return result


def _crossings(
    pose: Pose, name: str, axis: SliderAxis, scale: float
) -> Iterator[tuple[float, float]]:
    """Where other sliders go across an axis, and half of what they need of it in points."""
    along = np.array([np.cos(axis.angle), np.sin(axis.angle)])
    own, room = travel_of(pose, name, axis), 2.0 * BLOCK[0] / scale
    for other, way in _sliders(pose):
        if other == name or not grounded(pose, other) or rod_side(pose, other, way, scale):
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
    pivots = [j for j in pose.mechanism.ground if j in pose.positions and j in turning]
    ways = [np.subtract(pose.positions[joint], axis.origin) for joint in pivots]
    low, high = travel_of(pose, name, axis)
    beside, room = (RAIL + 6.0) / scale, (2 * BLOCK[0] + 4.0) / scale
    reaches = [float(way @ along) for way in ways]
    crossed = any(
        abs(way @ (-along[1], along[0])) < beside and low - room < reach < high + room
        for way, reach in zip(ways, reaches, strict=True)
    )
    if not carries and (not crossed or high == low):
        return 0
    return -1 if float(np.mean(reaches or [0.0])) > 0.5 * (low + high) + 1e-9 * pose.extent else 1


def draw_rods(pose: Pose, scale: float) -> list[Shape]:
    """Sliders on the ground that are rods in a bushing: they pass behind cranks."""
    result: list[Shape] = []
    for name, axis in _sliders(pose):
        side = rod_side(pose, name, axis, scale) if grounded(pose, name) else 0
        if side:
            (low, high), pin = travel_of(pose, name, axis), pin_of(pose, name)
            beyond = APART + BUSHING[0] + 5.0
            end = Anchor(pin.joints, (side * (high - low), 0.0), (side * beyond, 0.0))
            look = Look(body_role(pose.mechanism, name), THICKNESS, casing=CASING)
            frame = Frame(pose, body_direction(pose, name))
            result.append(frame.line((pin, end), look, name))
    return result


def draw_blocks(pose: Pose, scale: float) -> list[Shape]:
    """Blocks, slots and cylinders: what else moves of sliders."""
    result: list[Shape] = []
    for name, axis in _sliders(pose):
        frame = Frame(pose, body_direction(pose, name))
        if not grounded(pose, name):
            result += _carried(pose, frame, name, axis)
        elif not rod_side(pose, name, axis, scale):
            height = BLOCK[1] - ROOM * (play_of(pose, name) is not None)
            result.append(_block(frame, pin_of(pose, name), BLOCK[0], height, name))
    return result


def _block(frame: Frame, pin: Anchor, half: float, height: float, name: str) -> Strokes:
    look = Look("ink", 0.8, "pale")
    return frame.symbol(pin, [rectangle(half, height)], look, closed=True, name=name)


def _carried(pose: Pose, frame: Frame, name: str, axis: SliderAxis) -> list[Shape]:
    """A block in a slot of what carries it, or the rod of a cylinder that ends before its pin."""
    barrel, carrier = barrel_ends(pose, name, axis), str(guide_of(pose, name).body)
    loose = play_of(pose, name) is not None
    edge = WALL.role if loose else body_role(pose.mechanism, carrier)
    if barrel is not None:
        return _cylinder(pose, frame, name, axis, barrel, edge)
    ends, (low, high) = along_carrier(pose, name), travel_of(pose, name, axis)
    height = SMALL_BLOCK[1] - 0.7 * ROOM * loose
    block = _block(frame, pin_of(pose, name), SMALL_BLOCK[0], height, name)
    if low == high:  # nobody knows how far it goes
        room = LEAST * pose.extent
        low, high = low - room, high + room
        if ends is not None:
            low, high = max(ends[0], low), min(ends[1], high)
    slot = np.array([axis.at(low), axis.at(high)])
    stem = _stem(pose, frame, carrier, slot) if ends is None else []
    reach = SMALL_BLOCK[0] - 2.0  # the block stays inside
    # as wide as the block in it, with round ends
    around = tuple(
        frame.fixed(place, carrier, (side * reach + x, y))
        for place, side, turn in ((slot[1], 1.0, 0.0), (slot[0], -1.0, np.pi))
        for x, y in arc(SMALL_BLOCK[1], turn - 0.5 * np.pi, turn + 0.5 * np.pi, 13)
    )
    look = Look(edge, 1.4, "paper", casing=0.8)
    return [*stem, Strokes((around,), look, frame.direction, closed=True, name=name), block]


def _stem(pose: Pose, frame: Frame, carrier: str, slot: Array) -> list[Shape]:
    """From the pin of a block that carries a slot to the slot, if it lies beside it."""
    if pose.mechanism.bodies[carrier].rotates:
        return []
    pin = np.array(next(iter(pose.shown(carrier).values())))
    way = slot[1] - slot[0]
    foot = slot[0] + float(np.clip((pin - slot[0]) @ way / (way @ way), 0.0, 1.0)) * way
    if np.hypot(*(foot - pin)) < 1e-9 * pose.extent:
        return []
    look = Look(body_role(pose.mechanism, carrier), THICKNESS, casing=CASING)
    return [frame.line((frame.fixed(pin, carrier), frame.fixed(foot, carrier)), look, carrier)]


def barrel_ends(pose: Pose, name: str, axis: SliderAxis) -> tuple[float, float] | None:
    """Bottom and rim, along its axis, of the cylinder whose rod a slider is; None for blocks."""
    ends, (low, high) = along_carrier(pose, name), travel_of(pose, name, axis)
    near = 1e-6 * pose.extent
    if ends is None or not (high > ends[1] + near or low < ends[0] - near):
        return None
    return ends if high > ends[1] else ends[::-1]


def _cylinder(
    pose: Pose, frame: Frame, name: str, axis: SliderAxis, ends: tuple[float, float], edge: str
) -> list[Shape]:
    """A barrel along the bar that carries a slider, and the slider as piston and rod."""
    carrier, (low, high), (bottom, rim) = (
        guide_of(pose, name).body,
        travel_of(pose, name, axis),
        ends,
    )
    side = 1.0 if rim > bottom else -1.0
    inner, outer = (low, high) if side > 0 else (high, low)
    length = abs(rim - bottom)
    rod = min(abs(outer - rim) + 0.15 * length, max(abs(inner - bottom) - 0.1 * length, 0.0))
    if low == high:
        rod = abs(outer - 0.5 * (bottom + rim))
    first = frame.fixed(axis.at(bottom), carrier, (side * 8.0, 0.0))
    last = frame.fixed(axis.at(rim), carrier)
    corners = tuple(
        moved(anchor, 0.0, BARREL * y)
        for anchor, y in ((first, 1), (first, -1), (last, -1), (last, 1))
    )
    role, pin = body_role(pose.mechanism, name), pin_of(pose, name)
    piston = Anchor(pin.joints, (-side * rod, 0.0))
    half = BARREL - (0.7 * ROOM if play_of(pose, name) is not None else 1.0)
    barrel = Look(edge, 1.3, "paper", casing=0.8)
    return [
        Strokes((corners,), barrel, frame.direction, closed=True, name=name),
        frame.line((piston, pin), Look(role, 2.2, casing=0.8), name),
        frame.line((moved(piston, 0.0, half), moved(piston, 0.0, -half)), Look(role, 2.6), name),
    ]
