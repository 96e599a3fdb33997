"""Outlines of symbols, as strokes in typographic points along and across."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.plots.mechanism.shapes import Pair

Array = NDArray[np.float64]
Stroke = list[Pair]

PIN, CLEARANCE_RING, FREE_END, BOSS = 2.9, 5.4, 2.0, 5.0
BLOCK, SMALL_BLOCK = (11.0, 6.5), (8.0, 5.0)  # half length and half height
ROOM = 2.5
"""Points between a block with play and its rails."""

MASS, WEDGE = 6.0, 13.0
CUP = (13.0, 4.2)  # length and half width of a dashpot
SPIRAL, TURNS, BENT = (4.6, 11.0), 2.25, 9.5
HEAD = (7.0, 2.6)  # length and half width of an arrow's head


def rectangle(half_length: float, half_height: float, at: float = 0.0) -> Stroke:
    """Corners of a rectangle about a point of the axis."""
    a, b = half_length, half_height
    return [(at - a, -b), (at + a, -b), (at + a, b), (at - a, b)]


def hatching(left: float, right: float, y: float) -> list[Stroke]:
    """A line with hatching below it: solid ground."""
    feet = np.arange(left + 3.0, right + 0.1, 3.4).tolist()
    return [[(left, y), (right, y)], *([(x, y), (x - 3.2, y - 3.6)] for x in feet)]


def mirrored(strokes: list[Stroke]) -> list[Stroke]:
    """The same on the other side of the axis."""
    return [[(x, -y) for x, y in stroke] for stroke in strokes]


def cup(bottom: float, rim: float, middle: float, half: float) -> Stroke:
    """The cylinder of a dashpot, open at its rim."""
    low, high = middle - half, middle + half
    return [(rim, high), (bottom, high), (bottom, low), (rim, low)]


def arc(radius: float, first: float, last: float, count: int = 33) -> Stroke:
    """Points on a circle about the origin, from one angle to another."""
    turn = np.linspace(first, last, count)
    return _polar(np.full(count, radius), turn)


def cap(radius: float, outwards: float, count: int = 13) -> Stroke:
    """A half circle about the origin that bulges in a direction, counter-clockwise."""
    return arc(radius, outwards - 0.5 * np.pi, outwards + 0.5 * np.pi, count)


def spiral(count: int = 90) -> Stroke:
    """A torsional spring that ends in the direction of the axis."""
    turn = np.linspace(-2.0 * np.pi * TURNS, 0.0, count)
    radius = np.linspace(*SPIRAL, count)
    return _polar(radius, turn)


def _polar(radius: Array, turn: Array) -> Stroke:
    x, y = radius * np.cos(turn), radius * np.sin(turn)
    return list(zip(x.tolist(), y.tolist(), strict=True))


def bent_dashpot(radius: float) -> list[Stroke]:
    """A torsional damper: a dashpot bent around a pin, with its middle on the axis."""
    left, right = arc(radius, -1.3, -0.5, 9), arc(radius, 0.0, 1.3, 13)
    inner, outer = arc(radius - 3.0, -0.5, 0.5, 9), arc(radius + 3.0, 0.5, -0.5, 9)
    return [left, [*outer, *inner], [(radius - 2.0, 0.0), (radius + 2.0, 0.0)], right]


def spiral_and_dashpot(radius: float) -> list[Stroke]:
    """A torsional spring in series with a damper: one begins where the other ends."""
    bend = 1.3  # half the angle of the dashpot
    strokes = [spiral(), [(SPIRAL[1], 0.0), (radius, 0.0)]]
    strokes += [turned(stroke, bend) for stroke in bent_dashpot(radius)]
    return [turned(stroke, -bend) for stroke in strokes]


def turned(stroke: Stroke, angle: float) -> Stroke:
    """The same, turned about the origin."""
    cos, sin = float(np.cos(angle)), float(np.sin(angle))
    return [(cos * x - sin * y, sin * x + cos * y) for x, y in stroke]


def arrow_head(line: Stroke) -> Stroke:
    """The filled head of an arrow, with its tip where a line ends."""
    points = np.array(line)
    length = min(HEAD[0], 0.8 * float(np.hypot(*np.diff(points, axis=0).T).sum()))
    before = points[np.hypot(*(points - points[-1]).T) >= 0.98 * length]
    way = points[-1] - (before[-1] if len(before) else points[0])
    way = way / np.hypot(*way)
    back = points[-1] - length * way
    aside = HEAD[1] * np.array([-way[1], way[0]])
    corners = np.array([points[-1], back + aside, back - aside])
    return [(float(x), float(y)) for x, y in corners]
