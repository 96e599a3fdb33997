"""Shapes of a drawing as elements of SVG, in millimetres."""

from __future__ import annotations

from collections.abc import Sequence
from typing import assert_never
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from linkages.exports import Subject
from linkages.exports.geometry.parts import MILLIMETRES
from linkages.plots.mechanism.drawing import shapes_of
from linkages.plots.mechanism.palette import LIGHT
from linkages.plots.mechanism.placing import Cover, placed
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.samples import pose_at
from linkages.plots.mechanism.shapes import Disc, Look, Shape, Strokes, Word

Array = NDArray[np.float64]

POINT = 25.4 / 72.0
"""Millimetres."""


MARGIN = 1.0
"""Millimetres around symbols."""


def symbols_of(subject: Subject) -> tuple[list[str], Array, Array]:
    """The drawing of a mechanism where its motion begins; low and high corner of its box."""
    pose = pose_at(subject.solution.data, subject.mechanism, 0)
    shapes = shapes_of(pose, MILLIMETRES / POINT)
    scaled = pose.scaled(MILLIMETRES)
    box = Cover.of(scaled, shapes).box(POINT)
    return svg_elements(scaled, shapes), box.low - MARGIN, box.high + MARGIN


def svg_elements(pose: Pose, shapes: Sequence[Shape]) -> list[str]:
    """One element for each shape and each casing, in the order of drawing; y points down.

    Parameters
    ----------
    pose
        In millimetres.
    shapes
        Words are left out: where there is room for them is not known.
    """
    found = []
    for shape in shapes:
        match shape:
            case Strokes():
                found += _both(f'<path d="{_path(pose, shape)}"', shape)
            case Disc():
                ((x, y),) = placed(pose, [shape.centre], shape.direction, POINT)
                radius = shape.metres * pose.unit + shape.points * POINT
                circle = f'<circle cx="{x:.9g}" cy="{-y:.9g}" r="{radius:.9g}"'
                found += _both(circle, shape)
            case Word():
                continue
            case _:
                assert_never(shape)
    return found


def _both(element: str, shape: Strokes | Disc) -> list[str]:
    """The casing of a shape, if it has one, and the shape."""
    look, name = shape.look, f" data-name={quoteattr(shape.name)}" if shape.name else ""
    found = [f'{element}{name} style="{_style(look)}"/>']
    if look.casing:
        under = Look("paper", look.width + 2.0 * look.casing)
        found.insert(0, f'{element} style="{_style(under)}"/>')
    return found


def _path(pose: Pose, shape: Strokes) -> str:
    words = []
    for stroke in shape.strokes:
        places = placed(pose, stroke, shape.direction, POINT)
        words.append("M " + " ".join(f"{x:.9g} {-y:.9g}" for x, y in places))
        words += ["Z"] * shape.closed
    return " ".join(words)


def _style(look: Look) -> str:
    words = {
        "fill": LIGHT[look.fill] if look.fill else "none",
        "stroke": LIGHT[look.role] if look.width else "none",
        "stroke-width": f"{look.width * POINT:.4g}",
        "stroke-linecap": "butt" if look.dashes else "round",
        "stroke-linejoin": "round",
    }
    if look.fill and look.opacity < 1.0:
        words["fill-opacity"] = f"{look.opacity:g}"
    if look.dashes:
        lengths = (length * look.width * POINT for length in look.dashes)
        words["stroke-dasharray"] = " ".join(f"{length:.4g}" for length in lengths)
    return "; ".join(f"{key}: {value}" for key, value in words.items())
