"""Shapes of drawings, and outlines of symbols.

A shape stands still in the mechanism, not on the paper. Each of its points is an anchor: a weighted
mean of joints, and an offset from there along and across the direction of the shape. So the same
list is right for any later position, and for other lengths, too.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias, assert_never

import numpy as np
from numpy.typing import NDArray

Weights: TypeAlias = tuple[tuple[str, float], ...]
"""Joints and their weights, which sum to 1; none at all is the origin of the plane."""

Pair: TypeAlias = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Anchor:
    """A point of a shape.

    `metres`, `points`: offsets along and across the direction of the shape: to scale, and in
    typographic points, which are of the same printed size in every picture.
    """

    joints: Weights  # where its offsets count from
    metres: Pair = (0.0, 0.0)
    points: Pair = (0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Direction:
    """A direction in the plane: the sum of all that is given."""

    angle: float = 0.0  # in radians, counter-clockwise from +x
    ends: tuple[Weights, Weights] | None = None  # from the first of two places to the second
    body: str | None = None  # whose angle counts as well


@dataclass(frozen=True, slots=True)
class Look:
    """How a shape is drawn."""

    role: str  # of the palette: the colour of its edge
    width: float = 0.8  # of its edge in points; 0 for none
    fill: str = ""  # a role of the palette; empty for none
    opacity: float = 1.0  # of its fill
    casing: float = 0.0  # points of paper beside its edge, which part it from what it crosses
    # Lengths of strokes and gaps in widths of the edge; none for a solid line
    dashes: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Strokes:
    """Strokes with round ends, open or closed."""

    strokes: tuple[tuple[Anchor, ...], ...]  # each a sequence of anchors
    look: Look  # how they are drawn
    direction: Direction = field(default_factory=Direction)  # of all offsets
    closed: bool = False  # whether the last anchor of each stroke is joined to the first
    name: str = ""  # of the component; empty for none


@dataclass(frozen=True, slots=True)
class Disc:
    """A circle about an anchor.

    `centre`, `look`, `direction`, `name`: as those of a line.
    `metres`, `points`: its radius is their sum.
    """

    centre: Anchor
    look: Look
    metres: float = 0.0
    points: float = 0.0
    direction: Direction = field(default_factory=Direction)
    name: str = ""


@dataclass(frozen=True, slots=True)
class Word:
    """A text beside something, to be placed where there is room.

    `direction`, `name`: as those of a line.
    """

    text: str  # what it says
    beside: tuple[Anchor, ...]  # a point, both ends of a bar, or the corners of a plate
    look: Look  # its role is the colour
    gap: float = 4.5  # least distance in points
    direction: Direction = field(default_factory=Direction)
    name: str = ""
    strong: bool = False  # whether it is bold
    # Whether figures turn it into the direction of the two ends of what it is beside
    along: bool = False


Shape: TypeAlias = Strokes | Disc | Word


def anchors_of(shape: Shape) -> list[Anchor]:
    """All points of a shape."""
    match shape:
        case Strokes():
            return [anchor for stroke in shape.strokes for anchor in stroke]
        case Disc():
            return [shape.centre]
        case Word():
            return list(shape.beside)
        case _:
            assert_never(shape)


def stands_still(shape: Shape, ground: Iterable[str]) -> bool:
    """Whether a shape never moves: its joints are on the ground, and its direction is fixed."""
    fixed = set(ground)
    ends = shape.direction.ends or ()
    used = [joint for place in ends for joint, _ in place]
    used += [joint for anchor in anchors_of(shape) for joint, _ in anchor.joints]
    return shape.direction.body is None and fixed.issuperset(used)


def as_json(shapes: Sequence[Shape]) -> list[dict[str, Any]]:
    """Plain lists, numbers and texts, in the order of drawing.

    Every shape has ``kind`` ("line", "disc" or "word"), ``name``, ``role``, ``width``, ``fill``,
    ``opacity``, ``casing``, ``dashes``, and ``direction``: ``angle`` in radians, ``ends`` (two
    objects of joint → weight, or null) and ``body`` (or null). A line has ``strokes`` (lists of
    anchors) and ``closed``, a disc ``centre`` and its radius as ``metres`` and ``points``, a word
    ``text``, ``beside`` (anchors), ``gap`` and ``strong``. An anchor is a list: an object of
    joint → weight, metres along and across, points along and across.
    """
    return [_plain(shape) for shape in shapes]


def _plain(shape: Shape) -> dict[str, Any]:
    look, direction = shape.look, shape.direction
    ends = None if direction.ends is None else [dict(place) for place in direction.ends]
    common = {
        "name": shape.name,
        "role": look.role,
        "width": look.width,
        "fill": look.fill,
        "opacity": look.opacity,
        "casing": look.casing,
        "dashes": list(look.dashes),
        "direction": {"angle": direction.angle, "ends": ends, "body": direction.body},
    }
    match shape:
        case Strokes():
            strokes = [[_listed(anchor) for anchor in stroke] for stroke in shape.strokes]
            return {"kind": "line", **common, "strokes": strokes, "closed": shape.closed}
        case Disc():
            radius = {"metres": shape.metres, "points": shape.points}
            return {"kind": "disc", **common, "centre": _listed(shape.centre), **radius}
        case Word():
            beside = [_listed(anchor) for anchor in shape.beside]
            more = {"text": shape.text, "gap": shape.gap, "strong": shape.strong}
            return {"kind": "word", **common, "beside": beside, **more}
        case _:
            assert_never(shape)


def _listed(anchor: Anchor) -> list[Any]:
    return [dict(anchor.joints), *anchor.metres, *anchor.points]


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
