"""Pictures of the plane: axes of equal scale in metres or a part of them, and pixel places."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.style import (
    BOTTOM,
    LEFT,
    RIGHT,
    TOP,
    WIDTH,
    Scale,
    scale_for,
    set_heading,
    set_title,
)

Array = NDArray[np.float64]
Positions = Mapping[str, tuple[float, float]]

MARGIN = 0.4  # inches around everything, for labels
LOWEST, HIGHEST = 2.0, 5.2  # inches
ROOM = (72.0 * (WIDTH - LEFT - RIGHT - 2 * MARGIN), 72.0 * (HIGHEST - 2 * MARGIN))
"""Points that a picture has within its margins."""
_ARROWS = "→↗↑↖←↙↓↘"


@dataclass(frozen=True)
class Box:
    """The part of the plane that a picture shows, in metres."""

    low: Array  # its corners, shape (2,)
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

    @classmethod
    def joined(cls, boxes: Sequence[Box]) -> Box:
        """Around some boxes."""
        return cls(np.min([b.low for b in boxes], axis=0), np.max([b.high for b in boxes], axis=0))

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
    figure.subplots_adjust(LEFT / WIDTH, BOTTOM / total, 1 - RIGHT / WIDTH, 1 - TOP / total)
    return figure, figure.add_subplot()


def small_pictures(
    count: int, columns: int, shape: float, heading: str, lines: int = 1, note: str = ""
) -> tuple[Figure, list[Axes]]:
    """A figure of small pictures of the plane, side by side, without numbers at their axes.

    `shape`: height over width, as far as pages have room. `lines`: of the titles.
    """
    rows, width = -(-count // columns), WIDTH / columns - 0.1
    height = min(width * float(np.clip(shape, 0.6, 1.5)), 4.5)
    head, foot = 0.11 + 0.13 * lines, 0.28 if note else 0.06
    total = rows * (height + head) + 0.24 + foot
    figure = Figure(figsize=(WIDTH, total))
    figure.subplots_adjust(
        0.05 / WIDTH, foot / total, 1 - 0.05 / WIDTH, 1 - (0.24 + head) / total,
        0.1 / width, head / height,
    )  # fmt: skip
    axes = [*figure.subplots(rows, columns, squeeze=False).flat]
    for ax in axes[count:]:
        ax.remove()
    set_heading(figure, heading)
    if note:
        figure.text(0.05 / WIDTH, 0.09 / total, note)
    return figure, axes[:count]


BELOW = 0.3  # inches from axes to what is written under their numbers


def legend_below(ax: Axes, handles: Sequence[Artist]) -> None:
    """A legend in one line under axes; the label of the axis goes to the right."""
    place = (0.0, -BELOW / (ax.bbox.height / ax.figure.dpi))
    ax.legend(
        handles=handles, loc="upper left", ncols=len(handles), bbox_to_anchor=place,
        borderaxespad=0.0, borderpad=0.0, handlelength=1.2, handletextpad=0.5, columnspacing=1.2,
    )  # fmt: skip
    ax.set_xlabel(ax.get_xlabel(), loc="right")


def blank(ax: Axes) -> None:
    """Leave out numbers, labels and the grid of axes."""
    ax.set(xticks=[], yticks=[], xlabel="", ylabel="")
    ax.grid(visible=False)


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
    arrow = gravity_arrow(mechanism)
    set_title(ax, mechanism.name, f"gravity {arrow}" * bool(arrow))
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
