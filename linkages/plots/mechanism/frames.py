"""From places in one position to anchors: what a shape goes along with."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.plots.mechanism.placing import angle_of, place_of
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.shapes import Anchor, Direction, Look, Pair, Strokes, Weights

Array = NDArray[np.float64]
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


@dataclass(frozen=True)
class Frame:
    """Makes the anchors of one shape, which share a direction.

    Parameters
    ----------
    pose
        The present position, in metres.
    direction
        Of all offsets.
    """

    pose: Pose
    direction: Direction

    @cached_property
    def angle(self) -> float:
        """The present direction in radians."""
        return angle_of(self.pose, self.direction)

    def at(self, joint: str, points: Pair = (0.0, 0.0)) -> Anchor:
        """At a joint."""
        return Anchor(((joint, 1.0),), points=points)

    def between(self, first: str, second: str, share: float, points: Pair = (0.0, 0.0)) -> Anchor:
        """A share of the way from one joint to another."""
        return Anchor(((first, 1.0 - share), (second, share)), points=points)

    def fixed(self, place: ArrayLike, body: str | None, points: Pair = (0.0, 0.0)) -> Anchor:
        """At a present place that goes along with a body (None: with the ground)."""
        base: Weights = ()
        if body is not None:
            base = ((next(iter(self.pose.shown(body))), 1.0),)
        return self.beside(base, place, points)

    def beside(self, base: Weights, place: ArrayLike, points: Pair = (0.0, 0.0)) -> Anchor:
        """At a present place that keeps its offset from some joints."""
        way = np.asarray(place, dtype=float) - place_of(self.pose, base)
        cos, sin = np.cos(self.angle), np.sin(self.angle)
        metres = (float(way @ (cos, sin)), float(way @ (-sin, cos)))
        return Anchor(base, metres, points)

    def symbol(
        self, centre: Anchor, strokes: Local, look: Look, *, closed: bool = False, name: str = ""
    ) -> Strokes:
        """Strokes in points about an anchor."""
        return Strokes(
            tuple(tuple(moved(centre, *point) for point in stroke) for stroke in strokes),
            look, self.direction, closed, name,
        )  # fmt: skip

    def line(self, anchors: Iterable[Anchor], look: Look, name: str = "") -> Strokes:
        """One stroke."""
        return Strokes((tuple(anchors),), look, self.direction, name=name)


def moved(anchor: Anchor, along: float, across: float) -> Anchor:
    """An anchor so many points further."""
    first, second = anchor.points
    return Anchor(anchor.joints, anchor.metres, (first + along, second + across))


def mixed(first: Anchor, second: Anchor, share: float) -> Anchor:
    """A share of the way from one anchor to another."""
    weights = {joint: (1.0 - share) * weight for joint, weight in first.joints}
    for joint, weight in second.joints:
        weights[joint] = weights.get(joint, 0.0) + share * weight
    metres, points = (
        (
            (1.0 - share) * a[0] + share * b[0],
            (1.0 - share) * a[1] + share * b[1],
        )
        for a, b in ((first.metres, second.metres), (first.points, second.points))
    )
    return Anchor(tuple(weights.items()), metres, points)


def towards(first: Weights, second: Weights) -> Direction:
    """From one place to another."""
    return Direction(ends=(first, second))


def joints(first: str, second: str) -> Direction:
    """From one joint to another."""
    return towards(((first, 1.0),), ((second, 1.0),))
