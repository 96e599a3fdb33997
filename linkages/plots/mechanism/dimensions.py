"""Lengths and centres of mass of a drawing, for those who ask for them."""

from __future__ import annotations

import numpy as np

from linkages.plots.mechanism import outlining
from linkages.plots.mechanism.bodies import body_role
from linkages.plots.mechanism.frames import Frame, body_direction
from linkages.plots.mechanism.links import anchored_outlines
from linkages.plots.mechanism.placing import placed
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.shapes import Anchor, Direction, Disc, Look, Shape, Strokes, Word
from linkages.plots.prefixes import Scale

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
            found.append(Word(length, side, look, 2.0, direction, body.name))
    return found


def draw_centres(pose: Pose) -> list[Shape]:
    """A quartered circle at the centre of mass of every bar and plate that has one."""
    found: list[Shape] = []
    for name, body in pose.mechanism.bodies.items():
        place = pose.place(name, body.centre) if body.rotates and body.mass.value > 0.0 else None
        if place is not None:
            frame = Frame(pose, body_direction(pose, name))
            centre = frame.fixed(place, name)
            found += _centre_mark(centre, frame.direction, name)
    return found


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
