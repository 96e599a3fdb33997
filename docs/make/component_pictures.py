"""Pictures of the pages on components: small mechanisms of component_pictures.yaml."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import linkages
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.scene import Target
from linkages.plots.figures import write_figure
from linkages.plots.mechanism import traces
from linkages.plots.mechanism.annotations import Labels, draw_centres, length_words
from linkages.plots.mechanism.drawing import framed, reach, shapes_of, write
from linkages.plots.mechanism.inked_shapes import Inked, points_per_unit
from linkages.plots.mechanism.plane_view import Box, frame, gravity_arrow, room_in
from linkages.plots.mechanism.pose import Pose, pose_at
from linkages.plots.style import styled
from linkages.reading.document import parse
from make.registry import STATIC, makes_each

DEFINITIONS = Path(__file__).with_suffix(".yaml")
WIDTH = 3.0  # inches
LOWEST, HIGHEST = 1.2, 2.6
MARGIN = 0.4
ROOM = (72.0 * (WIDTH - 2 * MARGIN), 72.0 * (HIGHEST - 2 * MARGIN))
"""Points within the margins."""
TRACED = {"simulation", "target"}
"""Pages whose pictures have paths."""
SIZED = {"bar"}
"""Pages whose pictures have lengths and centres of mass."""


@styled
def component(mechanism: Mechanism) -> Figure:
    """A mechanism where it starts; rails are as long as what slides on them travels."""
    data = linkages.simulate(mechanism).data
    pose = pose_at(data, mechanism, 0)
    box = framed(data, mechanism)[1] if mechanism.name in TRACED else reach(pose, ROOM)
    inches = (WIDTH - 2 * MARGIN) / max(box.size[0], 1e-3 * box.size[1])  # per metre
    height = min(max(inches * box.size[1] + 2 * MARGIN, LOWEST), HIGHEST)
    figure = Figure(figsize=(WIDTH, height))
    ax = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    if mechanism.name in TRACED:
        traces.draw(ax, data, mechanism)
        scale = frame(ax, framed(data, mechanism, room_in(ax))[1], mechanism)
        for target in (each for each in mechanism.components if isinstance(each, Target)):
            x, y = scale.factor * np.array(target.points).T
            ax.plot(x, y, "k+", markersize=7, zorder=5)
    else:
        shown(ax, pose, box)
    ax.set_title("")
    ax.set_title("", loc="right")
    ax.axis("off")
    if gravity_arrow(mechanism):
        ax.annotate(f"gravity {gravity_arrow(mechanism)}", (1, 1), (-6, -6), "axes fraction",
                    "offset points", ha="right", va="top")  # fmt: skip
    for text in ax.texts:
        text.set_path_effects([])
    return figure


def shown(ax: Axes, pose: Pose, box: Box) -> None:
    """Draw a position, on some pages with lengths."""
    scale = frame(ax, box, pose.mechanism, MARGIN)
    labels, place = Labels(ax), pose.scaled(scale.factor)
    shapes = shapes_of(pose, points_per_unit(ax) * scale.factor)
    if pose.mechanism.name in SIZED:
        shapes += [*draw_centres(pose), *length_words(pose, scale)]
    Inked(ax, shapes, place)
    write(labels, shapes, place)


def shortened(text: str, digits: int = 2) -> str:
    """An SVG whose paths have hundredths of a point, which are enough for the eye, or fewer."""

    def path(found: re.Match[str]) -> str:
        longer = rf"-?\d+\.\d{{{digits + 1},}}"
        return re.sub(longer, lambda number: f"{float(number[0]):.{digits}f}", found[0])

    return re.sub(r' d="[^"]*"', path, text)


def write_shortened(figure: Figure, path: Path) -> Path:
    """Write an SVG, shortened."""
    write_figure(figure, path)
    path.write_text(shortened(path.read_text(encoding="utf-8")), encoding="utf-8")
    return path


TEXTS = DEFINITIONS.read_text(encoding="utf-8").split("\n---\n")
NAMES = [f"component-{parse(text, 'picture').content['name']}.svg" for text in TEXTS]


@makes_each({(name,): (name, text) for name, text in zip(NAMES, TEXTS, strict=True)})
def picture(name: str, text: str) -> Path:
    """The picture of a mechanism."""
    return write_shortened(component(linkages.loads(text)), STATIC / name)
