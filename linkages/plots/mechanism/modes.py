"""Assembly modes side by side: small drawings of the same mechanism, numbered."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.mechanism.drawing import reach, under
from linkages.plots.mechanism.inked import Inked, points_per_unit
from linkages.plots.mechanism.labels import Labels
from linkages.plots.mechanism.names import words_of
from linkages.plots.mechanism.palette import LIGHT
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.view import Box, Positions
from linkages.plots.prefixes import nice_below, scale_for
from linkages.plots.style import DRIVEN, GREY, WIDTH, fitted, styled

MOST = 48
"""How many drawings one figure holds."""

EDGE, HEAD, FOOT = 0.1, 0.24, 0.28  # inches around a drawing, above it, and below all of them
NAMED = 4
"""Columns in which there is room for names."""

ALIKE = 1.05
"""Extents of drawings that are no farther apart than this have one scale."""

LOWEST, HIGHEST = 0.6, 1.5  # height of a drawing over its width


@dataclass(frozen=True)
class Mode:
    """What is drawn of an assembly mode.

    Parameters
    ----------
    number
        From 1.
    positions
        Joint → (x, y) in metres.
    text
        What tells it from others, such as the side of every block.
    selected
        Whether the definition selects it.
    """

    number: int
    positions: Positions
    text: str = ""
    selected: bool = False


def shown_modes(modes: Sequence[Mode]) -> list[Mode]:
    """The first `MOST`; the selected one takes the place of the last if it is not among them."""
    shown = list(modes[:MOST])
    missing = [mode for mode in modes[MOST:] if mode.selected]
    return [*shown[: MOST - len(missing)], *missing]


@styled
def figure(mechanism: Mechanism, modes: Sequence[Mode]) -> Figure:
    """Drawings that fill their panels, the selected one in a coloured frame.

    Each has a scale, where it is not the same for all.

    Parameters
    ----------
    mechanism
        Whose modes they are.
    modes
        At least one; a note says so if there are more than `MOST`.
    """
    shown = shown_modes(modes)
    boxes = [reach(Pose(mechanism, mode.positions)) for mode in shown]
    extents = [box.extent for box in boxes]
    scaled = max(extents) > ALIKE * min(extents)
    columns = min(len(shown), 3 if 4 < len(shown) <= 9 else 4 if len(shown) <= 24 else 6)
    rows = math.ceil(len(shown) / columns)
    width = WIDTH / columns - EDGE
    widest, highest = np.max([box.size for box in boxes], axis=0)
    shape = float(np.clip(highest / max(widest, 1e-9), LOWEST, HIGHEST))
    height = min(shape * width, 4.5)
    total = rows * (height + HEAD) + FOOT + HEAD
    result = Figure(figsize=(WIDTH, total))
    for index, mode in enumerate(shown):
        row, column = divmod(index, columns)
        left = column * (width + EDGE) + 0.5 * EDGE
        bottom = total - HEAD - (row + 1) * (height + HEAD)
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
    half = 0.5 * box.size + 0.16 * box.size.max()
    shape = ax.bbox.height / ax.bbox.width
    half = np.maximum(half, (half[1] / shape, half[0] * shape))
    middle = 0.5 * (box.low + box.high)
    ax.set_xlim(middle[0] - half[0], middle[0] + half[0])
    ax.set_ylim(middle[1] - half[1], middle[1] + half[1])
    ax.set_aspect("equal")
    ax.grid(visible=False)
    ax.set(xticks=[], yticks=[])
    pose = Pose(mechanism, mode.positions)
    size = 0.85 if columns <= 3 else 0.6
    drawn = Inked(ax, under(pose, points_per_unit(ax) / size), pose, size=size)
    labels = Labels(ax)
    if scaled:
        _scale_bar(ax, labels)
    if columns <= NAMED:
        drawn.avoided(labels)
        for word in words_of(pose):
            if word.strong:
                labels.beside_point(word.text, pose.positions[word.name], 3.0, fontsize=6.5)
    text = f"{mode.number}  {mode.text}".rstrip()
    colour = DRIVEN if mode.selected else "black"
    title = ax.set_title(text, fontsize=8, color=colour, pad=3)
    while title.get_window_extent().width > ax.bbox.width and len(text) > 1:
        text = text[:-2] + "…"
        title.set_text(text)
    for spine in ax.spines.values():
        spine.set(
            edgecolor=DRIVEN if mode.selected else GREY, linewidth=1.8 if mode.selected else 0.6
        )
    return ax


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
