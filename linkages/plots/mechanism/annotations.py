"""Labels that keep clear of lines, and dimensions."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from numpy.typing import ArrayLike, NDArray

from linkages.plots.mechanism import shapes as outlining
from linkages.plots.mechanism.links import anchored_outlines
from linkages.plots.mechanism.placing import Frame, at_joint, body_direction, joints, moved, placed
from linkages.plots.mechanism.plane_view import per_point, pixels
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.roles import body_role
from linkages.plots.mechanism.shapes import Anchor, Direction, Disc, Look, Shape, Strokes, Word
from linkages.plots.style import Scale

Array = NDArray[np.float64]

_AROUND = np.arange(16) * np.pi / 8
# Diagonals first, upper right foremost: bars and axes run along them least often.
_DIRECTIONS = np.column_stack((np.cos(_AROUND), np.sin(_AROUND)))[
    [2, 14, 6, 10, 0, 4, 12, 8, 1, 15, 3, 13, 5, 11, 7, 9]
]
_FRACTIONS = (0.5, 0.42, 0.58, 0.34, 0.66, 0.26, 0.74, 0.18, 0.82)
_BESIDE = (4.5, 7.5, 12.0, 18.0)  # points from a line
_HALO = 1.5  # points
_CELL = 2  # pixels
_INK = 0.72  # of the height of a line: most names have no descenders

_COST_HIT, _COST_BOX, _COST_OUTSIDE, _COST_LATER = 10.0, 60.0, 1000.0, 0.35


class Labels:
    """Places labels one after the other in an axes whose limits are final.

    `ax`: where to write.
    """

    def __init__(self, ax: Axes) -> None:
        self.ax = ax
        self._point = per_point(ax)
        self._obstacles: list[Array] = []
        self._boxes: list[Array] = []  # low and high corner
        self._table: Array | None = None

    def avoid(self, covered: Array) -> None:
        """Keep clear of pixels, shape (n, 2)."""
        self._obstacles.append(covered[np.isfinite(covered).all(axis=1)])
        self._table = None

    def avoid_line(self, points: ArrayLike) -> None:
        """Keep clear of a polyline, shape (n, 2), in units of the axes."""
        corners = pixels(self.ax, points)
        for start, end in pairwise(corners):
            length = np.hypot(*(end - start))
            if np.isfinite(length):
                steps = np.linspace(0, 1, int(min(length / 2, 2000)) + 2)[:, None]
                self.avoid(start + steps * (end - start))

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

    def beside_point(self, text: str, point: ArrayLike, gap: float = 5.0, **font: Any) -> None:
        """Label a point; `gap` is the least distance in points."""
        anchors = np.repeat(np.asarray(point, dtype=float)[None, :], 16, axis=0)
        self._put(text, anchors, _DIRECTIONS, (gap, gap + 4, gap + 9, gap + 16), font)

    def beside_segment(
        self, text: str, start: ArrayLike, end: ArrayLike, *, along: bool = False, **font: Any
    ) -> None:
        """Label a segment on one of its sides, near its middle if possible, or `along` it."""
        p, q = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
        way = np.subtract(*pixels(self.ax, (q, p)))
        normal = np.array([-way[1], way[0]]) / max(np.hypot(*way), 1e-12)
        if normal[1] < 0:
            normal = -normal
        anchors = np.repeat([p + f * (q - p) for f in _FRACTIONS], 2, axis=0)
        directions = np.tile((normal, -normal), (len(_FRACTIONS), 1))
        turn = float(np.arctan2(-normal[0], normal[1])) if along else 0.0
        self._put(text, anchors, directions, _BESIDE, font, turn)

    def in_polygon(self, text: str, corners: ArrayLike, **font: Any) -> None:
        """Label a polygon of shape (n, 2): in its middle if there is room, or beside a side."""
        points = np.asarray(corners, dtype=float)
        ends = np.roll(points, -1, axis=0)
        along = pixels(self.ax, ends) - pixels(self.ax, points)
        lengths = np.hypot(*along.T)
        order = np.argsort(-lengths, kind="stable")
        anchors, directions = [points.mean(axis=0)], [np.zeros(2)]
        for fraction in _FRACTIONS[:5]:
            for side in order:
                normal = np.array([-along[side, 1], along[side, 0]]) / max(lengths[side], 1e-12)
                anchors += [points[side] + fraction * (ends[side] - points[side])] * 2
                directions += [normal, -normal]
        self._put(text, np.array(anchors), np.array(directions), _BESIDE, font)

    def beside_curve(self, text: str, curve: ArrayLike, **font: Any) -> None:
        """Label a curve of shape (n, 2) anywhere along it."""
        points = np.asarray(curve, dtype=float)
        points = points[np.linspace(0, len(points) - 1, 24).round().astype(int)]
        anchors = np.repeat(points, 16, axis=0)
        self._put(text, anchors, np.tile(_DIRECTIONS, (24, 1)), (4.0, 8.0), font)

    def _put(
        self,
        text: str,
        anchors: Array,
        directions: Array,
        gaps: tuple[float, ...],
        font: Any,
        turn: float = 0.0,
    ) -> None:
        """Write at the cheapest candidate: anchors × gaps; turned by an angle in radians."""
        artist = self.ax.annotate(
            text,
            anchors[0],
            xytext=(0.0, 0.0),
            textcoords="offset points",
            horizontalalignment="center",
            verticalalignment="center_baseline",
            annotation_clip=False,
            zorder=9,
            path_effects=[withStroke(linewidth=2 * _HALO, foreground="white")],
            **font,
        )
        extent = artist.get_window_extent()
        half = 0.5 * np.array([extent.width, _INK * extent.height])
        axes = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        reach = np.abs(directions @ axes) @ half  # from the centre of the box to its edge
        offsets = np.concatenate([(g * self._point + reach)[:, None] * directions for g in gaps])
        places = np.tile(anchors, (len(gaps), 1))
        centres = pixels(self.ax, places) + offsets
        parts, half = _boxes_of(half, turn)
        cost = _COST_LATER * np.arange(len(centres))
        cost += sum(self._costs(centres + part, half) for part in parts)
        best = int(np.argmin(np.where(np.isfinite(cost), cost, np.inf)))
        artist.xy = tuple(places[best])
        artist.set_position(tuple(offsets[best] / self._point))
        if turn:
            artist.set(rotation=np.degrees(turn), verticalalignment="center")
        for part in parts:
            middle = centres[best] + part
            self._boxes.append(np.array([middle - half, middle + half]))

    def _costs(self, centres: Array, half: Array) -> Array:
        """What it would cost to write with the centre of the text at each of these pixels."""
        room = half + _HALO * self._point
        cost = _COST_HIT * self._covered(centres - room, centres + room)
        for low, high in self._boxes:
            overlap = np.minimum(centres + room, high) - np.maximum(centres - room, low)
            cost += _COST_BOX * np.prod(np.maximum(overlap, 0.0), axis=1) ** 0.5
        window = self.ax.get_window_extent()
        beyond = np.maximum(window.min - (centres - room), (centres + room) - window.max)
        return cost + _COST_OUTSIDE * np.maximum(beyond, 0.0).sum(axis=1)

    def _covered(self, low: Array, high: Array) -> Array:
        """How many cells of each box lie on obstacles, by a summed-area table."""
        if self._table is None:
            shape = tuple(int(side) // _CELL + 1 for side in self.ax.get_window_extent().max)
            taken = np.zeros(shape)
            for pixels_taken in self._obstacles:
                cells = (pixels_taken // _CELL).astype(int)
                inside = ((cells >= 0) & (cells < shape)).all(axis=1)
                taken[tuple(cells[inside].T)] = 1.0
            self._table = np.pad(taken.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
        table, most = self._table, np.array(self._table.shape) - 1
        x0, y0 = np.clip(low // _CELL, 0, most).astype(int).T
        x1, y1 = np.clip(high // _CELL + 1, 0, most).astype(int).T
        return table[x1, y1] - table[x0, y1] - table[x1, y0] + table[x0, y0]


def _boxes_of(half: Array, turn: float) -> tuple[Array, Array]:
    """Centres of upright boxes that a turned one consists of, roughly, and their half sizes."""
    if turn == 0.0:
        return np.zeros((1, 2)), half
    width, height = half
    count = int(np.ceil(width / height))
    along = np.linspace(height - width, width - height, count) if count > 1 else np.zeros(1)
    return along[:, None] * (np.cos(turn), np.sin(turn)), np.full(2, height)


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
    turning = {joint for body in pose.mechanism.bodies.values() for joint in body.points}
    pivots = [j for j in pose.mechanism.ground if j in turning and j in pose.positions]
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
