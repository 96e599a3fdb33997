"""The page of a figure over time: a panel for each group of lines, and one for a few swings."""

from __future__ import annotations

from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from linkages.plots.style import BOTTOM, LEFT, RIGHT, TOP, WIDTH

HEIGHT, LOW = 2.7, 1.9
"""Inches: of a panel that stands alone, and of one of several."""

ROW, HEAD = 0.155, 0.04
"""Inches: a row of a legend, and what it keeps from the panel."""

ZOOM, GAP, SCALE = 0.29, 0.36, 0.5
"""Part of the width that a few swings get; inches between, and for the numbers at the right."""


class Group(NamedTuple):
    """Lines that share a panel: numbers of them, and whether they are denser than the paper."""

    lines: tuple[int, ...]
    dense: bool


class Panel(NamedTuple):
    """Axes of a group, and those of a few of its swings if it is dense."""

    whole: Axes
    swings: Axes | None


def rows_of_legend(entries: int, columns: int) -> float:
    """Inches that a legend above a panel takes beyond a title."""
    return HEAD + -(-entries // columns) * ROW if entries > 1 else 0.0


def page(groups: list[Group], columns: int) -> list[Panel]:
    """A new figure with a panel for each group, one below the other.

    Parameters
    ----------
    groups
        At least one.
    columns
        Of legends.
    """
    height = HEIGHT if len(groups) == 1 else LOW
    tops = [TOP + rows_of_legend(len(group.lines), columns) for group in groups]
    total = sum(tops) + len(groups) * (height + BOTTOM)
    figure = Figure(figsize=(WIDTH, total))
    panels, above = [], 0.0
    for group, top in zip(groups, tops, strict=True):
        bottom = (total - above - top - height) / total
        above += top + height + BOTTOM

        def axes(left: float, right: float, bottom: float = bottom) -> Axes:
            box = (left / WIDTH, bottom, (right - left) / WIDTH, height / total)
            return figure.add_axes(box)

        if not group.dense:
            panels.append(Panel(axes(LEFT, WIDTH - RIGHT), None))
            continue
        split = WIDTH - SCALE - ZOOM * (WIDTH - LEFT - SCALE)
        panels.append(Panel(axes(LEFT, split - GAP / 2), axes(split + GAP / 2, WIDTH - SCALE)))
    return panels
