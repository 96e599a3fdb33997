"""Symbols of mechanism drawings, of the same printed size in every picture.

All lengths are typographic points; `place` is in the units of the axes.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrowPatch, PathPatch
from matplotlib.path import Path
from matplotlib.transforms import Affine2D, ScaledTranslation, Transform
from numpy.typing import NDArray

from linkages.plots.style import BLACK, CLEARANCE, PALE
from linkages.plots.view import per_point, pixels

Array = NDArray[np.float64]
Place = tuple[float, float]

PIN, CLEARANCE_RING, FREE_END = 2.9, 5.4, 2.0
ARROW_RADII, ARROW_SPAN = (11.0, 18.0), 1.9
BLOCK = (11.0, 6.5)  # half length and half height
_LAYER = 5


def anchored(ax: Axes, place: Place, angle: float = 0.0) -> Transform:
    """From points, turned by `angle` about the origin, to a place of the axes."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    inches = Affine2D().rotate(angle).scale(1 / 72) + figure.dpi_scale_trans
    return inches + ScaledTranslation(*place, cast(Any, ax.transData))


def _lines(strokes: list[list[Place]]) -> Path:
    vertices = [vertex for stroke in strokes for vertex in stroke]
    codes = [
        Path.MOVETO if i == 0 else Path.LINETO for stroke in strokes for i in range(len(stroke))
    ]
    return Path(vertices, codes)


def _hatching(left: float, right: float, y: float) -> list[list[Place]]:
    """A line with hatching below it: solid ground."""
    feet = np.arange(left + 3.0, right + 0.1, 3.4)
    return [[(left, y), (right, y)], *([(x, y), (x - 3.2, y - 3.6)] for x in feet)]


def _add(ax: Axes, path: Path, transform: Transform, *, fill: str = "none", layer: float) -> None:
    ax.add_patch(
        PathPatch(
            path, transform=transform, facecolor=fill, edgecolor=BLACK, linewidth=0.8, zorder=layer
        )
    )


def ground_pin(ax: Axes, place: Place, direction: float) -> Array:
    """A bearing on hatched ground, which lies towards `direction`; return pixels it covers."""
    transform = anchored(ax, place, direction + np.pi / 2)
    triangle = Path([(0, 0), (-5.5, -9.5), (5.5, -9.5), (0, 0)])
    _add(ax, triangle, transform, fill=PALE, layer=_LAYER - 1)
    _add(ax, _lines(_hatching(-9.0, 9.0, -9.5)), transform, layer=_LAYER - 1)
    x, y = np.meshgrid(np.linspace(-10, 10, 11), np.linspace(-13, 0, 8))
    keep = np.abs(x) <= np.where(y < -8.5, 10, 5.5)
    return np.asarray(transform.transform(np.column_stack((x[keep], y[keep]))))


def slider_block(ax: Axes, place: Place, angle: float) -> Array:
    """A block between its rails, the lower one hatched; return pixels it covers."""
    transform = anchored(ax, place, angle)
    a, b = BLOCK
    block = Path([(-a, -b), (a, -b), (a, b), (-a, b), (-a, -b)])
    _add(ax, block, transform, fill=PALE, layer=_LAYER - 1)
    rails = [[(-2 * a, b + 1.2), (2 * a, b + 1.2)], *_hatching(-2 * a, 2 * a, -b - 1.2)]
    _add(ax, _lines(rails), transform, layer=_LAYER - 1)
    x, y = np.meshgrid(np.linspace(-2 * a, 2 * a, 15), np.linspace(-b - 5, b + 1.2, 8))
    return np.asarray(transform.transform(np.column_stack((x.ravel(), y.ravel()))))


def pin(ax: Axes, place: Place, *, radius: float = PIN, fill: str = "white") -> Array:
    """A pin that bodies turn on; return pixels it covers."""
    return _ring(ax, place, radius, fill, BLACK, _LAYER + 1)


def clearance(ax: Axes, place: Place) -> Array:
    """The second circle around a pin with clearance; return pixels it covers."""
    return _ring(ax, place, CLEARANCE_RING, "white", CLEARANCE, _LAYER)


def _ring(ax: Axes, place: Place, radius: float, fill: str, edge: str, layer: float) -> Array:
    ax.add_patch(
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
    return _around(ax, place, np.linspace(0, 2 * np.pi, 13)[:-1], radius)


def _around(ax: Axes, place: Place, angles: Array, radius: float) -> Array:
    circle = np.column_stack((np.cos(angles), np.sin(angles)))
    return pixels(ax, place) + radius * per_point(ax) * circle


def rotation_arrow(ax: Axes, place: Place, tip: Place, sense: float, colour: str) -> Array:
    """An arc arrow about a pin, across the bar from there to `tip`; return pixels it covers."""
    bar = np.subtract(*pixels(ax, (tip, place))) / per_point(ax)
    angle = float(np.arctan2(bar[1], bar[0]))
    radius = float(np.clip(0.55 * np.hypot(*bar), *ARROW_RADII))
    half = 0.5 * ARROW_SPAN * float(np.sign(sense))
    angles = np.linspace(angle - half, angle + half, 25)
    arc = radius * np.column_stack((np.cos(angles), np.sin(angles)))
    _arrow(ax, Path(arc), place, 0.0, colour)
    return np.vstack([_around(ax, place, angles, radius + beside) for beside in (-2, 0, 2)])


def _arrow(ax: Axes, path: Path, place: Place, angle: float, colour: str) -> None:
    ax.add_patch(
        FancyArrowPatch(
            path=path,
            arrowstyle="-|>",
            mutation_scale=9,
            linewidth=1.2,
            color=colour,
            transform=anchored(ax, place, angle),
            zorder=_LAYER + 2,
        )
    )
