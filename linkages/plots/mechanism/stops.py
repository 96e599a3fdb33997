"""Stops of a drawing: walls across axes, edges beside bars, ropes."""

from __future__ import annotations

import numpy as np

from linkages.components.contributed.revolute import GROUND
from linkages.components.stop import AngleStop, DistanceStop, GuideStop
from linkages.plots.mechanism import outlining
from linkages.plots.mechanism.frames import Frame, body_direction, joints
from linkages.plots.mechanism.guides import grounded, half_length
from linkages.plots.mechanism.kinds import stops_of
from linkages.plots.mechanism.outlining import BLOCK
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.shapes import Look, Shape

EDGE = (9.0, 21.0)
"""Points from a pin to both ends of an edge that a bar meets."""


def draw_stops(pose: Pose) -> list[Shape]:
    """All stops whose place is known."""
    found: list[Shape] = []
    for stop in stops_of(pose.mechanism):
        match stop:
            case GuideStop():
                found += _walls(pose, stop)
            case AngleStop():
                found += _edges(pose, stop)
            case DistanceStop():
                found += _rope(pose, stop)
    return found


def _walls(pose: Pose, stop: GuideStop) -> list[Shape]:
    """A hatched wall where the block of a slider meets it."""
    axis = pose.axis(stop.slider)
    if axis is None:
        return []
    frame = Frame(pose, body_direction(pose, stop.slider))
    guide = pose.mechanism.bodies[stop.slider].guide
    carrier = None if guide is None or grounded(pose, stop.slider) else guide.body
    found: list[Shape] = []
    for limit, side in ((stop.lower, -1.0), (stop.upper, 1.0)):
        if limit is not None:
            across = outlining.hatching(-BLOCK[1], BLOCK[1], -half_length(pose, stop.slider))
            strokes = [[(-side * y, x) for x, y in stroke] for stroke in across]
            centre = frame.fixed(axis.at(limit * pose.unit), carrier)
            found.append(frame.symbol(centre, strokes, Look("ink", 1.0), name=stop.slider))
    return found


def _edges(pose: Pose, stop: AngleStop) -> list[Shape]:
    """Hatched edges beside a pin, where the line between a bar's joints meets them."""
    first, second = stop.bars
    shown = pose.shown(second)
    others = pose.mechanism.ground if first == GROUND else pose.shown(first)
    joint = next((name for name in shown if name in others), None)
    apart = pose.apart(second)
    if joint is None or apart is None:
        return []
    # from the pin, a bar may lie in the other direction than its own axis
    own = apart[2] + (np.pi if joint == apart[1] else 0.0)
    found: list[Shape] = []
    for limit, side in ((stop.lower, -1.0), (stop.upper, 1.0)):
        if limit is not None:
            angle = float(own + limit)
            frame = Frame(pose, body_direction(pose, None if first == GROUND else first, angle))
            edge = outlining.hatching(*EDGE, 0.0)
            strokes = edge if side < 0 else outlining.mirrored(edge)
            found.append(frame.symbol(frame.at(joint), strokes, Look("ink", 1.0), name=second))
    return found


def _rope(pose: Pose, stop: DistanceStop) -> list[Shape]:
    """A dashed line between two joints."""
    first, second = stop.between
    if not {first, second} <= set(pose.positions):
        return []
    frame = Frame(pose, joints(first, second))
    return [frame.line((frame.at(first), frame.at(second)), Look("ink", 0.8, dashes=(4.0, 3.0)))]
