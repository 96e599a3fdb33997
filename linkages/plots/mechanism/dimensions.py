"""Lengths, the ground's frame and centres of mass of a drawing, for those who ask for them."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from linkages.plots.mechanism import outlining
from linkages.plots.mechanism.bodies import body_role
from linkages.plots.mechanism.frames import Frame, body_direction, joints
from linkages.plots.mechanism.links import anchored_outlines
from linkages.plots.mechanism.placing import placed
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.shapes import Anchor, Direction, Disc, Look, Shape, Strokes, Word
from linkages.plots.prefixes import Scale

Array = NDArray[np.float64]

FRAME, ANGLE = Look("ink", 0.6, dashes=(9.0, 4.0)), Look("ink", 0.6)
ARC = 20.0
"""Points: radius of the arc of an angle."""

CENTRE = 3.4
"""Points: radius of the mark of a centre of mass."""


def length_words(pose: Pose, scale: Scale) -> list[Word]:
    """The length of every bar and of every side of a plate, for a position in metres."""
    found = []
    for body, corners, direction in anchored_outlines(pose):
        look = Look(body_role(pose.mechanism, body.name))
        places = placed(pose, corners, direction, 0.0)
        sides = range(len(corners) if len(corners) > 2 else 1)
        for first, last in ((index, (index + 1) % len(corners)) for index in sides):
            length = scale.text(float(np.hypot(*(places[last] - places[first]))))
            side = (corners[first], corners[last])
            found.append(Word(length, side, look, 2.0, direction, body.name, along=True))
    return found


def frame_lines(pose: Pose) -> list[Strokes]:
    """Thin lines between the pivots on the ground, one after the other; arcs at those that rise."""
    found = []
    for first, second, angle in _frame(pose):
        line = Frame(pose, joints(first, second))
        found.append(line.line((line.at(first), line.at(second)), FRAME))
        if angle:
            frame = Frame(pose, Direction())
            arc = outlining.arc(ARC, 0.0, angle)
            level = [(0.0, 0.0), (ARC + 6.0, 0.0)]
            found.append(frame.symbol(frame.at(first), [arc, level], ANGLE))
    return found


def frame_words(pose: Pose, scale: Scale) -> list[Word]:
    """How far pivots on the ground are apart, and at what angle one is seen from another."""
    found = []
    for first, second, angle in _frame(pose):
        way = np.subtract(pose.positions[second], pose.positions[first])
        ends = (Anchor(((first, 1.0),)), Anchor(((second, 1.0),)))
        found.append(Word(scale.text(float(np.hypot(*way))), ends, Look("ink"), 2.0, along=True))
        if angle:
            half = (ARC * float(np.cos(0.5 * angle)), ARC * float(np.sin(0.5 * angle)))
            text = f"{np.degrees(angle):.4g}°".replace("-", "−")
            found.append(Word(text, (Anchor(((first, 1.0),), points=half),), Look("ink"), 2.0))
    return found


def _frame(pose: Pose) -> list[tuple[str, str, float]]:
    """Pivots on the ground in pairs, from left to right, and the angle of the line between them.

    0 for lines that are level or upright, which need no angle.
    """
    turning = {joint for body in pose.mechanism.bodies.values() for joint in body.points}
    pivots = [j for j in pose.mechanism.ground if j in turning and j in pose.positions]
    pivots.sort(key=lambda joint: pose.positions[joint])
    found = []
    for first, second in pairwise(pivots):
        across, up = np.subtract(pose.positions[second], pose.positions[first])
        near = 1e-9 * pose.extent
        plain = abs(across) <= near or abs(up) <= near
        found.append((first, second, 0.0 if plain else float(np.arctan2(up, across))))
    return found


def draw_centres(pose: Pose) -> list[Shape]:
    """A quartered circle at the centre of mass of every bar and plate that has one."""
    return [
        shape
        for name, frame, place in _centres(pose)
        for shape in _centre_mark(frame.fixed(place, name), frame.direction, name)
    ]


def centre_lines(pose: Pose) -> list[Strokes]:
    """Thin lines from centres of mass to the nearest joints, which are seen beside bodies alone."""
    found = []
    for name, frame, place in _centres(pose):
        near = min(pose.shown(name).items(), key=lambda item: float(np.hypot(*(item[1] - place))))[
            0
        ]
        found.append(frame.line((frame.fixed(place, name), frame.at(near)), ANGLE))
    return found


def _centres(pose: Pose) -> Iterator[tuple[str, Frame, Array]]:
    """Bodies with their frames and the places of their centres of mass."""
    for name, body in pose.mechanism.bodies.items():
        place = pose.place(name, body.centre) if body.rotates and body.mass.value > 0.0 else None
        if place is not None:
            yield name, Frame(pose, body_direction(pose, name)), place


def _centre_mark(centre: Anchor, direction: Direction, name: str) -> list[Shape]:
    quarters = [
        [(0.0, 0.0), *outlining.arc(CENTRE, first, first + 0.5 * np.pi, 9)]
        for first in (0.0, np.pi)
    ]
    strokes = tuple(
        tuple(Anchor(centre.joints, centre.metres, (along, across)) for along, across in quarter)
        for quarter in quarters
    )
    return [
        Disc(centre, Look("ink", 0.7, "paper"), points=CENTRE, direction=direction, name=name),
        Strokes(strokes, Look("ink", 0.0, "ink"), direction, closed=True, name=name),
    ]
