"""Shapes of drawings, and symbols as data.

A shape stands still in the mechanism, not on the paper. Each of its points is an anchor: a weighted
mean of joints, and an offset from there along and across the direction of the shape. So the same
list is right for any later position, and for other lengths, too.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np

Weights: TypeAlias = tuple[tuple[str, float], ...]
"""Joints and their weights, which sum to 1; none at all is the origin of the plane."""

Pair: TypeAlias = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Anchor:
    """A point of a shape, with offsets along and across the direction of the shape."""

    joints: Weights  # where its offsets count from
    metres: Pair = (0.0, 0.0)  # to scale
    points: Pair = (0.0, 0.0)  # typographic ones: of the same printed size in every picture


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
    look: Look
    direction: Direction = field(default_factory=Direction)  # of all offsets
    closed: bool = False  # whether the last anchor of each stroke is joined to the first
    name: str = ""  # of the component; empty for none


@dataclass(frozen=True, slots=True)
class Disc:
    """A circle about an anchor; its radius is the sum of its metres and points."""

    centre: Anchor
    look: Look
    metres: float = 0.0
    points: float = 0.0
    direction: Direction = field(default_factory=Direction)
    name: str = ""


@dataclass(frozen=True, slots=True)
class Word:
    """A text beside something, to be placed where there is room."""

    text: str
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
    if isinstance(shape, Strokes):
        return [anchor for stroke in shape.strokes for anchor in stroke]
    return [shape.centre] if isinstance(shape, Disc) else [*shape.beside]


def joints_of(shape: Shape) -> set[str]:
    """All joints that the place of a shape depends on."""
    weights = [*(shape.direction.ends or ()), *(anchor.joints for anchor in anchors_of(shape))]
    return {joint for place in weights for joint, _ in place}


def stands_still(shape: Shape, ground: Iterable[str]) -> bool:
    """Whether a shape never moves: its joints are on the ground, and its direction is fixed."""
    return shape.direction.body is None and joints_of(shape) <= {*ground}


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
    ends = direction.ends and [dict(place) for place in direction.ends]
    common = {
        "name": shape.name, "role": look.role, "width": look.width, "fill": look.fill,
        "opacity": look.opacity, "casing": look.casing, "dashes": [*look.dashes],
        "direction": {"angle": direction.angle, "ends": ends, "body": direction.body},
    }  # fmt: skip
    places = [[dict(a.joints), *a.metres, *a.points] for a in anchors_of(shape)]
    if isinstance(shape, Strokes):
        rest = iter(places)
        strokes = [[next(rest) for _ in stroke] for stroke in shape.strokes]
        return {"kind": "line", **common, "strokes": strokes, "closed": shape.closed}
    if isinstance(shape, Disc):
        radius = {"metres": shape.metres, "points": shape.points}
        return {"kind": "disc", **common, "centre": places[0], **radius}
    more = {"text": shape.text, "gap": shape.gap, "strong": shape.strong}
    return {"kind": "word", **common, "beside": places, **more}


Stroke = list[Pair]

PIN, CLEARANCE_RING, FREE_END, BOSS, MASS = 2.9, 5.4, 2.0, 5.0, 6.0
"""Points: radii of discs at joints."""

BLOCK, SMALL_BLOCK = (11.0, 6.5), (8.0, 5.0)  # half length and half height
ROOM = 2.5  # points between a block with play and its rails
CUP = (13.0, 4.2)  # length and half width of a dashpot
SPIRAL, TURNS, BENT = (4.6, 11.0), 2.25, 9.5
HEAD = (7.0, 2.6)  # length and half width of an arrow's head
SPACING, FOOT = 3.4, (-3.2, -3.6)
"""Points from one line of hatching to the next, and from its begin to its end."""


def rectangle(half_length: float, half_height: float) -> Stroke:
    """Corners of a rectangle about the origin."""
    return [(half_length * x, half_height * y) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]


def hatching(left: float, right: float, y: float) -> list[Stroke]:
    """A line with hatching below it: solid ground."""
    feet = np.arange(left + 3.0, right + 0.1, SPACING).tolist()
    return [[(left, y), (right, y)], *([(x, y), (x + FOOT[0], y + FOOT[1])] for x in feet)]


def mirrored(strokes: list[Stroke]) -> list[Stroke]:
    """The same on the other side of the axis."""
    return [[(x, -y) for x, y in stroke] for stroke in strokes]


def arc(radius: float, first: float, last: float, count: int = 33) -> Stroke:
    """Points on a circle about the origin, from one angle to another."""
    return _polar(radius, np.linspace(first, last, count))


def _polar(radius: Any, turn: Any) -> Stroke:
    return list(
        zip((radius * np.cos(turn)).tolist(), (radius * np.sin(turn)).tolist(), strict=True)
    )


def spiral(count: int = 90) -> Stroke:
    """A torsional spring that ends in the direction of the axis."""
    return _polar(np.linspace(*SPIRAL, count), np.linspace(-2.0 * np.pi * TURNS, 0.0, count))


def bent_dashpot(radius: float) -> list[Stroke]:
    """A torsional damper: a dashpot bent around a pin, with its middle on the axis."""
    cup = [*arc(radius + 3.0, 0.5, -0.5, 9), *arc(radius - 3.0, -0.5, 0.5, 9)]
    piston = [(radius - 2.0, 0.0), (radius + 2.0, 0.0)]
    return [arc(radius, -1.3, -0.5, 9), cup, piston, arc(radius, 0.0, 1.3, 13)]


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
    back, aside = points[-1] - length * way, HEAD[1] * np.array([-way[1], way[0]])
    return [(float(x), float(y)) for x, y in (points[-1], back + aside, back - aside)]


# Symbols that reach from one anchor to another: each vertex is a share of the way, and points along
# and across from there.

Vertex = tuple[float, float, float]
Span = list[list[Vertex]]

COIL, AMPLITUDE, COILS = 8.0, 4.5, (4, 14)  # points along and across; fewest and most


def zigzag(length: float, first: float = 0.0, last: float = 1.0) -> Span:
    """A spring: coils all along the way, which part as it is drawn out."""
    coils = int(np.clip(round(length / COIL), *COILS))
    shares = first + (last - first) * (np.arange(2 * coils) + 0.5) / (2 * coils)
    heights = min(AMPLITUDE, 0.3 * length) * (-1.0) ** np.arange(2 * coils)
    teeth = [(share, 0.0, y) for share, y in zip(shares.tolist(), heights.tolist(), strict=True)]
    return [[(first, 0.0, 0.0), *teeth, (last, 0.0, 0.0)]]


def dashpot(length: float, first: float = 0.0, last: float = 1.0) -> Span:
    """A cup about the middle, and a piston in it."""
    middle, a, half = 0.5 * (first + last), 0.5 * min(CUP[0], 0.6 * length), CUP[1]
    return [
        [(first, 0.0, 0.0), (middle, -a, 0.0)],
        [(middle, a, half), (middle, -a, half), (middle, -a, -half), (middle, a, -half)],
        [(middle, 0.0, 0.7 * half), (middle, 0.0, -0.7 * half)],
        [(middle, 0.0, 0.0), (last, 0.0, 0.0)],
    ]


def cylinder(length: float) -> Span:
    """A barrel that ends with its own length, and a rod with a piston in it."""
    half, bottom, rim, piston = CUP[1], 0.08 * length, 0.62 * length, -0.58 * length
    corners = [(0.0, x, y) for x, y in ((rim, 1), (bottom, 1), (bottom, -1), (rim, -1), (rim, 1))]
    return [
        [(0.0, 0.0, 0.0), (0.0, bottom, 0.0)],
        [(share, x, half * y) for share, x, y in corners],
        [(1.0, piston, 0.8 * half), (1.0, piston, -0.8 * half)],
        [(1.0, piston, 0.0), (1.0, 0.0, 0.0)],
    ]


SPANS = {
    "spring": zigzag,
    "damper": dashpot,
    "series": lambda length: [*zigzag(0.5 * length, 0.0, 0.5), *dashpot(0.5 * length, 0.5, 1.0)],
    "cylinder": cylinder,
    "actuator": cylinder,
}
"""What lies between two joints → its strokes, for a length in points."""
