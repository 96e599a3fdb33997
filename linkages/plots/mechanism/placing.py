"""Where shapes are, once joints are known."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.shapes import Anchor, Direction, Shape, Weights, anchors_of

Array = NDArray[np.float64]


def place_of(pose: Pose, weights: Weights) -> Array:
    """A weighted mean of joints, in the units of the pose."""
    place = np.zeros(2)
    for joint, weight in weights:
        place += weight * np.asarray(pose.positions[joint])
    return place


def angle_of(pose: Pose, direction: Direction) -> float:
    """A direction in radians.

    Raises
    ------
    ValueError
        If the angle of its body cannot be told.
    """
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
    known = set(pose.positions)
    ends = shape.direction.ends or ()
    used = {joint for place in ends for joint, _ in place}
    used |= {joint for anchor in anchors_of(shape) for joint, _ in anchor.joints}
    body = shape.direction.body
    return used <= known and (body is None or pose.angle(body) is not None)


def swept(pose: Pose, shapes: Iterable[Shape]) -> Array:
    """What shapes cover at least, shape (n, 2): their anchors and discs without any points."""
    found = [np.empty((0, 2))]
    for shape in shapes:
        places = placed(pose, anchors_of(shape), shape.direction, 0.0)
        radius = getattr(shape, "metres", 0.0) * pose.unit
        found += [places - radius, places + radius]
    return np.vstack(found)
