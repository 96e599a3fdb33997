"""Anchors of shapes, and their places once joints are known."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.plots.mechanism.plane_view import Box
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.shapes import (
    Anchor,
    Direction,
    Disc,
    Look,
    Pair,
    Shape,
    Span,
    Strokes,
    Weights,
    Word,
    anchors_of,
    joints_of,
)

Array = NDArray[np.float64]

ROUNDS, SLACK = 100, 1e-13
"""Of the iteration for the scale of a picture: most of them, and where it ends."""

MOST = 0.7  # of a picture: what symbols may take of it, so that the iteration converges


def place_of(pose: Pose, weights: Weights) -> Array:
    """A weighted mean of joints, in the units of the pose."""
    place = np.zeros(2)
    for joint, weight in weights:
        place += weight * np.asarray(pose.positions[joint])
    return place


def angle_of(pose: Pose, direction: Direction) -> float:
    """A direction in radians."""
    angle = direction.angle
    if direction.ends is not None:
        first, second = (place_of(pose, weights) for weights in direction.ends)
        angle += float(np.arctan2(*(second - first)[::-1]))
    if direction.body is not None:
        turned = pose.angle(direction.body)
        if turned is None:
            raise ValueError(f"the angle of {direction.body} is not known")
        angle += turned
    return angle


def placed(pose: Pose, anchors: Sequence[Anchor], direction: Direction, point: float) -> Array:
    """Where anchors are, shape (n, 2), in the units of the pose; `point` is one of their units."""
    angle = angle_of(pose, direction)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    metres = np.array([anchor.metres for anchor in anchors]).reshape(-1, 2)
    points = np.array([anchor.points for anchor in anchors]).reshape(-1, 2)
    offsets = pose.unit * metres + point * points
    return np.array([place_of(pose, a.joints) for a in anchors]).reshape(-1, 2) + offsets @ turn


def drawable(pose: Pose, shape: Shape) -> bool:
    """Whether all joints of a shape are known."""
    body = shape.direction.body
    known = body is None or pose.angle(body) is not None
    return known and joints_of(shape) <= pose.positions.keys()


@dataclass(frozen=True)
class Cover:
    """What shapes cover in some positions, whatever the scale of their picture is."""

    places: Array  # in the units of the poses, shape (n, 2)
    offsets: Array  # how far beside them, in points, shape (n, 2)

    @classmethod
    def of(cls, pose: Pose, shapes: Iterable[Shape]) -> Cover:
        """Of shapes in one position, with their lines as wide as they are; words cover nothing."""
        places, offsets = [np.empty((0, 2))], [np.empty((0, 2))]
        for shape in shapes:
            if isinstance(shape, Word) or not drawable(pose, shape):
                continue
            anchors = anchors_of(shape)
            here = placed(pose, anchors, shape.direction, 0.0)
            beside = placed(pose, anchors, shape.direction, 1.0) - here
            radius, more = 0.0, 0.5 * shape.look.width
            if isinstance(shape, Disc):
                radius, more = shape.metres * pose.unit, more + shape.points
            for side in (-1.0, 1.0):
                places.append(here + side * radius)
                offsets.append(beside + side * more)
        return cls(np.vstack(places), np.vstack(offsets))

    @classmethod
    def joined(cls, covers: Sequence[Cover]) -> Cover:
        """Of several positions."""
        places = np.vstack([cover.places for cover in covers])
        return cls(places, np.vstack([cover.offsets for cover in covers]))

    def box(self, point: float) -> Box:
        """Around everything, where a point is so many units."""
        return Box.around(self.places + point * self.offsets)

    def fitted(self, room: Pair) -> Box:
        """Around everything, in a picture that has so many points for its width and height.

        What is of the same size in every picture takes more of the plane, the more of it is shown;
        so the scale is iterated. It grows by less and less, for symbols are smaller than pictures:
        in one that is too small for them, they count as far as to `MOST` of it.
        """
        bare, point = self.box(0.0), 0.0
        if bare.extent == 0.0:
            return bare
        result = bare
        wide = np.ptp(self.offsets, axis=0)
        share = float(np.min(MOST * np.asarray(room) / np.maximum(wide, MOST * np.asarray(room))))
        for _ in range(ROUNDS):
            wanted = float(np.max(result.size / room))
            if wanted <= (1.0 + SLACK) * point:
                break
            point = wanted
            result = self.box(share * point)
        return replace(result, bare=bare)


Local = Iterable[Iterable[Pair]]
"""Strokes in points along and across."""


def body_direction(pose: Pose, name: str | None, angle: float = 0.0) -> Direction:
    """An angle in the frame of a body (None: the ground), from its joints if it shows two."""
    if name is None:
        return Direction(angle)
    guide = pose.mechanism.bodies[name].guide
    if guide is not None:
        return body_direction(pose, guide.body, angle + guide.angle.value)
    apart = pose.apart(name)
    if apart is None:
        return Direction(angle, body=name)
    first, second, own = apart
    return Direction(angle - own, ends=(((first, 1.0),), ((second, 1.0),)))


def at_joint(joint: str, points: Pair = (0.0, 0.0)) -> Anchor:
    """An anchor at a joint."""
    return Anchor(((joint, 1.0),), points=points)


@dataclass(frozen=True)
class Frame:
    """Makes the shapes of one symbol, which share a direction."""

    pose: Pose  # the present position, in metres
    direction: Direction  # of all offsets

    @cached_property
    def angle(self) -> float:
        """The present direction in radians."""
        return angle_of(self.pose, self.direction)

    def fixed(self, place: ArrayLike, body: str | None, points: Pair = (0.0, 0.0)) -> Anchor:
        """At a present place that goes along with a body (None: with the ground)."""
        base: Weights = () if body is None else ((next(iter(self.pose.shown(body))), 1.0),)
        way = np.asarray(place, dtype=float) - place_of(self.pose, base)
        cos, sin = np.cos(self.angle), np.sin(self.angle)
        return Anchor(base, (float(way @ (cos, sin)), float(way @ (-sin, cos))), points)

    def symbol(
        self, centre: Anchor, strokes: Local, look: Look, *, closed: bool = False, name: str = ""
    ) -> Strokes:
        """Strokes in points about an anchor."""
        lines = tuple(tuple(moved(centre, *point) for point in stroke) for stroke in strokes)
        return Strokes(lines, look, self.direction, closed, name)

    def line(self, anchors: Iterable[Anchor], look: Look, name: str = "") -> Strokes:
        """One stroke."""
        return Strokes((tuple(anchors),), look, self.direction, name=name)


def moved(anchor: Anchor, along: float, across: float) -> Anchor:
    """An anchor so many points further."""
    first, second = anchor.points
    return Anchor(anchor.joints, anchor.metres, (first + along, second + across))


def mixed(first: Anchor, second: Anchor, share: float) -> Anchor:
    """A share of the way from one anchor to another."""
    if share in (0.0, 1.0):
        return second if share else first
    weights = {joint: (1.0 - share) * weight for joint, weight in first.joints}
    for joint, weight in second.joints:
        weights[joint] = weights.get(joint, 0.0) + share * weight
    metres, points = (
        ((1.0 - share) * a[0] + share * b[0], (1.0 - share) * a[1] + share * b[1])
        for a, b in ((first.metres, second.metres), (first.points, second.points))
    )
    return Anchor(tuple(weights.items()), metres, points)


def spanned(first: Anchor, second: Anchor, span: Span) -> list[tuple[Anchor, ...]]:
    """The strokes of a symbol that reaches from one anchor to another."""
    return [
        tuple(moved(mixed(first, second, share), x, y) for share, x, y in stroke) for stroke in span
    ]


def joints(first: str, second: str) -> Direction:
    """From one joint to another."""
    return Direction(ends=(((first, 1.0),), ((second, 1.0),)))
