"""How charts are declared: pages of panels, axes, cells of planes, legends, names for users."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from math import ceil, floor
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import XAxis, YAxis
from matplotlib.collections import QuadMesh
from matplotlib.colors import Colormap, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import Locator
from numpy.typing import ArrayLike, NDArray

from linkages.plots.style import (
    BOTTOM,
    GREY,
    PALE,
    SINGLE,
    TEXT,
    TOP,
    Page,
    Scale,
    axis_scale,
    figure_of,
    filled,
    letters,
    make_room,
    path_words,
    scale_of,
    set_heading,
    set_title,
    styled,
    width_of,
)

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]
P = ParamSpec("P")
T = TypeVar("T")

PAIRED = 2.5  # inches: height of one of several diagrams

CHARTS: dict[str, Callable[..., Axes]] = {}
"""Every chart by its name in `linkages.charts`."""

USUAL = {
    "ax": "Where to draw; axes of a new figure if not given.",
    "data": "As the function named above returns it.",
    "solution": "Whose motion it is.",
    "source": "A solution, or its data.",
    "sources": (
        "Solutions or their data, several of them by what tells them apart. Those of a list are "
        "called by what their definitions differ in."
    ),
}
"""What parameters of charts are that say nothing else of themselves."""


def chart(function: Callable[P, Axes]) -> Callable[P, Axes]:
    """Declare a chart: a function of `linkages.charts` that draws in the style of the project.

    It draws into its argument `ax`, or into axes of its own.
    """
    CHARTS[function.__name__] = drawn = styled(described(function))
    return drawn


def described(function: Callable[P, Axes]) -> Callable[P, Axes]:
    """Add a section on parameters to a docstring, in which ```name`: its meaning`` are lines."""
    text, *own = re.split(r"\n(?=`\w+`: )", inspect.cleandoc(function.__doc__ or ""))
    known = USUAL | dict(entry[1:].split("`: ", 1) for entry in own)
    entries = [
        f"{name}\n    {' '.join(known[name].split())}"
        for name in inspect.signature(function).parameters
    ]
    function.__doc__ = "\n".join([text.rstrip(), "", "Parameters", "----------", *entries])
    return function


def named(
    name: str | None, found: Mapping[str, object] | Sequence[str], what: str = "free coordinate"
) -> str:
    """The one that is named, or the first; ValueError if there is none."""
    if not found:
        raise ValueError(f"the data have no {what}")
    if name is not None and name not in found:
        raise ValueError(f"unknown {what} {name!r}; expected one of: {', '.join(found)}")
    return next(iter(found)) if name is None else name


def mosaic(
    places: Sequence[Sequence[int]], heights: Sequence[float], *, joined: bool = False,
    widths: Sequence[float] | None = None,
) -> tuple[Figure, list[Axes]]:  # fmt: skip
    """A page of panels: the number of a panel at each of its places, −1 where there is none.

    `heights`: inches of rows; those that are `joined` share the axis to the right.
    `widths`: of columns, over each other.
    """
    rows = len(heights)
    between = 0.12 * (rows - 1) + TOP + BOTTOM if joined else rows * (TOP + BOTTOM)
    figure = Page(sum(heights) + between)
    how: dict[str, Any] = {"height_ratios": heights, "width_ratios": widths, "sharex": joined}
    axes = figure.subplot_mosaic([list(row) for row in places], empty_sentinel=-1, **how)
    return figure, [axes[k] for k in sorted(axes)]


def panels(
    rows: int, columns: int, height: float | Sequence[float], *, joined: bool = False,
    widths: Sequence[float] | None = None,
) -> tuple[Figure, list[Axes]]:  # fmt: skip
    """A page of panels in rows and columns; `height`: inches of all rows, or of each."""
    heights = [height] * rows if isinstance(height, int | float) else height
    places = np.arange(rows * columns).reshape(rows, columns).tolist()
    return mosaic(places, heights, joined=joined, widths=widths)


def diagrams(count: int) -> tuple[Figure, list[Axes]]:
    """A page of so many diagrams of one quantity against another: a large one, or two a row."""
    if count == 1:
        return panels(1, 1, SINGLE)
    places = [[k, k + 1 if k + 1 < count else -1] for k in range(0, count, 2)]
    return mosaic(places, [PAIRED] * len(places))


def diagram_each(
    items: Sequence[T], draw: Callable[[Axes, T, str], object], heading: str
) -> Figure | None:
    """A page with a diagram of each of some things; None without any.

    A single one is drawn with the heading, of several this stands above all.
    """
    if not items:
        return None
    figure, axes = diagrams(len(items))
    for ax, item in zip(axes, items, strict=True):
        draw(ax, item, heading if len(items) == 1 else "")
    if heading and len(items) > 1:
        set_heading(figure, heading)
    return figure


def axes_for(ax: Axes | None, height: float = SINGLE) -> Axes:
    """The axes to draw into: those that are given, else the panel of a new page."""
    return panels(1, 1, height)[1][0] if ax is None else ax


def time_axis(ax: Axes, time: ArrayLike) -> Scale:
    """Label and limits of an axis to the right over times in seconds; how these are shown."""
    array = np.asarray(time, dtype=float)
    scale = scale_of(array, "s")
    ax.set_xlabel(scale.label("time"))
    if array.size and np.ptp(array) > 0:
        ax.set_xlim(array.min() * scale.factor, array.max() * scale.factor)
    joined(ax)
    return scale


def show_axis(ax: Axes, along: str, values: ArrayLike, units: str, words: str) -> Scale:
    """Label of an axis along which values in SI are drawn, and ticks of angles; their scale."""
    scale = axis_scale(values, units)
    if scale.units == "°":
        show_degrees(ax, scale.factor * np.asarray(values, dtype=float), along)
    ax.set(**{f"{along}label": scale.label(words)})
    return scale


NEARLY_ALL = 240.0  # degrees; angles within a turn that fill more of it get the whole turn
SMALL = 2.0  # degrees; a smaller range has ticks like any other number
ROOM = {"x": 0.55, "y": 0.3}  # inches that a label needs along an axis
_STEPS = (1, 2, 5, 10, 15, 30, 45, 90, 180)


def show_degrees(ax: Axes, degrees: ArrayLike, along: str = "x") -> None:
    """Limits and ticks of an axis of angles."""
    axis: XAxis | YAxis = ax.xaxis if along == "x" else ax.yaxis
    array = np.asarray(degrees, dtype=float)
    finite = array[np.isfinite(array)]
    span = float(np.ptp(finite)) if finite.size else 0.0
    if span > NEARLY_ALL and np.abs(finite).max() <= 180.0 + 1e-9:
        ax.set(**{f"{along}lim": (-180.0, 180.0)})
    if span > SMALL:
        axis.set_major_locator(Degrees(ax, along))


class Degrees(Locator):
    """Ticks that divide turns as people do, as many as have room for their labels."""

    def __init__(self, ax: Axes, along: str) -> None:
        self._ax, self._along = ax, along

    def __call__(self) -> list[float]:
        """Places of the ticks."""
        return self.tick_values(*getattr(self._ax, f"get_{self._along}lim")())

    def tick_values(self, vmin: float, vmax: float) -> list[float]:
        """Places of the ticks between two angles in degrees."""
        ax, (low, high) = self._ax, sorted((vmin, vmax))
        inches = width_of(ax) if self._along == "x" else ax.bbox.height / figure_of(ax).dpi
        most, span = inches / ROOM[self._along] + 1e-9, high - low
        step = next((s for s in _STEPS if span <= most * s), 360 * ceil(span / most / 360))
        return [k * step for k in range(ceil(low / step - 1e-9), floor(high / step + 1e-9) + 1)]


def joined(ax: Axes) -> None:
    """Leave labels of axes that share one to the right to those at the bottom."""
    if len(ax.get_shared_x_axes().get_siblings(ax)) > 1:
        ax.label_outer()


def labelled(artists: Iterable[Any]) -> dict[str, Artist]:
    """Label → artist, the first one with each label."""
    result: dict[str, Artist] = {}
    for artist in artists:
        if (label := str(artist.get_label())) and not label.startswith("_"):
            result.setdefault(label, artist)
    return result


def shown_values(data: xr.Dataset, path: str) -> tuple[Array, str]:
    """Values of a varied path as they are drawn, angles in degrees, and the label of its axis."""
    scale = path_scale(data, path)
    return scale.factor * np.asarray(data[path], dtype=float), scale.label(path_words(path))


def path_scale(data: xr.Dataset, path: str) -> Scale:
    """How values of a varied path, which have units of their own, are shown."""
    return axis_scale(1.0, str(data[path].attrs.get("units", "")))


def show_path(ax: Axes, along: str, data: xr.Dataset, path: str) -> Array:
    """Limits, ticks and label of an axis along which a path is varied; returns borders of cells."""
    values, label = shown_values(data, path)
    if label.endswith("[°]"):
        show_degrees(ax, values, along)
    borders = cell_borders(values)
    ax.set(**{f"{along}lim": sorted(borders[[0, -1]]), f"{along}label": label})
    joined(ax)
    return borders


def cell_borders(places: Array) -> Array:
    """Borders half-way between neighbouring places, shape (n + 1,)."""
    middle = 0.5 * (places[1:] + places[:-1])
    first, last = places[0] - (middle[0] - places[0]), places[-1] + (places[-1] - middle[-1])
    return np.concatenate([[first], middle, [last]])


def runs(chosen: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Beginnings and ends of what is chosen next to each other."""
    edges = np.flatnonzero(np.diff(chosen.astype(np.int8), prepend=0, append=0)).tolist()
    return list(zip(edges[::2], edges[1::2], strict=True))


def shade(ax: Axes, borders: Array, chosen: NDArray[np.bool_], **look: Any) -> None:
    """Shade what is chosen among cells along the axis to the right."""
    for first, last in runs(chosen):
        ax.axvspan(borders[first], borders[last], **look)


def draw_cells(
    ax: Axes, data: xr.Dataset, values: Array, colours: Colormap, limits: Normalize,
    paths: Sequence[str] = (),
) -> tuple[Array, Array]:  # fmt: skip
    """Draw values over the plane of two paths; what is not finite is grey. Returns borders."""
    paths = paths or [str(data.attrs[along]) for along in "xy"]
    x, y = (show_path(ax, along, data, path) for along, path in zip("xy", paths, strict=True))
    ax.grid(False)
    colours = colours.with_extremes(bad=PALE)
    ax.pcolormesh(x, y, values, cmap=colours, norm=limits, rasterized=True)
    return x, y


def draw_classes(
    ax: Axes, data: xr.Dataset, classes: NDArray[Any], looks: Mapping[Any, tuple[str, str]]
) -> dict[str, Artist]:
    """Draw which class each point has in its colour; words and patches of those that are there.

    `looks`: class → colour and words.
    """
    cells, colours = np.full(classes.shape, np.nan), [colour for colour, _ in looks.values()]
    for number, each in enumerate(looks):
        cells[classes == each] = number
    draw_cells(ax, data, cells, ListedColormap(colours), Normalize(-0.5, len(looks) - 0.5))
    present = [look for number, look in enumerate(looks.values()) if (cells == number).any()]
    present += [(PALE, "not computed")] if np.isnan(cells).any() else []
    return {words: Patch(facecolor=colour, **OUTLINE) for colour, words in present}


def with_bar(ax: Axes, label: str, **look: Any) -> None:
    """Add the colour bar of what `draw_cells` drew last."""
    image = [each for each in ax.collections if isinstance(each, QuadMesh)][-1]
    figure_of(ax).colorbar(image, ax=ax, label=label, **look).minorticks_off()


OUTLINE: dict[str, Any] = {"edgecolor": GREY, "linewidth": 0.6}
"""Of patches of legends: white is one of the colours."""


def not_computed(count: int) -> dict[str, Artist]:
    """The entry of a legend for so many values."""
    return {f"not computed ({count})": Patch(color=PALE)} if count else {}


def dot(colour: str, **look: Any) -> Line2D:
    """Of a legend."""
    return Line2D([], [], linestyle="", marker="o", color=colour, **look)


def legend_above(ax: Axes, entries: Mapping[str, Artist], heading: str = "", **look: Any) -> None:
    """A legend above axes, under a heading: it hides nothing. Without entries it is a title."""
    if not entries:
        set_title(ax, heading)
        return
    room, lengths = width_of(ax), np.array([len(text) for text in entries])
    for columns in range(min(4, len(lengths)), 0, -1):
        parts = np.array_split(lengths, columns)
        if sum(part.max() for part in parts) + 8 * columns <= letters(room):
            break
    each = room if columns > 1 else room - 6 * TEXT * 0.56 / 72.0
    texts, above = [filled(text, each) for text in entries], filled(heading, room)
    ax.legend(
        [*entries.values()], texts, ncols=columns, title=above or None, title_fontsize=TEXT,
        alignment="left", loc="lower left", bbox_to_anchor=(0.0, 1.015), borderpad=0.0,
        borderaxespad=0.0, labelspacing=0.35, **look,
    )  # fmt: skip
    make_room(ax, "\n".join([above] * bool(above) + texts[: len(parts[0])]))
