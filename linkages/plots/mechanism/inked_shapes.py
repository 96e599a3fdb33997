"""Shapes drawn by Matplotlib, and their colours."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any, assert_never, cast

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Circle, PathPatch
from matplotlib.path import Path
from matplotlib.patheffects import Normal, Stroke
from numpy.typing import NDArray

from linkages.plots.mechanism.placing import drawable, placed
from linkages.plots.mechanism.plane_view import per_point, pixels
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.shapes import Disc, Look, Shape, Strokes, Word
from linkages.plots.style import BLACK, CLEARANCE, DRIVEN, FREE, GREY, LOAD, PALE, PALETTE, PASSIVE

COLOURS: Mapping[str, tuple[str, str, str]] = {
    "paper": ("#FFFFFF", "#14181C", ""),
    "ink": (BLACK, "#E8E8E8", ""),
    "pale": (PALE, "#3A4148", ""),
    "journal": ("#F0F0F0", "#2A3036", ""),
    "guide": (GREY, "#7C858D", ""),
    "bar": (PASSIVE, "#A9B6C0", ""),
    "driven": (DRIVEN, "#FF8A3D", "driven"),
    "free": (FREE, "#5AB4F0", "free"),
    "clearance": (CLEARANCE, "#FF6FB5", "clearance"),
    "load": (LOAD, "#BE94DE", "load"),
    "cylinder": (LOAD, "#BE94DE", "cylinder"),
    "spring": (PALETTE[2], "#3CC795", "spring, damper"),
    "friction": (PALETTE[8], "#CFAE63", "friction"),
}
"""Role → colour on light and on dark paper, and what legends say that it means."""

LIGHT, DARK, MEANINGS = (
    {role: own[column] for role, own in COLOURS.items()} for column in range(3)
)

Array = NDArray[np.float64]

LAYERS = (2.0, 8.0)  # from the layer of the first shape to that of the last
PALER = 0.42  # how much of its own colour a shape in the background keeps


class Inked:
    """Shapes on axes whose limits are final.

    `ax`: where to draw.
    `shapes`: in the order of drawing; words are left to `Labels`.
    `pose`: where they are, in the units of the axes.
    `pale`: in the colours of a background.
    `size`: of symbols and widths of lines, over that of a figure.
    """

    def __init__(
        self, ax: Axes, shapes: Iterable[Shape], pose: Pose, *, pale: bool = False,
        size: float = 1.0,
    ) -> None:  # fmt: skip
        self._point = size / points_per_unit(ax)
        self._pairs: list[tuple[Strokes | Disc, PathPatch | Circle]] = []
        drawn = [shape for shape in shapes if not isinstance(shape, Word)]
        layers = np.linspace(*(LAYERS if not pale else (1.1, 1.9)), len(drawn)).tolist()
        seen: Counter[str] = Counter()
        for shape, layer in zip(drawn, layers, strict=True):
            artist = Circle((0, 0), 1.0) if isinstance(shape, Disc) else PathPatch(Path([(0, 0)]))
            seen[shape.name] += 1  # identifiers of SVG are unique
            gid = f"{shape.name}-{seen[shape.name]}" if shape.name else None
            artist.set(zorder=layer, gid=gid, **_style(shape.look, pale, size))
            self._pairs.append((shape, artist))
            ax.add_artist(artist)
        self.show(pose)

    @property
    def artists(self) -> list[Artist]:
        """In the order of drawing."""
        return [artist for _, artist in self._pairs]

    def show(self, pose: Pose) -> None:
        """Put every shape where it is in a position, in the units of the axes.

        Those whose joints are not known there are hidden.
        """
        for shape, artist in self._pairs:
            artist.set_visible(drawable(pose, shape))
            if not artist.get_visible():
                continue
            match shape:
                case Disc():
                    assert isinstance(artist, Circle)
                    (centre,) = placed(pose, [shape.centre], shape.direction, self._point)
                    artist.set_center((float(centre[0]), float(centre[1])))
                    artist.set_radius(shape.metres * pose.unit + shape.points * self._point)
                case Strokes():
                    assert isinstance(artist, PathPatch)
                    artist.set_path(_path(pose, shape, self._point))
                case _:
                    assert_never(shape)


def points_per_unit(ax: Axes) -> float:
    """Typographic points per unit of the axes, whose scale is equal."""
    (start, end) = pixels(ax, [(0.0, 0.0), (1.0, 0.0)])
    return float(np.hypot(*(end - start))) / per_point(ax)


def _path(pose: Pose, shape: Strokes, point: float) -> Path:
    places = placed(pose, [a for stroke in shape.strokes for a in stroke], shape.direction, point)
    vertices, codes, first = [], [], 0
    for stroke in shape.strokes:
        part = places[first : first + len(stroke)]
        first += len(stroke)
        vertices.append(part)
        codes += [Path.MOVETO, *[Path.LINETO] * (len(part) - 1)]
        if shape.closed:
            vertices.append(part[:1])
            codes.append(Path.CLOSEPOLY)
    return Path(np.vstack(vertices), codes)


def _style(look: Look, pale: bool, size: float) -> dict[str, Any]:
    def colour(role: str) -> Any:
        return faded(LIGHT[role]) if pale else LIGHT[role]

    width = size * look.width
    result: dict[str, Any] = {
        "linewidth": width,
        "edgecolor": colour(look.role) if width else "none",
        "facecolor": (*_rgb(colour(look.fill)), look.opacity) if look.fill else "none",
        "capstyle": "butt" if look.dashes else "round",
        "joinstyle": "round",
    }
    if look.dashes:
        result["linestyle"] = (0, tuple(look.dashes))
    if look.casing:
        under = _Casing(linewidth=width + 2 * size * look.casing, foreground=LIGHT["paper"])
        result["path_effects"] = [under, Normal()]
    return result


class _Casing(Stroke):
    """A stroke under the edge of a shape, which leaves its fill alone."""

    def draw_path(
        self, renderer: Any, gc: Any, tpath: Any, affine: Any, rgbFace: Any = None  # noqa: ARG002
    ) -> None:  # fmt: skip
        """Draw the edge only."""
        super().draw_path(renderer, gc, tpath, affine, cast(Any, None))


def _rgb(colour: Any) -> tuple[float, float, float]:
    from matplotlib.colors import to_rgb

    return to_rgb(colour)


def faded(colour: str) -> tuple[float, float, float]:
    """A colour on its way to that of paper."""
    own, paper = np.array(_rgb(colour)), np.array(_rgb(LIGHT["paper"]))
    red, green, blue = (PALER * own + (1.0 - PALER) * paper).tolist()
    return red, green, blue
