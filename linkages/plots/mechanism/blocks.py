"""Blocks, slots and cylinders of a drawing: what moves of sliders."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.plots.mechanism import outlining
from linkages.plots.mechanism.bodies import body_role
from linkages.plots.mechanism.frames import Frame, body_direction, moved
from linkages.plots.mechanism.guides import (
    WALL,
    grounded,
    pin_of,
    play_of,
    rod_side,
    travel_of,
)
from linkages.plots.mechanism.links import CASING, THICKNESS
from linkages.plots.mechanism.outlining import BLOCK, ROOM, SMALL_BLOCK
from linkages.plots.mechanism.pose import LEAST, Pose, SliderAxis, along_carrier
from linkages.plots.mechanism.shapes import Anchor, Look, Shape, Strokes

Array = NDArray[np.float64]

BARREL = 5.5
"""Points: half the height of a cylinder."""


def draw_blocks(pose: Pose, scale: float) -> list[Shape]:
    """Blocks, slots and cylinders: what else moves of sliders."""
    found: list[Shape] = []
    for name, body in pose.mechanism.bodies.items():
        axis = pose.axis(name) if body.guide is not None else None
        if axis is None:
            continue
        frame = Frame(pose, body_direction(pose, name))
        if not grounded(pose, name):
            found += _carried(pose, frame, name, axis)
        elif not rod_side(pose, name, axis, scale):
            height = BLOCK[1] - ROOM * (play_of(pose, name) is not None)
            found.append(_block(frame, pin_of(pose, name), BLOCK[0], height, name))
    return found


def _block(frame: Frame, pin: Anchor, half: float, height: float, name: str) -> Strokes:
    corners = [outlining.rectangle(half, height)]
    return frame.symbol(pin, corners, Look("ink", 0.8, "pale"), closed=True, name=name)


def _carried(pose: Pose, frame: Frame, name: str, axis: SliderAxis) -> list[Shape]:
    """A block in a slot of what carries it, or the rod of a cylinder that ends before its pin."""
    barrel = barrel_ends(pose, name, axis)
    if barrel is not None:
        return _cylinder(pose, frame, name, axis, barrel)
    ends, pin = along_carrier(pose, name), pin_of(pose, name)
    low, high = travel_of(pose, name, axis)
    loose = play_of(pose, name) is not None
    block = _block(frame, pin, SMALL_BLOCK[0], SMALL_BLOCK[1] - 0.7 * ROOM * loose, name)
    guide = pose.mechanism.bodies[name].guide
    assert guide is not None
    assert guide.body is not None
    edge = WALL.role if loose else body_role(pose.mechanism, guide.body)
    look = Look(edge, 1.4, "paper", casing=0.8)
    if low == high:  # nobody knows how far it goes
        room = LEAST * pose.extent
        low, high = low - room, high + room
        if ends is not None:
            low, high = max(ends[0], low), min(ends[1], high)
    slot = np.array([axis.at(low), axis.at(high)])
    stem = _stem(pose, frame, guide.body, slot) if ends is None else []
    reach = SMALL_BLOCK[0] - 2.0  # the block stays inside
    first = moved(frame.fixed(slot[0], guide.body), -reach, 0.0)
    last = moved(frame.fixed(slot[1], guide.body), reach, 0.0)
    return [*stem, _slot(frame, first, last, look, name), block]


def _slot(frame: Frame, first: Anchor, last: Anchor, look: Look, name: str) -> Strokes:
    """As wide as the block in it, with round ends."""
    right = [moved(last, *point) for point in outlining.cap(SMALL_BLOCK[1], 0.0)]
    left = [moved(first, *point) for point in outlining.cap(SMALL_BLOCK[1], np.pi)]
    return Strokes(((*right, *left),), look, frame.direction, closed=True, name=name)


def _stem(pose: Pose, frame: Frame, carrier: str, slot: Array) -> list[Shape]:
    """From the pin of a block that carries a slot to the slot, if it lies beside it."""
    if pose.mechanism.bodies[carrier].rotates:
        return []
    pin = np.array(next(iter(pose.shown(carrier).values())))
    way = slot[1] - slot[0]
    share = float(np.clip((pin - slot[0]) @ way / (way @ way), 0.0, 1.0))
    foot = slot[0] + share * way
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
    pose: Pose, frame: Frame, name: str, axis: SliderAxis, ends: tuple[float, float]
) -> list[Shape]:
    """A barrel along the bar that carries a slider, and the slider as piston and rod."""
    guide = pose.mechanism.bodies[name].guide
    assert guide is not None
    low, high = travel_of(pose, name, axis)
    bottom, rim = ends
    side = 1.0 if rim > bottom else -1.0
    inner, outer = (low, high) if side > 0 else (high, low)
    length = abs(rim - bottom)
    if low == high:
        rod = abs(outer - 0.5 * (bottom + rim))
    else:
        rod = min(abs(outer - rim) + 0.15 * length, max(abs(inner - bottom) - 0.1 * length, 0.0))
    first, last = (frame.fixed(axis.at(reach), guide.body) for reach in (bottom, rim))
    first = moved(first, side * 8.0, 0.0)
    corners = tuple(
        moved(anchor, 0.0, across)
        for anchor, across in (
            (first, BARREL), (first, -BARREL), (last, -BARREL), (last, BARREL)
        )
    )  # fmt: skip
    loose = play_of(pose, name) is not None
    edge = WALL.role if loose else body_role(pose.mechanism, str(guide.body))
    barrel = Look(edge, 1.3, "paper", casing=0.8)
    role, pin = body_role(pose.mechanism, name), pin_of(pose, name)
    piston = Anchor(pin.joints, (-side * rod, 0.0))
    half = BARREL - (0.7 * ROOM if loose else 1.0)
    disc = (moved(piston, 0.0, half), moved(piston, 0.0, -half))
    return [
        Strokes((corners,), barrel, frame.direction, closed=True, name=name),
        frame.line((piston, pin), Look(role, 2.2, casing=0.8), name),
        frame.line(disc, Look(role, 2.6), name),
    ]
