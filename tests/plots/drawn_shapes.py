"""Where the shapes of a drawing are, for tests: without any paper."""

import numpy as np

from linkages.plots.mechanism.drawing import shapes_of
from linkages.plots.mechanism.placing import placed
from linkages.plots.mechanism.shapes import Disc, Strokes, Word

SCALE = 600.0
"""Points per metre of the pictures that tests have in mind."""


def shapes(pose, kind=None, **look):
    """Shapes of a drawing, of a kind and with a look."""
    found = shapes_of(pose, SCALE)
    return [
        shape
        for shape in found
        if (kind is None or isinstance(shape, kind))
        and all(getattr(shape.look, key) == value for key, value in look.items())
    ]


def strokes(pose, shape, *, points=True):
    """Strokes of a shape, shape (n, 2) each, in metres."""
    size = 1.0 / SCALE if points else 0.0
    return [placed(pose, stroke, shape.direction, size) for stroke in shape.strokes]


def corners(pose, shape):
    """All points of the strokes of a shape, in metres."""
    return np.vstack(strokes(pose, shape))


def discs(pose, **look):
    """Centre and radius of all circles, in metres."""
    return [
        (placed(pose, [disc.centre], disc.direction, 1 / SCALE)[0],
         disc.metres + disc.points / SCALE)
        for disc in shapes(pose, Disc, **look)
    ]  # fmt: skip


def arrows(pose, role):
    """From where to where each arrow of a role points, and how many heads it has."""
    found = shapes(pose, Strokes, role=role)
    shafts = [s for s in found if s.look.width > 1.0 and not s.look.casing and not s.closed]
    heads = [s for s in found if s.closed and s.look.width < 0.5]
    assert len(shafts) == len(heads)
    return [
        (strokes(pose, shaft)[0][0], strokes(pose, head)[0][0], len(head.strokes))
        for shaft, head in zip(shafts, heads, strict=True)
    ]


def words(pose):
    return [shape.text for shape in shapes(pose, Word)]
