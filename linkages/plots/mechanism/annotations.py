"""Labels where there is room, and dimensions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from matplotlib.text import Annotation
from numpy.typing import ArrayLike, NDArray

from linkages.plots.mechanism import shapes as outlining
from linkages.plots.mechanism.links import anchored_outlines
from linkages.plots.mechanism.placing import Frame, at_joint, body_direction, joints, moved, placed
from linkages.plots.mechanism.plane_view import per_point, pixels
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.roles import body_role
from linkages.plots.mechanism.shapes import Anchor, Direction, Disc, Look, Shape, Strokes, Word
from linkages.plots.style import Scale, figure_of

Array = NDArray[np.float64]

_AROUND = np.arange(16) * np.pi / 8
# Diagonals first, upper right foremost: bars and axes run along them least often.
_DIRECTIONS = np.column_stack((np.cos(_AROUND), np.sin(_AROUND)))[
    [2, 14, 6, 10, 0, 4, 12, 8, 1, 15, 3, 13, 5, 11, 7, 9]
]
_FRACTIONS = 0.5 + 0.04 * np.array([0, -1, 1, -2, 2, -3, 3, -4, 4, -5, 5, -6, 6, -7, 7, -8, 8])
_FARTHER = np.array([0.0, 2.0, 4.0, 7.0, 11.0, 16.0, 22.0, 30.0, 40.0])
"""Points beyond the least distance of a label from what it names."""

_AWAY, _LEADER = 9.0, {"arrowstyle": "-", "linewidth": 0.5, "shrinkA": 0.0, "shrinkB": 2.0}
"""From which distance on a thin line leads to what is named, and how it looks."""

_LEAD = np.linspace(0.05, 1.0, 20)  # shares of it that keep clear of others
_BESIDE = 4.5  # points from a line to a label
_HALO = 1.5  # points
_FAINT, _FULL = 0.145, 0.5  # darkness of ink that may lie under labels, and that must not
_INK, _NEAR = 25.0, 0.15  # cost of a square point of ink; share of that in the halo around a text
_TAKEN, _OUTSIDE = 80.0, 200.0  # of a square point of another label, and beyond the axes
_LATER, _MANY = 0.35, 48  # of a candidate that others are preferred to; of so many at most
_POINT = 1.5  # of a point of distance
_SWEEPS = 6  # over all labels, each time put where it is cheapest now


@dataclass(frozen=True)
class _Label:
    """A text, and where it may be written."""

    artist: Annotation
    leader: tuple[Any, Any]  # the line to what it names, where that is far away, and its looks
    anchors: Array  # in the units of the axes, shape (looks or 1, candidates, 2)
    offsets: Array  # of the centre of the text, in pixels, shape (candidates, 2)
    corner: Array  # pixels from there to where the text begins
    costs: Array  # of candidates by themselves, shape (candidates,)
    away: NDArray[np.bool_]  # whether a line leads to what they name, shape (candidates,)
    known: NDArray[np.bool_]  # whether candidates are in pictures, shape (looks or 1, candidates)
    cells: NDArray[np.intp]  # of the raster that they cover, shape (looks or 1, candidates, n)
    weights: Array  # of cells, in square points, shape (n,)


class Labels:
    """Labels in axes whose limits are final, where they hide the least.

    What is drawn in the axes before the first label is a raster of ink. A label goes to the
    cheapest of its candidates: where little ink and no other label is, near to what it names.
    Labels are placed one after the other, and moved again by `improve`.

    `ax`: where to write.
    `looks`: pictures of a film, all of which labels keep clear of; `add` says what moves in them.
    """

    def __init__(self, ax: Axes, looks: int = 1) -> None:
        self.ax, self._looks = ax, looks
        self._point = per_point(ax)
        self._cell = max(2, round(self._point))  # pixels: side of a cell of the raster
        self._chosen: list[tuple[_Label, int]] = []
        figure = figure_of(ax)
        width, height = (round(side) for side in figure.bbox.size)
        self._renderer = RendererAgg(width, height, figure.dpi)

    def add(self, artists: Iterable[Artist], look: int) -> None:
        """Keep clear of what moves, as it is in one picture of a film."""
        self._costs[look] += self._inked(artists)

    def beside(
        self, text: str, places: Array, gap: float, *, along: bool = False, **font: Any
    ) -> None:
        """Label a point, a segment or a polygon of shape (n, 2); a segment `along` its direction.

        `gap` is the least distance from a point, in points.
        """
        if len(places) == 1:
            self.beside_point(text, places[0], gap, **font)
        elif len(places) == 2:
            self.beside_segment(text, *places, along=along, **font)
        else:
            self.in_polygon(text, places, **font)

    def beside_point(
        self, text: str, point: ArrayLike, gap: float = 5.0, **font: Any
    ) -> Annotation:
        """Label a point of shape (2,), or of shape (looks, 2) where it moves.

        `gap` is the least distance in points. A point is left out of pictures where it is not
        finite.
        """
        anchors = np.asarray(point, dtype=float).reshape(-1, 1, 2)
        return self._put(text, np.repeat(anchors, 16, axis=1), _DIRECTIONS, gap, font)

    def beside_segment(
        self, text: str, start: ArrayLike, end: ArrayLike, *, along: bool = False, **font: Any
    ) -> None:
        """Label a segment on one of its sides, near its middle if possible, or `along` it."""
        p, q = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
        (normal,) = self._normals(p[None], q[None])
        anchors = np.repeat([p + f * (q - p) for f in _FRACTIONS], 2, axis=0)
        directions = np.tile((normal, -normal), (len(_FRACTIONS), 1))
        turn = float(np.arctan2(-normal[0], normal[1])) if along else 0.0
        self._put(text, anchors[None], directions, _BESIDE, font, turn)

    def in_polygon(self, text: str, corners: ArrayLike, **font: Any) -> None:
        """Label a polygon of shape (n, 2): within if there is room, or beside a side."""
        points = np.asarray(corners, dtype=float)
        ends = np.roll(points, -1, axis=0)
        middle, low, high = points.mean(axis=0), points.min(axis=0), points.max(axis=0)
        shares = np.linspace(0.0, 1.0, 13)[1:-1]
        grid = low + np.stack(np.meshgrid(shares, shares), axis=-1).reshape(-1, 2) * (high - low)
        inside = np.vstack([middle, grid[Path(points).contains_points(grid)]])
        inside = inside[np.argsort(np.hypot(*(inside - middle).T), kind="stable")]
        order = np.argsort(-np.hypot(*(ends - points).T), kind="stable")
        sides = np.vstack([(points + f * (ends - points))[order] for f in _FRACTIONS])
        normals = np.tile(self._normals(points, ends)[order], (len(_FRACTIONS), 1))
        anchors = np.vstack([inside, sides, sides])
        directions = np.vstack([np.zeros_like(inside), normals, -normals])
        self._put(text, anchors[None], directions, _BESIDE, font)

    def beside_curve(self, text: str, curve: ArrayLike, **font: Any) -> None:
        """Label a curve of shape (n, 2) anywhere along it."""
        points = np.asarray(curve, dtype=float)
        points = points[np.linspace(0, len(points) - 1, 24).round().astype(int)]
        anchors = np.repeat(points, 16, axis=0)[None]
        self._put(text, anchors, np.tile(_DIRECTIONS, (24, 1)), 4.0, font)

    def improve(self) -> None:
        """Move labels to where they are cheapest beside all others, until none moves."""
        for _ in range(_SWEEPS):
            before = [best for _, best in self._chosen]
            for index, (label, best) in enumerate(self._chosen):
                self._take(label, best, -_TAKEN)
                self._chosen[index] = label, self._place(label)
            if before == [best for _, best in self._chosen]:
                break

    def _normals(self, starts: Array, ends: Array) -> Array:
        """Upward unit normals of segments on the paper, shape (n, 2)."""
        across = (pixels(self.ax, ends) - pixels(self.ax, starts)) @ [[0.0, 1.0], [-1.0, 0.0]]
        across[across[:, 1] < 0] *= -1.0
        return np.asarray(across / np.maximum(np.hypot(*across.T), 1e-12)[:, None])

    def _put(
        self, text: str, anchors: Array, directions: Array, gap: float, font: Any,
        turn: float = 0.0,
    ) -> Annotation:  # fmt: skip
        """Write at the cheapest candidate: anchors × gaps; turned by an angle in radians."""
        columns, rows = self._costs.shape[1:]  # of a raster that is made before there is a text
        artist = self.ax.annotate(
            text, (0.0, 0.0), (0.0, 0.0), textcoords="offset points", ha="left", va="baseline",
            rotation=np.degrees(turn), rotation_mode="anchor", annotation_clip=False, zorder=9,
            path_effects=[withStroke(linewidth=2 * _HALO, foreground="white")],
            arrowprops=_LEADER | {"color": font.get("color", "black")}, **font,
        )  # fmt: skip
        width, height, descent = self._renderer.get_text_width_height_descent(
            text, artist.get_fontproperties(), False
        )
        half = 0.5 * np.array([width, height])
        axes = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        reach = np.abs(directions @ axes) @ half  # from the centre of the box to its edge
        pairs = [
            (index, farther)
            for farther in _FARTHER
            for index in np.flatnonzero(directions.any(axis=1) | (farther == 0.0))
        ]
        order, farther = np.array([i for i, _ in pairs]), np.array([far for _, far in pairs])
        apart = (gap + farther) * self._point + reach[order]
        offsets, anchors = apart[:, None] * directions[order], anchors[:, order]
        rank = order * (_LATER * min(1.0, _MANY / len(directions)))
        # what the text covers, and its halo
        room = half + _HALO * self._point
        sides = [np.linspace(-side, side, int(2 * side / self._cell) + 2) for side in room]
        covered = np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 2)
        inner = (np.abs(covered) <= half).all(axis=1)
        area = np.prod(2 * room / self._point) / len(covered)
        # and the line that leads to it
        away = farther >= _AWAY
        leads = -(away[:, None] * offsets)[:, None] * _LEAD[:, None]
        around = np.broadcast_to(covered @ axes.T, (len(offsets), *covered.shape))
        around = offsets[:, None] + np.concatenate([around, leads], axis=1)
        places = np.nan_to_num(pixels(self.ax, anchors).reshape(anchors.shape))[..., None, :]
        x, y = (
            np.clip((place + way) // self._cell + 1, 0, size - 1).astype(np.intp)
            for place, way, size in zip(
                np.moveaxis(places, -1, 0), np.moveaxis(around, -1, 0), (columns, rows), strict=True
            )
        )
        label = _Label(
            artist, (artist.arrow_patch, artist.arrowprops), anchors, offsets,
            axes @ [-half[0], descent - half[1]], rank + _POINT * farther, np.asarray(away),
            np.isfinite(anchors.sum(axis=-1)), x * rows + y,
            np.append(area * np.where(inner, 1.0, _NEAR), np.full(len(_LEAD), 0.06)),
        )  # fmt: skip
        self._chosen.append((label, self._place(label)))
        return artist

    def _place(self, label: _Label) -> int:
        """Put a label where it is cheapest now, and say which candidate that is."""
        rasters = self._costs if len(label.cells) > 1 else self._costs.mean(axis=0, keepdims=True)
        covered = [
            np.where(known, raster.ravel().take(cells) @ label.weights, 0.0)
            for raster, known, cells in zip(rasters, label.known, label.cells, strict=True)
        ]
        best = int(np.argmin(label.costs + np.mean(covered, axis=0)))
        self._take(label, best, _TAKEN)
        leader = label.leader if label.away[best] else (None, None)
        label.artist.arrow_patch, label.artist.arrowprops = leader
        label.artist.xy = tuple(label.anchors[0, best])
        label.artist.set_position(tuple((label.offsets[best] + label.corner) / self._point))
        return best

    def _take(self, label: _Label, best: int, cost: float) -> None:
        """Make what a label covers dearer for others, or cheaper again."""
        for known, cells, rasters in zip(
            label.known, label.cells, np.split(self._costs, len(label.cells)), strict=True
        ):
            if known[best]:
                rasters.reshape(len(rasters), -1)[:, np.unique(cells[best])] += cost

    @cached_property
    def _costs(self) -> Array:
        """What a square point costs in each picture, shape (looks, columns, rows)."""
        self.ax.apply_aspect()
        drawn = [
            each
            for each in self.ax.get_children()
            if not (isinstance(each, Axis) or each is self.ax.patch or each.get_animated())
        ]
        ink = self._inked(sorted(drawn, key=lambda each: each.get_zorder()))
        window = self.ax.get_window_extent()
        middles = [self._cell * (np.arange(size) - 0.5) for size in ink.shape]
        beyond = [
            (middle < low) | (middle > high)
            for middle, low, high in zip(middles, window.min, window.max, strict=True)
        ]
        ink[beyond[0][:, None] | beyond[1]] += _OUTSIDE
        return np.repeat(ink[None], self._looks, axis=0)

    def _inked(self, artists: Iterable[Artist]) -> Array:
        """The cost of what artists draw, shape (columns, rows), with a margin of one cell."""
        self._renderer.clear()
        for artist in artists:
            artist.draw(self._renderer)
        picture = np.asarray(self._renderer.buffer_rgba())[::-1]
        red, green, blue, alpha = np.moveaxis(picture, -1, 0).astype(np.float32) / 255.0
        dark = alpha * (1.0 - (red + green + blue) / 3.0)
        dark = np.pad(dark, [(0, -side % self._cell) for side in dark.shape])
        rows, columns = (side // self._cell for side in dark.shape)
        cells = dark.reshape(rows, self._cell, columns, self._cell).max(axis=(1, 3)).T
        return np.pad(_INK * np.clip((cells - _FAINT) / (_FULL - _FAINT), 0.0, 1.0), 1)


FRAME, ANGLE = Look("ink", 0.6, dashes=(9.0, 4.0)), Look("ink", 0.6)
ARC = 20.0  # points: radius of the arc of an angle
CENTRE = 3.4  # points: radius of the mark of a centre of mass


def length_words(pose: Pose, scale: Scale) -> list[Word]:
    """The length of every bar and of every side of a plate, for a position in metres."""
    result = []
    for body, corners, direction in anchored_outlines(pose):
        look = Look(body_role(pose.mechanism, body.name))
        places = placed(pose, corners, direction, 0.0)
        sides = range(len(corners) if len(corners) > 2 else 1)
        for first, last in ((index, (index + 1) % len(corners)) for index in sides):
            length = scale.text(float(np.hypot(*(places[last] - places[first]))))
            side = (corners[first], corners[last])
            result.append(Word(length, side, look, 2.0, direction, body.name, along=True))
    return result


def frame_lines(pose: Pose) -> list[Strokes]:
    """Thin lines between the pivots on the ground, one after the other; arcs at those that rise."""
    result = []
    for first, second, angle in _frame(pose):
        line = Frame(pose, joints(first, second))
        result.append(line.line((at_joint(first), at_joint(second)), FRAME))
        if angle:
            frame = Frame(pose, Direction())
            arc = outlining.arc(ARC, 0.0, angle)
            level = [(0.0, 0.0), (ARC + 6.0, 0.0)]
            result.append(frame.symbol(at_joint(first), [arc, level], ANGLE))
    return result


def frame_words(pose: Pose, scale: Scale) -> list[Word]:
    """How far pivots on the ground are apart, and at what angle one is seen from another."""
    result = []
    for first, second, angle in _frame(pose):
        way = np.subtract(pose.positions[second], pose.positions[first])
        ends = at_joint(first), at_joint(second)
        result.append(Word(scale.text(float(np.hypot(*way))), ends, Look("ink"), 2.0, along=True))
        if angle:
            half = (ARC * float(np.cos(0.5 * angle)), ARC * float(np.sin(0.5 * angle)))
            text = f"{np.degrees(angle):.4g}°".replace("-", "−")
            result.append(Word(text, (at_joint(first, half),), Look("ink"), 2.0))
    return result


def _frame(pose: Pose) -> list[tuple[str, str, float]]:
    """Pivots on the ground in pairs, from left to right, and the angle of the line between them.

    0 for lines that are level or upright, which need no angle.
    """
    pivots = [j for j in pose.mechanism.ground if j in pose.meeting and j in pose.positions]
    pivots.sort(key=lambda joint: pose.positions[joint])
    result = []
    for first, second in pairwise(pivots):
        across, up = np.subtract(pose.positions[second], pose.positions[first])
        near = 1e-9 * pose.extent
        plain = abs(across) <= near or abs(up) <= near
        result.append((first, second, 0.0 if plain else float(np.arctan2(up, across))))
    return result


def draw_centres(pose: Pose) -> list[Shape]:
    """A quartered circle at the centre of mass of every bar and plate that has one."""
    return [
        shape
        for name, frame, place in _centres(pose)
        for shape in _centre_mark(frame.fixed(place, name), frame.direction, name)
    ]


def centre_lines(pose: Pose) -> list[Strokes]:
    """Thin lines from centres of mass to the nearest joints, which are seen beside bodies alone."""
    result = []
    for name, frame, place in _centres(pose):
        joints_ = pose.shown(name)
        near = min(joints_, key=lambda j: float(np.hypot(*(joints_[j] - place))))
        result.append(frame.line((frame.fixed(place, name), at_joint(near)), ANGLE))
    return result


def _centres(pose: Pose) -> Iterator[tuple[str, Frame, Array]]:
    """Bodies with their frames and the places of their centres of mass."""
    for name, body in pose.mechanism.bodies.items():
        place = pose.place(name, body.centre) if body.rotates and body.mass.value > 0.0 else None
        if place is not None:
            yield name, Frame(pose, body_direction(pose, name)), place


def _centre_mark(centre: Anchor, direction: Direction, name: str) -> list[Shape]:
    quarters = [
        [(0.0, 0.0), *outlining.arc(CENTRE, first, first + 0.5 * np.pi, 9)]
        for first in (0.0, np.pi)
    ]
    strokes = tuple(tuple(moved(centre, *point) for point in quarter) for quarter in quarters)
    return [
        Disc(centre, Look("ink", 0.7, "paper"), points=CENTRE, direction=direction, name=name),
        Strokes(strokes, Look("ink", 0.0, "ink"), direction, closed=True, name=name),
    ]
