"""Friction of a drawing: hatched shoes beside the pin of a joint, hatched linings in a guide."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from linkages.plots.mechanism import outlining
from linkages.plots.mechanism.blocks import BARREL, barrel_ends
from linkages.plots.mechanism.bodies import clearance_ends
from linkages.plots.mechanism.frames import Frame, body_direction, joints, moved
from linkages.plots.mechanism.guides import APART, grounded, pin_of, play_of, rod_side, travel_of
from linkages.plots.mechanism.kinds import by_kind, frictions_of
from linkages.plots.mechanism.outlining import BLOCK, ROOM, SMALL_BLOCK
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.shapes import Anchor, Direction, Look, Shape
from linkages.plots.mechanism.torsional import farthest, pivot

SHOE, HATCH = Look("friction", 0.8, "paper"), Look("friction", 0.7)
THICK = 3.8
"""Points: of a shoe."""

ROD, SHORT = 1.9, 6.0
"""Points: half the height of a rod; half the length of a lining beside it."""


class Lining(NamedTuple):
    """What rubs on both faces of a slider: around an anchor, half as long, from here to there."""

    centre: Anchor
    half: float
    inner: float
    outer: float


def draw_linings(pose: Pose, scale: float) -> list[Shape]:
    """What rubs in guides, on the faces of blocks and beside rods."""
    found: list[Shape] = []
    slides = by_kind(frictions_of(pose.mechanism)).slides
    for name in dict.fromkeys(slide.body for slide, _ in slides):
        lining = _lining(pose, name, scale)
        if lining is not None:
            frame = Frame(pose, body_direction(pose, name))
            found += _hatched(frame, lining.centre, _linings(lining), name)
    return found


def draw_shoes(pose: Pose) -> list[Shape]:
    """What rubs at joints, beside their pins or bearings."""
    found: list[Shape] = []
    for turn, _ in by_kind(frictions_of(pose.mechanism)).turns:
        joint = pivot(pose, turn)
        if joint is not None:
            far = farthest(pose, turn.body, joint)
            frame = Frame(pose, Direction(body=turn.body) if far is None else joints(joint, far))
            ring = joint in clearance_ends(pose.mechanism).values()
            inner = (outlining.CLEARANCE_RING if ring else outlining.PIN) + 1.3
            found += _hatched(frame, frame.at(joint), _shoes(inner, inner + THICK), joint)
    return found


Hatched = list[tuple[outlining.Stroke, list[outlining.Stroke]]]
"""Outlines and the strokes in them."""


def _hatched(frame: Frame, centre: Anchor, parts: Hatched, name: str) -> list[Shape]:
    edges = [edge for edge, _ in parts]
    strokes = [stroke for _, inside in parts for stroke in inside]
    return [
        frame.symbol(centre, edges, SHOE, closed=True, name=name),
        frame.symbol(centre, strokes, HATCH, name=name),
    ]


def _shoes(inner: float, outer: float) -> Hatched:
    """Two shoes, left and right of the direction that goes along."""
    found: Hatched = []
    half = min(0.95, 5.6 / inner)
    for middle in (0.5 * np.pi, -0.5 * np.pi):
        first, last = middle - half, middle + half
        edge = [*outlining.arc(inner, first, last, 13), *outlining.arc(outer, last, first, 13)]
        angles = np.linspace(first, last - 0.22 * half, 6)
        ways = [(a, a + 0.22 * half) for a in angles]
        strokes = [
            [(inner * float(np.cos(a)), inner * float(np.sin(a))),
             (outer * float(np.cos(b)), outer * float(np.sin(b)))]
            for a, b in ways
        ]  # fmt: skip
        found.append((edge, strokes))
    return found


def _lining(pose: Pose, name: str, scale: float) -> Lining | None:
    axis = pose.axis(name)
    if axis is None:
        return None
    frame, guide = Frame(pose, body_direction(pose, name)), pose.mechanism.bodies[name].guide
    assert guide is not None
    loose = play_of(pose, name) is not None
    if grounded(pose, name):
        side = rod_side(pose, name, axis, scale)
        if not side:
            face = BLOCK[1] - ROOM * loose
            return Lining(pin_of(pose, name), BLOCK[0] - 1.0, face - 2.8, face)
        low, high = travel_of(pose, name, axis)
        last = frame.fixed(axis.at(high if side > 0 else low), None)
        return Lining(moved(last, side * APART, 0.0), SHORT, ROD, ROD + 2.8)
    ends = barrel_ends(pose, name, axis)
    if ends is None:
        face = SMALL_BLOCK[1] - 0.7 * ROOM * loose
        return Lining(pin_of(pose, name), SMALL_BLOCK[0] - 1.0, face - 2.0, face)
    bottom, rim = ends
    end = frame.fixed(axis.at(rim), guide.body)
    inward = np.sign(bottom - rim) * (SHORT + 1.0)
    return Lining(moved(end, float(inward), 0.0), SHORT, ROD, BARREL - 0.6)


def _linings(lining: Lining) -> Hatched:
    """Over the axis and below it."""
    found: Hatched = []
    _, half, inner, outer = lining
    for side in (1.0, -1.0):
        edge = [(-half, side * inner), (half, side * inner),
                (half, side * outer), (-half, side * outer)]  # fmt: skip
        feet = np.linspace(-half, half - 2.0, max(3, round(half / 1.4))).tolist()
        found.append((edge, [[(x, side * inner), (x + 2.0, side * outer)] for x in feet]))
    return found
