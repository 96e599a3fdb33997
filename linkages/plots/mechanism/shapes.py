"""Drawings as lists of shapes that know where they belong: one for figures, films and pages.

A shape stands still in the mechanism, not on the paper. Each of its points is an anchor: a weighted
mean of joints, and an offset from there along and across the direction of the shape. So the same
list is right for any later position, and for other lengths, too.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias, assert_never

Weights: TypeAlias = tuple[tuple[str, float], ...]
"""Joints and their weights, which sum to 1; none at all is the origin of the plane."""

Pair: TypeAlias = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Anchor:
    """A point of a shape.

    Parameters
    ----------
    joints
        Where its offsets count from.
    metres, points
        Offsets along and across the direction of the shape: to scale, and in typographic points,
        which are of the same printed size in every picture.
    """

    joints: Weights
    metres: Pair = (0.0, 0.0)
    points: Pair = (0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Direction:
    """A direction in the plane: the sum of all that is given.

    Parameters
    ----------
    angle
        In radians, counter-clockwise from +x.
    ends
        From the first of two places to the second.
    body
        Whose angle counts as well.
    """

    angle: float = 0.0
    ends: tuple[Weights, Weights] | None = None
    body: str | None = None


@dataclass(frozen=True, slots=True)
class Look:
    """How a shape is drawn.

    Parameters
    ----------
    role
        Of the palette: the colour of its edge.
    width
        Of its edge in points; 0 for none.
    fill
        A role of the palette; empty for none.
    opacity
        Of its fill.
    casing
        Points of paper beside its edge, which part it from what it crosses.
    dashes
        Lengths of strokes and gaps in widths of the edge; none for a solid line.
    """

    role: str
    width: float = 0.8
    fill: str = ""
    opacity: float = 1.0
    casing: float = 0.0
    dashes: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Strokes:
    """Strokes with round ends, open or closed.

    Parameters
    ----------
    strokes
        Each a sequence of anchors.
    look
        How they are drawn.
    direction
        Of all offsets.
    closed
        Whether the last anchor of each stroke is joined to the first.
    name
        Of the component; empty for none.
    """

    strokes: tuple[tuple[Anchor, ...], ...]
    look: Look
    direction: Direction = field(default_factory=Direction)
    closed: bool = False
    name: str = ""


@dataclass(frozen=True, slots=True)
class Disc:
    """A circle about an anchor.

    Parameters
    ----------
    centre, look, direction, name
        As those of a line.
    metres, points
        Its radius is their sum.
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

    Parameters
    ----------
    text
        What it says.
    beside
        A point, both ends of a bar, or the corners of a plate.
    gap
        Least distance in points.
    look
        Its role is the colour.
    direction, name
        As those of a line.
    strong
        Whether it is bold.
    along
        Whether figures turn it into the direction of the two ends of what it is beside.
    """

    text: str
    beside: tuple[Anchor, ...]
    look: Look
    gap: float = 4.5
    direction: Direction = field(default_factory=Direction)
    name: str = ""
    strong: bool = False
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
