"""Assembly branches side by side: small drawings of the same mechanism."""

from __future__ import annotations

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
from linkages.plots.mechanism.plane_view import Box, Positions, blank, small_pictures
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.shapes import Pair
from linkages.plots.style import DRIVEN, GREY, WIDTH, nice_below, scale_for, styled, width_of

MOST = 48  # how many drawings one figure holds
NAMED = 4  # columns in which there is room for names
COLUMNS = ((3, 3), (4, 2), (9, 3), (24, 4), (MOST, 6))
"""Up to how many drawings there are how many beside each other."""

LETTERS, PER_INCH = 10, 15.0  # of a title: fewest in a line, and how many are sure to have room
LABELLED = 13.0  # points around symbols: room for names
BAR = 10.0  # points below them: room for the scale
ALIKE = 1.05  # extents of drawings that are no farther apart than this have one scale


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
    columns = min(len(shown), next(most for upto, most in COLUMNS if len(shown) <= upto))
    width = WIDTH / columns - 0.1
    widest, highest = np.max([reach(pose, _room(width, width, columns)).size for pose in poses], 0)
    note = "framed: the mode that the definition selects" if any(m.selected for m in shown) else ""
    if len(shown) < len(modes):
        note = "; ".join(part for part in (note, f"{len(shown)} of {len(modes)} modes") if part)
    lines = 1 + max(_title(mode, width).count("\n") for mode in shown)
    heading = f"{mechanism.name}: assembly modes"
    shape = highest / max(widest, 1e-9)
    result, axes = small_pictures(len(shown), columns, shape, heading, lines, note)
    boxes = [reach(pose, _room(width, _height(axes[0]), columns)) for pose in poses]
    extents = [box.bare.extent if box.bare else box.extent for box in boxes]
    scaled = max(extents) > ALIKE * min(extents)
    for ax, mode, box in zip(axes, shown, boxes, strict=True):
        draw(ax, mechanism, mode, box, columns, scaled=scaled)
    return result


def _height(ax: Axes) -> float:
    return float(ax.bbox.height / ax.figure.dpi)


def draw(
    ax: Axes, mechanism: Mechanism, mode: Mode, box: Box, columns: int = 1, *, scaled: bool = False
) -> Axes:
    """Draw one mode in a box, with names of joints; without and smaller in many columns.

    Where it is `scaled`, a bar says how long something is.
    """
    inches = np.array([width_of(ax), _height(ax)])
    room = _room(float(inches[0]), float(inches[1]), columns)
    point = float(np.max(box.size / room))
    half = 0.5 * point * 72.0 * inches / _size(columns)
    middle = 0.5 * (box.low + box.high) - (0.0, 0.5 * point * BAR)
    ax.set_xlim(middle[0] - half[0], middle[0] + half[0])
    ax.set_ylim(middle[1] - half[1], middle[1] + half[1])
    ax.set_aspect("equal")
    blank(ax)
    pose = Pose(mechanism, mode.positions)
    size = _size(columns)
    Inked(ax, under(pose, points_per_unit(ax) / size), pose, size=size)
    if scaled:
        _scale_bar(ax)
    if columns <= NAMED:
        labels = Labels(ax)
        for word in words_of(pose):
            if word.strong:
                labels.beside_point(word.text, pose.positions[word.name], 3.0, fontsize=6.5)
        labels.improve()
    colour = DRIVEN if mode.selected else "black"
    ax.set_title(_title(mode, float(inches[0])), color=colour, pad=3)
    edge = (DRIVEN, 1.8) if mode.selected else (GREY, 0.6)
    for spine in ax.spines.values():
        spine.set(edgecolor=edge[0], linewidth=edge[1])
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


def _scale_bar(ax: Axes) -> None:
    """A length of the plane in the lower left corner, which labels keep clear of."""
    low, high = ax.get_xlim()
    length = nice_below(0.22 * (high - low))
    left, bottom = low + 0.04 * (high - low), ax.get_ylim()[0] + 0.05 * float(np.ptp(ax.get_ylim()))
    ax.plot([left, left + length], [bottom, bottom], color=LIGHT["ink"], linewidth=1.0)
    text = scale_for(length, "m").text(length)
    ax.annotate(text, (left, bottom), (0, 2), textcoords="offset points", fontsize=6.5)
