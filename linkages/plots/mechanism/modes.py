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
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.view import Box, Positions
from linkages.plots.style import DRIVEN, GREY, WIDTH, fitted, styled

MOST = 48
"""How many drawings one figure holds."""

EDGE, HEAD, FOOT = 0.1, 0.24, 0.28  # inches around a drawing, above it, and below all of them
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
    """Drawings at one scale, the selected one in a coloured frame.

    Parameters
    ----------
    mechanism
        Whose modes they are.
    modes
        At least one; a note says so if there are more than `MOST`.
    """
    shown = shown_modes(modes)
    reaches = [reach(Pose(mechanism, mode.positions)) for mode in shown]
    box = Box.around([corner for part in reaches for corner in (part.low, part.high)])
    columns = min(len(shown), 3 if 4 < len(shown) <= 9 else 4 if len(shown) <= 24 else 6)
    rows = math.ceil(len(shown) / columns)
    width = WIDTH / columns - EDGE
    shape = float(np.clip(box.size[1] / max(box.size[0], 1e-9), LOWEST, HIGHEST))
    height = min(shape * width, 4.5)
    total = rows * (height + HEAD) + FOOT + HEAD
    result = Figure(figsize=(WIDTH, total))
    for index, mode in enumerate(shown):
        row, column = divmod(index, columns)
        left = column * (width + EDGE) + 0.5 * EDGE
        bottom = total - HEAD - (row + 1) * (height + HEAD)
        ax = result.add_axes((left / WIDTH, bottom / total, width / WIDTH, height / total))
        draw(ax, mechanism, mode, box, columns)
    heading = f"{mechanism.name}: assembly modes"
    result.text(0.5 * EDGE / WIDTH, 1 - 0.17 / total, fitted(heading, WIDTH), weight="bold")
    note = "framed: the mode that the definition selects" if any(m.selected for m in shown) else ""
    if len(shown) < len(modes):
        note = "; ".join(part for part in (note, f"{len(shown)} of {len(modes)} modes") if part)
    result.text(0.5 * EDGE / WIDTH, 0.09 / total, note, fontsize=8, color=DRIVEN)
    return result


def draw(ax: Axes, mechanism: Mechanism, mode: Mode, box: Box, columns: int = 1) -> Axes:
    """Draw one mode in a box, without names; smaller symbols where there are many columns."""
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
    Inked(ax, under(pose, points_per_unit(ax) / size), pose, size=size)
    text = f"{mode.number}  {mode.text}".rstrip()
    inches = ax.bbox.width / ax.figure.dpi
    colour = DRIVEN if mode.selected else "black"
    ax.set_title(fitted(text, inches, 8.0), fontsize=8, color=colour, pad=3)
    for spine in ax.spines.values():
        spine.set(
            edgecolor=DRIVEN if mode.selected else GREY, linewidth=1.8 if mode.selected else 0.6
        )
    return ax
