"""Symbols of mechanism drawings, of the same printed size in every picture.

All lengths are typographic points; `place` is in the units of the axes.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, PathPatch
from matplotlib.path import Path
from matplotlib.transforms import Affine2D, ScaledTranslation, Transform
from numpy.typing import ArrayLike, NDArray

from linkages.plots.mechanism.view import per_point, pixels
from linkages.plots.style import BLACK, CLEARANCE, PALE

Array = NDArray[np.float64]
Place = tuple[float, float]

PIN, CLEARANCE_RING, FREE_END = 2.9, 5.4, 2.0
BLOCK, SMALL_BLOCK = (11.0, 6.5), (8.0, 5.0)  # half length and half height
ROOM = 2.5
"""Points between a block with play and its rails."""

MASS, WEDGE = 6.0, 13.0
LAYER = 5


def anchored(ax: Axes, place: Place, angle: float = 0.0) -> Transform:
    """From points, turned by `angle` about the origin, to a place of the axes."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    inches = Affine2D().rotate(angle).scale(1 / 72) + figure.dpi_scale_trans
    return inches + ScaledTranslation(*place, cast(Any, ax.transData))


def stroked(strokes: list[list[Place]]) -> Path:
    """A path of polylines."""
    vertices = [vertex for stroke in strokes for vertex in stroke]
    codes = [
        Path.MOVETO if i == 0 else Path.LINETO for stroke in strokes for i in range(len(stroke))
    ]
    return Path(vertices, codes)


def hatching(left: float, right: float, y: float) -> list[list[Place]]:
    """A line with hatching below it: solid ground."""
    feet = np.arange(left + 3.0, right + 0.1, 3.4)
    return [[(left, y), (right, y)], *([(x, y), (x - 3.2, y - 3.6)] for x in feet)]


def add_path(
    ax: Axes,
    path: Path,
    transform: Transform,
    *,
    fill: str = "none",
    edge: str = BLACK,
    width: float = 0.8,
    layer: float = LAYER - 1,
) -> None:
    """Draw a path of a symbol; as a plain artist, for which no limits of data are computed."""
    style = {"facecolor": fill, "edgecolor": edge, "linewidth": width}
    ax.add_artist(PathPatch(path, transform=transform, zorder=layer, **cast(Any, style)))


def ground_pin(ax: Axes, place: Place, direction: float) -> Array:
    """A bearing on hatched ground, which lies towards `direction`; return pixels it covers."""
    transform = anchored(ax, place, direction + np.pi / 2)
    triangle = Path([(0, 0), (-5.5, -9.5), (5.5, -9.5), (0, 0)])
    add_path(ax, triangle, transform, fill=PALE)
    add_path(ax, stroked(hatching(-9.0, 9.0, -9.5)), transform)
    x, y = np.meshgrid(np.linspace(-10, 10, 11), np.linspace(-13, 0, 8))
    keep = np.abs(x) <= np.where(y < -8.5, 10, 5.5)
    return np.asarray(transform.transform(np.column_stack((x[keep], y[keep]))))


def rails(ax: Axes, ends: Array, angle: float) -> Array:
    """The guide of a block that goes from one place to another; return pixels it covers.

    Parameters
    ----------
    ax
        Where to draw.
    ends
        The block's first and last place along the axis, shape (2, 2); they may be the same.
    angle
        Direction of the axis.
    """
    way = np.subtract(*pixels(ax, ends[::-1])) / per_point(ax)
    first, last = sorted((0.0, float(way @ (np.cos(angle), np.sin(angle)))))
    transform = anchored(ax, (float(ends[0, 0]), float(ends[0, 1])), angle)
    left, right, height = first - 2 * BLOCK[0], last + 2 * BLOCK[0], BLOCK[1] + 1.2
    add_path(ax, stroked([[(left, height), (right, height)]]), transform)
    add_path(ax, stroked(hatching(left, right, -height)), transform)
    return grid(
        transform,
        np.linspace(left, right, int(right - left) // 2 + 2),
        np.linspace(-height - 4, height, 9),
    )


def block(ax: Axes, place: Place, angle: float) -> Array:
    """A block that rails on the ground guide; return pixels it covers."""
    return _block(ax, place, angle, BLOCK, LAYER - 1)


def loose_block(ax: Axes, place: Place, angle: float) -> Array:
    """A block with room between its rails; return pixels it covers."""
    return _block(ax, place, angle, (BLOCK[0], BLOCK[1] - ROOM), LAYER - 1)


def moving_block(ax: Axes, place: Place, angle: float) -> Array:
    """A block without rails, for an axis that moves; return pixels it covers."""
    return _block(ax, place, angle, SMALL_BLOCK, LAYER - 0.5)


def _block(ax: Axes, place: Place, angle: float, half: Place, layer: float) -> Array:
    transform = anchored(ax, place, angle)
    a, b = half
    add_path(ax, _rectangle(a, b), transform, fill=PALE, layer=layer)
    return grid(transform, np.linspace(-a, a, 11), np.linspace(-b, b, 7))


def _rectangle(a: float, b: float) -> Path:
    return Path([(-a, -b), (a, -b), (a, b), (-a, b), (-a, -b)])


def slot(ax: Axes, ends: Array, edge: str) -> Array:
    """A slot with round ends between two points, shape (2, 2); return pixels it covers."""
    way = np.subtract(*pixels(ax, ends[::-1])) / per_point(ax)
    length, radius = float(np.hypot(*way)), SMALL_BLOCK[1]
    half = np.linspace(-np.pi / 2, np.pi / 2, 13)
    cap = radius * np.column_stack((np.cos(half), np.sin(half)))
    outline = np.vstack((cap + np.array([length, 0.0]), -cap))
    outline = np.vstack((outline, outline[:1]))
    transform = anchored(ax, (float(ends[0, 0]), float(ends[0, 1])), float(np.arctan2(*way[::-1])))
    add_path(ax, Path(outline), transform, fill="white", edge=edge, width=1.4, layer=LAYER - 0.7)
    return grid(transform, np.linspace(-radius, length + radius, 40), (-radius, 0.0, radius))


def point_mass(ax: Axes, place: Place) -> Array:
    """A concentrated mass; return pixels it covers."""
    return _ring(ax, place, MASS, BLACK, BLACK, LAYER + 0.5)


def fixed_end(ax: Axes, place: Place, direction: float) -> Array:
    """Hatched ground that a body is welded to, which lies towards `direction`."""
    transform = anchored(ax, place, direction + np.pi / 2)
    add_path(ax, stroked(hatching(-9.0, 9.0, 0.0)), transform)
    return grid(transform, np.linspace(-10, 10, 11), np.linspace(-4, 0, 4))


def wedge(ax: Axes, place: Place, first: float, second: float, colour: str) -> Array:
    """The filled corner of two bodies welded together, which point these ways."""
    ways = np.array([[np.cos(angle), np.sin(angle)] for angle in (first, second)])
    corner = np.vstack((np.zeros(2), WEDGE * ways))
    if abs(ways[0, 0] * ways[1, 1] - ways[0, 1] * ways[1, 0]) < 0.2:  # in line: a sleeve
        across = 0.3 * np.array([-ways[0, 1], ways[0, 0]])
        ends = 0.5 * np.array([1.0, 1.0, -1.0, -1.0])[:, None] * ways[0]
        corner = WEDGE * (ends + np.array([1.0, -1.0, -1.0, 1.0])[:, None] * across)
    transform = anchored(ax, place)
    outline = Path(np.vstack((corner, corner[:1])))
    add_path(ax, outline, transform, fill=colour, edge=colour, layer=LAYER - 0.6)
    return np.asarray(transform.transform(np.vstack((corner, corner.mean(axis=0)))))


def pin(ax: Axes, place: Place, *, radius: float = PIN, fill: str = "white") -> Array:
    """A pin that bodies turn on; return pixels it covers."""
    return _ring(ax, place, radius, fill, BLACK, LAYER + 1)


def clearance(ax: Axes, place: Place) -> Array:
    """The second circle around a pin with clearance; return pixels it covers."""
    return _ring(ax, place, CLEARANCE_RING, "white", CLEARANCE, LAYER)


def _ring(ax: Axes, place: Place, radius: float, fill: str, edge: str, layer: float) -> Array:
    ax.add_artist(
        Circle(
            (0, 0),
            radius,
            transform=anchored(ax, place),
            facecolor=fill,
            edgecolor=edge,
            linewidth=0.9,
            zorder=layer,
        )
    )
    return around(ax, place, np.linspace(0, 2 * np.pi, 13)[:-1], radius)


def grid(transform: Transform, x: ArrayLike, y: ArrayLike) -> Array:
    """Pixels of a grid of points, from places along both axes."""
    columns = [places.ravel() for places in np.meshgrid(x, y)]
    return np.asarray(transform.transform(np.column_stack(columns)))


def around(ax: Axes, place: Place, angles: Array, radius: float) -> Array:
    """Pixels on a circle in points about a place."""
    circle = np.column_stack((np.cos(angles), np.sin(angles)))
    return pixels(ax, place) + radius * per_point(ax) * circle
