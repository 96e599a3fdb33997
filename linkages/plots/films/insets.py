"""Enlarged clearances: journals in bearings and blocks in guides."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from matplotlib.text import Text
from matplotlib.transforms import Affine2D, ScaledTranslation, Transform
from numpy.typing import NDArray

from linkages.components.contributed.normal_forces import CORNERS, CornerAtWall
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.films.force_arrows import ROOT, ArrowScale, arrow
from linkages.plots.mechanism.guide_symbols import AXIS_LINE
from linkages.plots.mechanism.inked_shapes import Inked
from linkages.plots.mechanism.placing import at_joint
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.roles import clearance_ends
from linkages.plots.mechanism.shapes import (
    Anchor,
    Direction,
    Disc,
    Look,
    Shape,
    Strokes,
    joints_of,
)
from linkages.plots.style import BLACK, CLEARANCE, LOAD, figure_of, nice_below, scale_for

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

# In radial clearances, which alone are to scale: the true radius of a pin is not in the file.
PIN, HOLE, WALL = 2.2, 3.2, 3.9

# In plays of one side, which alone are to scale, and across the guide only.
HALF, HEIGHT = 4.0, 1.7  # half length and half height of the block
RAIL, DEPTH, BEYOND = HEIGHT + 1.0, 0.6, 6.4  # from the axis; thickness; half length

RESTS, EDGE = Look("bar", 0.9, "pale"), Look("ink")
MOVES = Look("ink", 1.0, "journal")
LINK, DOT = Look("clearance", 1.4), Look("clearance", 0.0, "clearance")
DOT_RADIUS = 2.0  # points


class Enlarged(NamedTuple):
    """A clearance over the samples, in radial clearances of a pin, or plays of one side."""

    mechanism: Mechanism
    name: str
    joint: str  # that has it
    size: float  # radial clearance, or distance from each wall of a block in the middle, in metres
    offset: Array  # of the pin, shape (time, 2); of corners as in `CORNERS` across, (time, 4)
    forces: Array | None  # pressing positive, in newtons, shape (time, k), where the data have it
    shapes: list[Shape]  # in the order of drawing; those without joints rest
    places: dict[str, Array]  # joints of shapes, shape (time, 2) each
    feet: Array  # where forces are drawn, shape (time, k, 2)
    ways: Array  # the directions in which they press, shape (time, k, 2)

    def pose(self, index: int) -> Pose:
        """Joints of shapes at one sample."""
        places = {joint: path[index].tolist() for joint, path in self.places.items()}
        return Pose(self.mechanism, places)


def journals(data: xr.Dataset, mechanism: Mechanism) -> list[Enlarged]:
    """All clearances whose pin and hole are in the data: the hole rests, the pin moves in it."""
    result = []
    middle, pin = at_joint("hole"), at_joint("pin")
    shapes: list[Shape] = [
        Disc(Anchor(()), RESTS, metres=WALL),
        Disc(Anchor(()), replace(EDGE, fill="paper"), metres=HOLE),
        Disc(pin, MOVES, metres=PIN),
        Strokes(((middle, pin),), LINK),
        *(Disc(end, DOT, points=DOT_RADIUS) for end in (middle, pin)),
    ]
    for hole, joint in clearance_ends(mechanism).items():
        if not {hole, joint} <= {str(name) for name in data["joint"].values}:
            continue
        places = data["joint_position"].transpose("time", "joint", "axis")
        name = hole.removeprefix(f"{joint}.")
        size = next(own.size for own in mechanism.clearances if own.name == name)
        offset = (np.asarray(places.sel(joint=joint)) - np.asarray(places.sel(joint=hole))) / size
        distance = np.hypot(*offset.T)[:, None]
        way = np.divide(offset, distance, out=np.zeros_like(offset), where=distance > 0)[:, None]
        ends = {"hole": np.zeros_like(offset), "pin": offset}
        forces = _forces(data, [name])
        result.append(
            Enlarged(mechanism, name, joint, size, offset, forces, shapes, ends, WALL * way, way)
        )
    return result


def _forces(data: xr.Dataset, names: list[str]) -> Array | None:
    force = data.get("clearance_force")
    return None if force is None else np.asarray(force.sel(clearance=names), dtype=float)


def blocks(data: xr.Dataset, mechanism: Mechanism) -> list[Enlarged]:
    """All blocks with room in their guides whose corners are in the data: they turn between rails.

    A guide that turns lies level in the picture.
    """
    corners: dict[str, list[tuple[str, CornerAtWall]]] = {}
    for contact in mechanism.contacts:
        if isinstance(own := contact.geometry, CornerAtWall):
            corners.setdefault(own.play.name, []).append((contact.name, own))
    along, sides = np.array(CORNERS, dtype=float).T
    result = []
    for name, all_of_it in corners.items() if "clearance_offset" in data else ():
        names, corner = [own for own, _ in all_of_it], all_of_it[0][1]
        guide = mechanism.bodies[corner.play.slider].guide
        assert guide is not None
        turning = guide.body is not None and mechanism.bodies[guide.body].rotates
        angle, size = 0.0 if turning else guide.angle.value, corner.size.value
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        across = data["clearance_offset"].transpose("time", "clearance", "axis")[..., 1]
        offset = np.asarray(across.sel(clearance=names), dtype=float) / size
        slope = 0.25 * (offset @ along)[:, None] / HALF
        x, y = along * HALF - sides * HEIGHT * slope, sides * HEIGHT + offset
        places = np.stack([x, y], axis=-1) @ turn
        feet = np.stack([x, np.broadcast_to(sides * (RAIL + DEPTH), x.shape)], axis=-1) @ turn
        ways = np.column_stack([np.zeros(4), sides]) @ turn
        joint = next(iter(mechanism.bodies[corner.play.block].points))
        result.append(
            Enlarged(
                mechanism, name, joint, size, offset, _forces(data, names), _between_rails(angle),
                dict(zip("abcd", places.swapaxes(0, 1), strict=True)),
                feet, np.broadcast_to(ways, feet.shape),
            )
        )  # fmt: skip
    return result


def _between_rails(angle: float) -> list[Shape]:
    """A block whose corners are the joints a to d, between rails at an angle."""
    axis, result = Look("bar", 0.7, dashes=AXIS_LINE), list[Shape]()
    for y, look in ((-RAIL, EDGE), (RAIL, EDGE), (0.0, axis)):
        ends = [(-BEYOND, y), (BEYOND, y)]
        rail = [*ends, *((x, y + np.copysign(DEPTH, y)) for x, _ in ends[::-1])]
        for corners, own in ((rail, RESTS), (ends, look)):
            if own is not RESTS or y:
                places = tuple(Anchor((), metres=place) for place in corners)
                result.append(Strokes((places,), own, Direction(angle), closed=own is RESTS))
    middle = Anchor(tuple((joint, 0.25) for joint in "abcd"))
    body = Strokes((tuple(at_joint(joint) for joint in "abdc"),), MOVES, closed=True)
    return [*result, body, Disc(middle, DOT, points=DOT_RADIUS)]


# In clearances.
REACH, LONGEST = 7.4, 3.4  # half the picture, and the longest arrow
HEAD, SHAFT = 1.1, 0.17  # length of its head and half its width
KEY = 0.4  # of the width of the picture: where the arrow that explains the scale begins
SMALL, LINE = 8.0, 11.5  # size of texts and distance of lines in points
TICK = (-0.015, 0.015)  # of the picture: ends of the line that explains lengths


class Clock(NamedTuple):
    """The time of enlarged clearances, where it is not that of the mechanism."""

    time: Array  # of the samples, in seconds
    pace: str  # how fast they are shown, in words
    step: float  # time between frames in seconds


def enlarged(data: xr.Dataset, mechanism: Mechanism) -> list[Enlarged]:
    """All clearances that are in the data."""
    return [*journals(data, mechanism), *blocks(data, mechanism)]


class Inset:
    """The enlarged picture of one clearance, and under it what explains it.

    `ax`: where to draw; square.
    `shown`: what to draw.
    `metres`: how much of the main picture is as wide as `ax`.
    `samples`: of the film: the largest force among them has the longest arrow.
    `clock`: its own time, if it has one.
    """

    def __init__(
        self, ax: Axes, shown: Enlarged, metres: float, samples: NDArray[np.intp],
        clock: Clock | None = None,
    ) -> None:  # fmt: skip
        self._ax, self._shown, self._clock = ax, shown, clock
        ax.set(xlim=(-REACH, REACH), ylim=(-REACH, REACH), xticks=[], yticks=[])
        ax.set_aspect("equal")
        ax.grid(visible=False)
        first, forces = shown.pose(0), shown.forces
        Inked(ax, [shape for shape in shown.shapes if not joints_of(shape)], first)
        self._moving = Inked(ax, [shape for shape in shown.shapes if joints_of(shape)], first)
        self.scale = ArrowScale.of([] if forces is None else [forces[samples]])
        self._draw_scales(metres / (2 * REACH * shown.size))
        count = 0 if forces is None else forces.shape[1]
        self._arrows = [
            Polygon(np.zeros((3, 2)), color=LOAD, linewidth=0, zorder=7) for _ in range(count)
        ]
        for one in self._arrows:
            ax.add_artist(one)
        self._text = self._write(1.0, 2, "", color=LOAD, ha="right")
        self._moment = self._write(0.0, 2, "")
        for artist in self.artists:
            artist.set_animated(True)

    @property
    def artists(self) -> list[Artist]:
        """What moves, in the order in which it is drawn."""
        return [*self._moving.artists, *self._arrows, self._text, self._moment]

    def _write(self, x: float, line: int, text: str, **look: Any) -> Text:
        """Write below the picture; `x` is a part of its width, lines count from 1."""
        style: dict[str, Any] = {"va": "top", "fontsize": SMALL, "linespacing": 1.15} | look
        place = self._below(3.0 + LINE * (line - 1))
        return self._ax.text(x, 0.0, text, transform=place, **style)

    def _below(self, points: float) -> Transform:
        """Parts of the picture, so many points below it."""
        down = ScaledTranslation(0.0, -points / 72.0, figure_of(self._ax).dpi_scale_trans)
        return self._ax.transAxes + down

    def _draw_scales(self, enlarged: float) -> None:
        """Name and enlargement above; below, what lengths and arrows stand for."""
        shown, ax = self._shown, self._ax
        root = ROOT if self.scale.root else ""
        title = f"{shown.name} at {shown.joint}, {two_digits(enlarged)}×"
        look: dict[str, Any] = {"fontsize": SMALL, "pad": 3}
        ax.set_title(title, color=CLEARANCE, **look)
        ax.set_title(root, loc="right", color=LOAD, **look)
        length = nice_below(2.6 * shown.size)
        right = length / shown.size / (2 * REACH)
        place = self._below(3.0 + 0.5 * SMALL)
        for ends in (([0.0, right], [0.0, 0.0]), ([0.0, 0.0], TICK), ([right, right], TICK)):
            ax.plot(*ends, transform=place, linewidth=1.0, clip_on=False, color=BLACK)
        self._write(right + 0.02, 1, scale_for(10 * length, "m").text(length))
        if self.scale.full:
            length = LONGEST * self.scale.length(self.scale.key)
            corners = arrow(np.array([1.0, 0.0]), length, HEAD, SHAFT) / (2 * REACH)
            there = Affine2D().translate(KEY, 0.0) + self._below(LINE - 2.0)
            key = Polygon(corners, color=LOAD, linewidth=0, transform=there, clip_on=False)
            ax.add_artist(key)
            beside = KEY + length / (2 * REACH) + 0.03
            self._write(beside, 1, self.scale.text(self.scale.key), color=LOAD)

    def show(self, index: int) -> None:
        """Put everything where it is at one sample."""
        self._moving.show(self._shown.pose(index))
        self._show_forces(index)
        if (clock := self._clock) is not None:
            time = moment(clock.time[index], decimals(abs(clock.step)))
            self._moment.set_text(f"{time}\n{clock.pace}")

    def _show_forces(self, index: int) -> None:
        """The push at the wall; a pull, which no real contact has, points inwards."""
        shown = self._shown
        if shown.forces is None:
            return
        forces = shown.forces[index]
        several = zip(self._arrows, forces, shown.feet[index], shown.ways[index], strict=True)
        for one, force, foot, along in several:
            length = LONGEST * self.scale.length(float(force))
            one.set_xy(foot + arrow(along, length, HEAD, SHAFT))
            one.set_color(BLACK if force < 0 else LOAD)
        force = float(forces[np.argmax(np.abs(forces))])
        pull = force < 0
        self._text.set_color(BLACK if pull else LOAD)
        self._text.set_text(self.scale.text(force) + ("\nno contact" if pull else ""))


def two_digits(value: float) -> str:
    """A number rounded to two significant digits, without exponent."""
    return f"{float(f'{value:.1e}'):.12g}"


def decimals(step: float) -> int:
    """Decimals of a time in seconds that tell frames apart."""
    return int(np.clip(-np.floor(np.log10(step) + 1e-9), 0, 9))


def moment(time: float, digits: int) -> str:
    """A time in seconds as pictures write it."""
    return f"t = {time:.{digits}f} s".replace("-", "−")
