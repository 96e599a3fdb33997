"""Guides of sliders: rails, rods in bushings, blocks and slots."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

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
    Look,
    Pair,
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


@dataclass(frozen=True)
class DrawnSlider:
    """A slider in a position, whose axis is known there."""

    pose: Pose
    name: str
    axis: SliderAxis

    @cached_property
    def guide(self) -> Guide:
        """What it moves along."""
        guide = self.pose.mechanism.bodies[self.name].guide
        assert guide is not None
        return guide

    @property
    def grounded(self) -> bool:
        """Whether its axis is on the ground."""
        return self.guide.body is None

    @cached_property
    def play(self) -> Play | None:
        """Its room in its guide, if it has some."""
        plays = self.pose.mechanism.plays
        return next((play for play in plays if play.slider == self.name), None)

    @property
    def block(self) -> str:
        """The body that has its joints."""
        return self.name if self.play is None else self.play.block

    @property
    def pin(self) -> Anchor:
        """Where its block is: with room in its guide, beside the axis."""
        return at_joint(next(iter(self.pose.mechanism.bodies[self.block].points)))

    @cached_property
    def frame(self) -> Frame:
        """Along its axis."""
        return Frame(self.pose, body_direction(self.pose, self.name))

    @property
    def along(self) -> Array:
        """The direction of its axis, shape (2,)."""
        return np.array([np.cos(self.axis.angle), np.sin(self.axis.angle)])

    @property
    def half(self) -> Pair:
        """Half length and half height of its block, in points."""
        length, height = BLOCK if self.grounded else SMALL_BLOCK
        room = 0.0 if self.play is None else ROOM if self.grounded else 0.7 * ROOM
        return length, height - room

    @cached_property
    def travel(self) -> tuple[float, float]:
        """Least and largest displacement in the units of the pose, the present one among them."""
        known = self.pose.travel.get(self.name, (np.nan, np.nan))
        low, high = (self.pose.unit * value for value in known)
        return float(np.fmin(low, self.axis.reach)), float(np.fmax(high, self.axis.reach))

    def fixed(self, reach: float, points: Pair = (0.0, 0.0)) -> Anchor:
        """At a displacement along the axis, going along with what carries that."""
        return self.frame.fixed(self.axis.at(reach), self.guide.body, points)


def slider_of(pose: Pose, name: str) -> DrawnSlider | None:
    """A slider in a position; None if its axis is not known."""
    axis = pose.axis(name)
    return None if axis is None else DrawnSlider(pose, name, axis)


def _sliders(pose: Pose) -> Iterator[DrawnSlider]:
    """Sliders whose axes are known."""
    return filter(None, (slider_of(pose, name) for name in pose.mechanism.bodies))


def draw_guides(pose: Pose, scale: float) -> list[Shape]:
    """What guides sliders on the ground: it stands still. `scale` is in points per metre."""
    result: list[Shape] = []
    for slider in filter(lambda slider: slider.grounded, _sliders(pose)):
        frame, name = slider.frame, slider.name
        first, last = map(slider.fixed, slider.travel)
        line, beyond = Look("guide", 0.7, dashes=AXIS_LINE), 2 * BLOCK[0] + 20.0
        result.append(
            frame.line((moved(first, -beyond, 0.0), moved(last, beyond, 0.0)), line, name)
        )
        side = rod_side(slider, scale)
        if side:
            centre = moved(last if side > 0 else first, side * APART, 0.0)
            upper = hatching(-BUSHING[0], BUSHING[0], -BUSHING[1])
            strokes = [*upper, *mirrored(upper)]
            result.append(frame.symbol(centre, strokes, Look("ink"), name=name))
            walls = [(moved(centre, -BUSHING[0], 0.0), moved(centre, BUSHING[0], 0.0))]
            away = BUSHING[1]
        else:
            pieces = _pieces(slider, scale)
            result.append(_rails(slider, pieces))
            walls, away = [(first, last) for first, last, _ in pieces], RAIL
        if slider.play is not None:
            lines = (
                tuple(moved(end, 0.0, side * away) for end in ends)
                for ends in walls
                for side in (1.0, -1.0)
            )
            result.append(Strokes(tuple(lines), WALL, frame.direction, name=name))
    return result


Pieces = list[tuple[Anchor, Anchor, float]]
"""Parts of rails: both of their ends on the axis, and their lengths in points."""


def _rails(slider: DrawnSlider, pieces: Pieces) -> Strokes:
    """Two lines along all of the travel, one of them hatched; that one alone beside a linkage."""
    pose, (x, y) = slider.pose, slider.along
    places = [pose.positions[j] for j in pose.mechanism.ground if j in pose.positions]
    across = [float(np.subtract(place, slider.axis.origin) @ (-y, x)) for place in places]
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
    return Strokes(tuple(strokes), Look("ink"), slider.frame.direction, name=slider.name)


def _pieces(slider: DrawnSlider, scale: float) -> Pieces:
    """Rails along all of the travel, without what would bar the way of other sliders."""
    low, high = slider.travel
    ends = [(low, -2.0 * BLOCK[0])]
    for reach, half in sorted(_crossings(slider, scale)):
        ends += [(reach, -half), (reach, half)]
    ends.append((high, 2.0 * BLOCK[0]))
    result = []
    for first, last in zip(ends[::2], ends[1::2], strict=True):
        length = (last[0] - first[0]) * scale + last[1] - first[1]
        if length > 0.0:
            left, right = (moved(slider.fixed(reach), p, 0.0) for reach, p in (first, last))
            result.append((left, right, length))
    return result


def _crossings(slider: DrawnSlider, scale: float) -> Iterator[tuple[float, float]]:
    """Where other sliders go across an axis, and half of what they need of it in points."""
    axis, own, room = slider.axis, slider.travel, 2.0 * BLOCK[0] / scale
    for other in _sliders(slider.pose):
        if other.name == slider.name or not other.grounded or rod_side(other, scale):
            continue
        turn, gap = other.axis.angle - axis.angle, other.axis.origin - axis.origin
        sine, cosine = np.sin(turn), np.cos(turn)
        if abs(sine) < LEAST_ANGLE:
            continue
        there = float((slider.along[1] * gap[0] - slider.along[0] * gap[1]) / sine)
        here = float(gap @ slider.along + there * cosine)
        least, most = other.travel
        if least - room < there < most + room and own[0] - room < here < own[1] + room:
            yield here, HATCHED * float((1.0 + abs(cosine)) / abs(sine))


def rod_side(slider: DrawnSlider, scale: float) -> int:
    """Where a slider on the ground is a rod in a bushing, instead of a block between rails.

    That is one that carries another slider's axis, and one whose rails would cross the ground: 1
    for a bushing beyond its largest displacement, -1 for one beyond the least, 0 for rails.
    """
    pose, (x, y) = slider.pose, slider.along
    guides = (b.guide for b in pose.mechanism.bodies.values() if b.kind == "slider")
    carries = any(guide is not None and guide.body == slider.name for guide in guides)
    pivots = [j for j in pose.mechanism.ground if j in pose.positions and j in pose.meeting]
    ways = [np.subtract(pose.positions[joint], slider.axis.origin) for joint in pivots]
    low, high = slider.travel
    beside, room = (RAIL + 6.0) / scale, (2 * BLOCK[0] + 4.0) / scale
    reaches = [float(way @ (x, y)) for way in ways]
    crossed = any(
        abs(way @ (-y, x)) < beside and low - room < reach < high + room
        for way, reach in zip(ways, reaches, strict=True)
    )
    if not carries and (not crossed or high == low):
        return 0
    return -1 if float(np.mean(reaches or [0.0])) > 0.5 * (low + high) + 1e-9 * pose.extent else 1


def draw_rods(pose: Pose, scale: float) -> list[Shape]:
    """Sliders on the ground that are rods in a bushing: they pass behind cranks."""
    result: list[Shape] = []
    for slider in _sliders(pose):
        side = rod_side(slider, scale) if slider.grounded else 0
        if side:
            (low, high), beyond = slider.travel, APART + BUSHING[0] + 5.0
            end = Anchor(slider.pin.joints, (side * (high - low), 0.0), (side * beyond, 0.0))
            look = Look(body_role(pose.mechanism, slider.name), THICKNESS, casing=CASING)
            result.append(slider.frame.line((slider.pin, end), look, slider.name))
    return result


def draw_blocks(pose: Pose, scale: float) -> list[Shape]:
    """Blocks, slots and cylinders: what else moves of sliders."""
    result: list[Shape] = []
    for slider in _sliders(pose):
        if not slider.grounded:
            result += _carried(slider)
        elif not rod_side(slider, scale):
            result.append(_block(slider))
    return result


def _block(slider: DrawnSlider) -> Strokes:
    look, corners = Look("ink", 0.8, "pale"), [rectangle(*slider.half)]
    return slider.frame.symbol(slider.pin, corners, look, closed=True, name=slider.name)


def _carried(slider: DrawnSlider) -> list[Shape]:
    """A block in a slot of what carries it, or the rod of a cylinder that ends before its pin."""
    pose, axis, (low, high) = slider.pose, slider.axis, slider.travel
    carrier = str(slider.guide.body)
    edge = body_role(pose.mechanism, carrier) if slider.play is None else WALL.role
    barrel = barrel_ends(slider)
    if barrel is not None:
        return _cylinder(slider, barrel, edge)
    ends = along_carrier(pose, slider.name)
    if low == high:  # nobody knows how far it goes
        room = LEAST * pose.extent
        low, high = low - room, high + room
        if ends is not None:
            low, high = max(ends[0], low), min(ends[1], high)
    slot = np.array([axis.at(low), axis.at(high)])
    stem = _stem(slider, carrier, slot) if ends is None else []
    reach = SMALL_BLOCK[0] - 2.0  # the block stays inside
    # as wide as the block in it, with round ends
    around = tuple(
        slider.fixed(end, (side * reach + x, y))
        for end, side, turn in ((high, 1.0, 0.0), (low, -1.0, np.pi))
        for x, y in arc(SMALL_BLOCK[1], turn - 0.5 * np.pi, turn + 0.5 * np.pi, 13)
    )
    look = Look(edge, 1.4, "paper", casing=0.8)
    outline = Strokes((around,), look, slider.frame.direction, closed=True, name=slider.name)
    return [*stem, outline, _block(slider)]


def _stem(slider: DrawnSlider, carrier: str, slot: Array) -> list[Shape]:
    """From the pin of a block that carries a slot to the slot, if it lies beside it."""
    pose = slider.pose
    if pose.mechanism.bodies[carrier].rotates:
        return []
    pin = np.array(next(iter(pose.shown(carrier).values())))
    way = slot[1] - slot[0]
    foot = slot[0] + float(np.clip((pin - slot[0]) @ way / (way @ way), 0.0, 1.0)) * way
    if np.hypot(*(foot - pin)) < 1e-9 * pose.extent:
        return []
    look = Look(body_role(pose.mechanism, carrier), THICKNESS, casing=CASING)
    ends = (slider.frame.fixed(place, carrier) for place in (pin, foot))
    return [slider.frame.line(ends, look, carrier)]


def barrel_ends(slider: DrawnSlider) -> tuple[float, float] | None:
    """Bottom and rim, along its axis, of the cylinder whose rod a slider is; None for blocks."""
    ends, (low, high) = along_carrier(slider.pose, slider.name), slider.travel
    near = 1e-6 * slider.pose.extent
    if ends is None or not (high > ends[1] + near or low < ends[0] - near):
        return None
    return ends if high > ends[1] else ends[::-1]


def _cylinder(slider: DrawnSlider, ends: tuple[float, float], edge: str) -> list[Shape]:
    """A barrel along the bar that carries a slider, and the slider as piston and rod."""
    (low, high), (bottom, rim) = slider.travel, ends
    side = 1.0 if rim > bottom else -1.0
    inner, outer = (low, high) if side > 0 else (high, low)
    length = abs(rim - bottom)
    rod = min(abs(outer - rim) + 0.15 * length, max(abs(inner - bottom) - 0.1 * length, 0.0))
    if low == high:
        rod = abs(outer - 0.5 * (bottom + rim))
    first, last = slider.fixed(bottom, (side * 8.0, 0.0)), slider.fixed(rim)
    corners = tuple(
        moved(anchor, 0.0, BARREL * y)
        for anchor, y in ((first, 1), (first, -1), (last, -1), (last, 1))
    )
    role, frame, name = body_role(slider.pose.mechanism, slider.name), slider.frame, slider.name
    piston = Anchor(slider.pin.joints, (-side * rod, 0.0))
    half = BARREL - (1.0 if slider.play is None else 0.7 * ROOM)
    barrel = Look(edge, 1.3, "paper", casing=0.8)
    return [
        Strokes((corners,), barrel, frame.direction, closed=True, name=name),
        frame.line((piston, slider.pin), Look(role, 2.2, casing=0.8), name),
        frame.line((moved(piston, 0.0, half), moved(piston, 0.0, -half)), Look(role, 2.6), name),
    ]
