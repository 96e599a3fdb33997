"""Assembly branches side by side: small drawings of the same mechanism."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.mechanism.annotations import Labels
from linkages.plots.mechanism.drawing import reach, under, words_of
from linkages.plots.mechanism.inked_shapes import LIGHT, Inked, points_per_unit
from linkages.plots.mechanism.plane_view import Box, Positions
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.shapes import Pair
from linkages.plots.style import DRIVEN, GREY, WIDTH, fitted, nice_below, scale_for, styled

MOST = 48
"""How many drawings one figure holds."""

EDGE, HEAD, FOOT = 0.1, 0.24, 0.28  # inches around a drawing, above it, and below all of them
NAMED = 4
"""Columns in which there is room for names."""

COLUMNS = ((3, 3), (4, 2), (9, 3), (24, 4), (MOST, 6))
"""Up to how many drawings there are how many beside each other."""

LINE = 0.13
"""Inches of a further line of a title."""

LETTERS, PER_INCH = 10, 15.0
"""Of a title: fewest in a line, and how many are sure to have room."""

LABELLED = 13.0
"""Points around symbols: room for names."""

BAR = 10.0
"""Points below them: room for the scale."""

ALIKE = 1.05
"""Extents of drawings that are no farther apart than this have one scale."""

LOWEST, HIGHEST = 0.6, 1.5  # height of a drawing over its width


@dataclass(frozen=True)
class Mode:
    """What is drawn of an assembly mode."""

    number: int  # from 1
    positions: Positions  # joint → (x, y) in metres
    text: str = ""  # what tells it from others, such as the side of every block
    selected: bool = False  # whether the definition selects it


def shown_modes(modes: Sequence[Mode]) -> list[Mode]:
    """The first `MOST`; the selected one takes the place of the last if it is not among them."""
    shown = list(modes[:MOST])
    missing = [mode for mode in modes[MOST:] if mode.selected]
    return [*shown[: MOST - len(missing)], *missing]


@styled
def figure(mechanism: Mechanism, modes: Sequence[Mode]) -> Figure:
    """Drawings that fill their panels, the selected one in a coloured frame.

    Each has a scale, where it is not the same for all.
    """
    shown = shown_modes(modes)
    poses = [Pose(mechanism, mode.positions) for mode in shown]
    columns = next(most for upto, most in COLUMNS if len(shown) <= upto)
    columns = min(len(shown), columns)
    rows = math.ceil(len(shown) / columns)
    width = WIDTH / columns - EDGE
    widest, highest = np.max([reach(pose, _room(width, width, columns)).size for pose in poses], 0)
    shape = float(np.clip(highest / max(widest, 1e-9), LOWEST, HIGHEST))
    height = min(shape * width, 4.5)
    boxes = [reach(pose, _room(width, height, columns)) for pose in poses]
    extents = [box.bare.extent if box.bare else box.extent for box in boxes]
    scaled = max(extents) > ALIKE * min(extents)
    titles = [_title(mode, width) for mode in shown]
    head = HEAD + LINE * max(title.count("\n") for title in titles)
    total = rows * (height + head) + FOOT + HEAD
    result = Figure(figsize=(WIDTH, total))
    for index, mode in enumerate(shown):
        row, column = divmod(index, columns)
        left = column * (width + EDGE) + 0.5 * EDGE
        bottom = total - HEAD - (row + 1) * (height + head)
        ax = result.add_axes((left / WIDTH, bottom / total, width / WIDTH, height / total))
        draw(ax, mechanism, mode, boxes[index], columns, scaled=scaled)
    heading = f"{mechanism.name}: assembly modes"
    result.text(0.5 * EDGE / WIDTH, 1 - 0.17 / total, fitted(heading, WIDTH), weight="bold")
    note = "framed: the mode that the definition selects" if any(m.selected for m in shown) else ""
    if len(shown) < len(modes):
        note = "; ".join(part for part in (note, f"{len(shown)} of {len(modes)} modes") if part)
    result.text(0.5 * EDGE / WIDTH, 0.09 / total, note, fontsize=8, color=DRIVEN)
    return result


def draw(
    ax: Axes, mechanism: Mechanism, mode: Mode, box: Box, columns: int = 1, *, scaled: bool = False
) -> Axes:
    """Draw one mode in a box, with names of joints; without and smaller in many columns.

    Where it is `scaled`, a bar says how long something is.
    """
    inches = np.array([ax.bbox.width, ax.bbox.height]) / ax.figure.dpi
    room = _room(float(inches[0]), float(inches[1]), columns)
    point = float(np.max(box.size / room))
    half = 0.5 * point * 72.0 * inches / _size(columns)
    middle = 0.5 * (box.low + box.high) - (0.0, 0.5 * point * BAR)
    ax.set_xlim(middle[0] - half[0], middle[0] + half[0])
    ax.set_ylim(middle[1] - half[1], middle[1] + half[1])
    ax.set_aspect("equal")
    ax.grid(visible=False)
    ax.set(xticks=[], yticks=[])
    pose = Pose(mechanism, mode.positions)
    size = _size(columns)
    drawn = Inked(ax, under(pose, points_per_unit(ax) / size), pose, size=size)
    labels = Labels(ax)
    if scaled:
        _scale_bar(ax, labels)
    if columns <= NAMED:
        drawn.avoided(labels)
        for word in words_of(pose):
            if word.strong:
                labels.beside_point(word.text, pose.positions[word.name], 3.0, fontsize=6.5)
    colour = DRIVEN if mode.selected else "black"
    ax.set_title(_title(mode, float(inches[0])), fontsize=8, color=colour, pad=3)
    for spine in ax.spines.values():
        spine.set(
            edgecolor=DRIVEN if mode.selected else GREY, linewidth=1.8 if mode.selected else 0.6
        )
    return ax


def _size(columns: int) -> float:
    """Of symbols, over that of other pictures."""
    return 0.85 if columns <= 3 else 0.6


def _room(width: float, height: float, columns: int) -> Pair:
    """What a panel has for a drawing, in the points of its symbols."""
    points = 72.0 * np.array([width, height]) / _size(columns)
    margins = 2.0 * LABELLED + np.array([0.0, BAR])
    across, up = np.maximum(points - margins, 0.5 * points).tolist()
    return across, up


def _title(mode: Mode, width: float) -> str:
    """Number and text in as many lines as a panel so wide in inches needs, all of them whole."""
    letters = max(LETTERS, int(width * PER_INCH))
    whole = mode.text.replace(" ", "\u00a0").replace(",\u00a0", ", ")  # lines end at commas
    indent = " " * len(f"{mode.number}  ")
    return textwrap.fill(f"{mode.number}  {whole}".rstrip(), letters, subsequent_indent=indent)


def _scale_bar(ax: Axes, labels: Labels) -> None:
    """A length of the plane in the lower left corner, which labels keep clear of."""
    low, high = ax.get_xlim()
    length = nice_below(0.22 * (high - low))
    left, bottom = low + 0.04 * (high - low), ax.get_ylim()[0] + 0.05 * float(np.ptp(ax.get_ylim()))
    ax.plot([left, left + length], [bottom, bottom], color=LIGHT["ink"], linewidth=1.0)
    text = scale_for(length, "m").text(length)
    ax.annotate(text, (left, bottom), (0, 2), textcoords="offset points", fontsize=6.5)
    point = 1.0 / points_per_unit(ax)
    for above in (0.0, 4.0, 8.0):
        places = [(left, bottom + above * point), (left + length, bottom + above * point)]
        labels.avoid_line(places)
