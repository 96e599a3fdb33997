"""Pictures of the plane: axes of equal scale in metres or a part of them, and pixel places."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.style import BOTTOM, LEFT, RIGHT, TOP, WIDTH, Scale, fitted, scale_for

Array = NDArray[np.float64]
Positions = Mapping[str, tuple[float, float]]

MARGIN = 0.4  # inches around everything, for labels
LOWEST, HIGHEST = 2.0, 4.8  # inches
ROOM = (72.0 * (WIDTH - LEFT - RIGHT - 2 * MARGIN), 72.0 * (HIGHEST - 2 * MARGIN))
"""Points that a picture has within its margins."""
_ARROWS = "→↗↑↖←↙↓↘"


@dataclass(frozen=True)
class Box:
    """The part of the plane that a picture shows, in metres.

    `low`, `high`: its corners, shape (2,).
    """

    low: Array
    high: Array
    bare: Box | None = None  # the same without symbols, which choose no unit; itself if not given

    @classmethod
    def around(cls, points: ArrayLike) -> Box:
        """The smallest box around points of shape (n, 2); those not finite are left out."""
        array = np.asarray(points, dtype=float).reshape(-1, 2)
        array = array[np.isfinite(array).all(axis=1)]
        if not len(array):
            array = np.zeros((1, 2))
        return cls(array.min(axis=0), array.max(axis=0))

    @property
    def size(self) -> Array:
        """Width and height; never zero both."""
        size = self.high - self.low
        return size if size.any() else np.ones(2)

    @property
    def extent(self) -> float:
        """The larger of width and height."""
        return float(np.max(self.high - self.low))

    @property
    def scale(self) -> Scale:
        """Metres, or millimetres for a mechanism of less than a metre."""
        if self.bare is not None:
            return self.bare.scale
        return scale_for(0.1 * float(np.max(np.abs((self.low, self.high, self.size)))), "m")


def picture(box: Box, margin: float = MARGIN) -> tuple[Figure, Axes]:
    """A figure whose axes have the shape of a box, with a margin in inches."""
    width = WIDTH - LEFT - RIGHT
    inches = (width - 2 * margin) / max(box.size[0], 1e-3 * box.size[1])  # per metre
    height = float(np.clip(inches * box.size[1] + 2 * margin, LOWEST, HIGHEST))
    total = height + TOP + BOTTOM
    figure = Figure(figsize=(WIDTH, total))
    ax = figure.add_axes((LEFT / WIDTH, BOTTOM / total, width / WIDTH, height / total))
    return figure, ax


def frame(ax: Axes, box: Box, mechanism: Mechanism, margin: float = MARGIN) -> Scale:
    """Set limits that show a box at equal scale, labels, and a title; return the scale."""
    inches = _inches(ax)
    half = 0.5 * inches * np.max(72.0 * box.size / room_in(ax, margin))
    centre = 0.5 * (box.low + box.high)
    factor = box.scale.factor
    (left, right), (bottom, top) = np.column_stack((centre - half, centre + half)) * factor
    ax.set_xlim(left, right)
    ax.set_ylim(bottom, top)
    ax.set_aspect("equal")
    ax.apply_aspect()
    ax.set_xlabel(box.scale.label("x"))
    ax.set_ylabel(box.scale.label("y"))
    ax.set_title(fitted(mechanism.name, inches[0] - 1.0))
    arrow = gravity_arrow(mechanism)
    if arrow:
        ax.set_title(f"gravity {arrow}", loc="right")
    return box.scale


def room_in(ax: Axes, margin: float = MARGIN) -> tuple[float, float]:
    """Points that axes have within their margins, for their width and height."""
    inches = _inches(ax)
    width, height = (72.0 * np.maximum(inches - 2 * margin, 0.4 * inches)).tolist()
    return width, height


def _inches(ax: Axes) -> Array:
    """Width and height of axes before their aspect is equal, shape (2,)."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    place = ax.get_position(original=True)
    return np.array(figure.get_size_inches()) * (place.width, place.height)


def gravity_arrow(mechanism: Mechanism) -> str:
    """Which way gravity pulls, as one of eight arrows; empty without gravity."""
    x, y = mechanism.gravity.x.value, mechanism.gravity.y.value
    if x == y == 0.0:
        return ""
    return _ARROWS[round(np.arctan2(y, x) / (np.pi / 4)) % 8]


def pixels(ax: Axes, points: ArrayLike) -> Array:
    """Pixel places of points of shape (n, 2) in the units of the axes."""
    return np.asarray(ax.transData.transform(np.asarray(points, dtype=float).reshape(-1, 2)))


def per_point(ax: Axes) -> float:
    """Pixels per typographic point."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    return float(figure.dpi) / 72.0
