"""How charts are declared: their axes, pages of panels, legends, and their names for users."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, ParamSpec, TypeVar

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from linkages.plots.style import (
    BOTTOM,
    SINGLE,
    TEXT,
    TOP,
    Page,
    Scale,
    filled,
    letters,
    make_room,
    scale_of,
    set_heading,
    set_title,
    styled,
    width_of,
)

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
    return scale


def labelled(artists: Iterable[Any]) -> dict[str, Artist]:
    """Label → artist, the first one with each label."""
    result: dict[str, Artist] = {}
    for artist in artists:
        if (label := str(artist.get_label())) and not label.startswith("_"):
            result.setdefault(label, artist)
    return result


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
