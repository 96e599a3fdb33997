"""Parts of a plane that are drawn once more, larger."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from linkages.plots.style import BLACK, BOTTOM, LEFT, RIGHT, TOP, WIDTH
from linkages.reading.wording import listed

Array = NDArray[np.float64]

WHOLE, PART = 3.2, 2.5
"""Heights of the panel with all points and of those below it, in inches."""


class Zoom(NamedTuple):
    """A rectangle in units of the axes, of the free coordinate named, or of the only one."""

    left: float
    right: float
    bottom: float
    top: float
    name: str = ""

    def inside(self, x: Array, y: Array) -> tuple[Array, Array]:
        """The points in it."""
        there = (x >= self.left) & (x <= self.right) & (y >= self.bottom) & (y <= self.top)
        return x[there], y[there]

    def limit(self, ax: Axes) -> None:
        """Make it the limits of axes, with few ticks: their numbers are long."""
        ax.set_xlim(self.left, self.right)
        ax.set_ylim(self.bottom, self.top)
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_locator(MaxNLocator(4, steps=(1, 2, 2.5, 5, 10)))

    def frame(self, ax: Axes, letter: str) -> None:
        """Draw its outline with a letter."""
        width, height = self.right - self.left, self.top - self.bottom
        corner = self.left, self.bottom
        ax.add_patch(
            Rectangle(corner, width, height, fill=False, edgecolor=BLACK, linewidth=0.8, zorder=4)
        )
        ax.annotate(
            letter, (self.right, self.top), xytext=(2, 1), textcoords="offset points",
            fontsize=8, fontweight="bold", color=BLACK, zorder=5,
        )  # fmt: skip

    def __str__(self) -> str:
        """As it is written on the command line."""
        numbers = ",".join(f"{side:g}" for side in self[:4])
        return f"{self.name}:{numbers}" if self.name else numbers


def read_zoom(text: str) -> Zoom:
    """A rectangle as it is written on the command line.

    Raises
    ------
    ValueError
        For anything else.
    """
    name, _, sides = text.rpartition(":")
    try:
        left, right, bottom, top = map(float, sides.split(","))
    except ValueError:
        left = right = bottom = top = np.nan
    if not (left < right and bottom < top and np.isfinite([left, right, bottom, top]).all()):
        raise ValueError(f"expected LEFT,RIGHT,BOTTOM,TOP in units of the axes, found {text!r}")
    return Zoom(left, right, bottom, top, name)


def coordinate_of(zooms: Sequence[Zoom], names: Sequence[str]) -> str:
    """The free coordinate, of those named, that rectangles belong to.

    Raises
    ------
    ValueError
        If it is not free, or if they do not agree on one.
    """
    only = names[0] if len(names) == 1 else ""
    asked = {zoom.name or only for zoom in zooms}
    if len(asked) == 1 and asked <= set(names):
        return asked.pop()
    wanted, written = listed(list(names), "or"), listed([str(zoom) for zoom in zooms], "and")
    raise ValueError(f"expected rectangles of one free coordinate, {wanted}; found {written}")


def zoom_panels(count: int) -> tuple[Figure, Axes, list[Axes]]:
    """A figure with a wide panel, and so many below it, two in a row."""
    rows = -(-count // 2)
    total = WHOLE + rows * PART + (1 + rows) * (TOP + BOTTOM)
    result = Figure(figsize=(WIDTH, total))
    half = WIDTH / 2

    def panel(left: float, top: float, width: float, height: float) -> Axes:
        inner = width - LEFT - RIGHT
        bottom = total - top - TOP - height
        return result.add_axes(
            ((left + LEFT) / WIDTH, bottom / total, inner / WIDTH, height / total)
        )

    main, below = panel(0.0, 0.0, WIDTH, WHOLE), WHOLE + TOP + BOTTOM
    others = [
        panel(half * (place % 2), below + place // 2 * (PART + TOP + BOTTOM), half, PART)
        for place in range(count)
    ]
    return result, main, others
