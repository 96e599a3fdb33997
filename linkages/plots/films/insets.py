"""Enlarged clearances: journals in bearings and blocks in guides."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, assert_never

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon
from matplotlib.text import Text
from matplotlib.transforms import Affine2D, ScaledTranslation, Transform
from numpy.typing import NDArray

from linkages.components.contributed.normal_forces import CORNERS, CornerAtWall
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.films.force_arrows import ROOT, ArrowScale, arrow
from linkages.plots.mechanism.roles import clearance_ends
from linkages.plots.style import (
    BLACK,
    CLEARANCE,
    LOAD,
    PALE,
    PASSIVE,
    figure_of,
    nice_below,
    scale_for,
)

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]
Foot = tuple[Array, Array]
"""Where a force is drawn, and the direction in which it presses."""

# In radial clearances, which alone are to scale: the true radius of a pin is not in the file.
PIN, HOLE, WALL = 2.2, 3.2, 3.9
FILL = "#F0F0F0"  # of journals and blocks


class Journal(NamedTuple):
    """A clearance over the samples."""

    name: str
    joint: str  # that has it
    size: float  # radial clearance in metres
    offset: Array  # from the hole's middle to the pin's, in radial clearances, shape (time, 2)
    forces: Array | None  # pressing positive, in newtons, shape (time, 1), where the data have it


def journals(data: xr.Dataset, mechanism: Mechanism) -> list[Journal]:
    """All clearances whose pin and hole are in the data."""
    result = []
    for hole, joint in clearance_ends(mechanism).items():
        if not {hole, joint} <= {str(name) for name in data["joint"].values}:
            continue
        places = data["joint_position"].transpose("time", "joint", "axis")
        way = np.asarray(places.sel(joint=joint)) - np.asarray(places.sel(joint=hole))
        name = hole.removeprefix(f"{joint}.")
        force = data.get("clearance_force")
        values = None if force is None else np.asarray(force.sel(clearance=[name]), dtype=float)
        size = next(own.size for own in mechanism.clearances if own.name == name)
        result.append(Journal(name, joint, size, way / size, values))
    return result


class JournalPicture:
    """The hole rests, the pin moves in it; axes are in radial clearances."""

    def __init__(self, ax: Axes, journal: Journal) -> None:
        self._journal = journal
        wall = Circle((0, 0), WALL, facecolor=PALE, edgecolor=PASSIVE, linewidth=0.9, zorder=1)
        ax.add_patch(wall)
        ax.add_patch(Circle((0, 0), HOLE, facecolor="white", edgecolor=BLACK, zorder=2))
        style: dict[str, Any] = {"zorder": 4, "linewidth": 1.0, "edgecolor": BLACK}
        self._pin = Circle((0, 0), PIN, facecolor=FILL, **style)
        (self._link,) = ax.plot([], [], color=CLEARANCE, linewidth=1.4, zorder=5)
        (self._dots,) = ax.plot([], [], "o", color=CLEARANCE, markersize=3, zorder=6)
        ax.add_artist(self._pin)

    @property
    def artists(self) -> list[Artist]:
        """What moves, in the order of drawing."""
        return [self._pin, self._link, self._dots]

    def show(self, index: int) -> list[Foot]:
        """Put everything where it is at one sample; returns where forces are, if there is a way."""
        offset = self._journal.offset[index]
        self._pin.set_center((float(offset[0]), float(offset[1])))
        for line in (self._link, self._dots):
            line.set_data([0.0, offset[0]], [0.0, offset[1]])
        distance = float(np.hypot(*offset))
        along = offset / distance if distance > 0 else np.zeros(2)
        return [(WALL * along, along)]


# In plays of one side, which alone are to scale, and across the guide only.
HALF, HEIGHT = 4.0, 1.7  # half length and half height of the block
RAIL, DEPTH, BEYOND = HEIGHT + 1.0, 0.6, 6.4  # from the axis; thickness; half length


class Block(NamedTuple):
    """A block with room in its guide over the samples."""

    name: str  # of the clearance
    joint: str  # in the middle of the block
    size: float  # distance from each wall in metres, of a block in the middle
    angle: float  # of the guide in the picture, in radians; 0 for one that turns
    offset: Array  # across the guide, of corners as in `CORNERS`, in plays, shape (time, 4)
    forces: Array | None  # on their walls, pressing positive, in newtons, shape (time, 4)


def blocks(data: xr.Dataset, mechanism: Mechanism) -> list[Block]:
    """All blocks with room in their guides whose corners are in the data."""
    corners: dict[str, list[tuple[str, CornerAtWall]]] = {}
    for contact in mechanism.contacts:
        if isinstance(own := contact.geometry, CornerAtWall):
            corners.setdefault(own.play.name, []).append((contact.name, own))
    result = []
    for name, all_of_it in corners.items() if "clearance_offset" in data else ():
        names, corner = [own for own, _ in all_of_it], all_of_it[0][1]
        guide = mechanism.bodies[corner.play.slider].guide
        assert guide is not None
        turning = guide.body is not None and mechanism.bodies[guide.body].rotates
        size, force = corner.size.value, data.get("clearance_force")
        across = data["clearance_offset"].transpose("time", "clearance", "axis")[..., 1]
        joint = next(iter(mechanism.bodies[corner.play.block].points))
        result.append(
            Block(
                name, joint, size,
                0.0 if turning else guide.angle.value,
                np.asarray(across.sel(clearance=names), dtype=float) / size,
                None if force is None else np.asarray(force.sel(clearance=names), dtype=float),
            )
        )  # fmt: skip
    return result


class BlockPicture:
    """The rails rest, the block moves and turns between them; axes are in plays."""

    def __init__(self, ax: Axes, block: Block) -> None:
        self._block = block
        cos, sin = np.cos(block.angle), np.sin(block.angle)
        self._turn = np.array([[cos, sin], [-sin, cos]])
        look: dict[str, Any]
        for side in (-1.0, 1.0):
            inner, outer = side * RAIL, side * (RAIL + DEPTH)
            rail = [(-BEYOND, inner), (BEYOND, inner), (BEYOND, outer), (-BEYOND, outer)]
            look = {"facecolor": PALE, "edgecolor": PASSIVE, "linewidth": 0.9}
            ax.add_patch(Polygon(np.array(rail) @ self._turn, zorder=1, **look))
            edge = np.array([(-BEYOND, inner), (BEYOND, inner)]) @ self._turn
            ax.plot(*edge.T, color=BLACK, linewidth=1.0, zorder=2)
        axis = np.array([(-BEYOND, 0.0), (BEYOND, 0.0)]) @ self._turn
        ax.plot(*axis.T, color=PASSIVE, linewidth=0.7, dashes=(9, 2, 1.5, 2), zorder=2)
        look = {"facecolor": FILL, "edgecolor": BLACK, "linewidth": 1.0, "zorder": 4}
        self._body = Polygon(np.zeros((4, 2)), **look)
        (self._pin,) = ax.plot([], [], "o", color=CLEARANCE, markersize=3, zorder=6)
        ax.add_artist(self._body)

    @property
    def artists(self) -> list[Artist]:
        """What moves, in the order of drawing."""
        return [self._body, self._pin]

    def show(self, index: int) -> list[Foot]:
        """Put everything where it is at one sample; returns where forces are at the rails."""
        across = self._block.offset[index]
        slope = 0.25 * float(np.dot(across, [along for along, _ in CORNERS])) / HALF
        corners = np.array(
            [
                (along * HALF - side * HEIGHT * slope, side * HEIGHT + offset)
                for (along, side), offset in zip(CORNERS, across, strict=True)
            ]
        )
        self._body.set_xy(corners[[0, 1, 3, 2]] @ self._turn)
        self._pin.set_data(*(corners.mean(axis=0) @ self._turn)[:, None])
        return [
            (np.array([x, side * (RAIL + DEPTH)]) @ self._turn, np.array([0.0, side]) @ self._turn)
            for (x, _), (_, side) in zip(corners.tolist(), CORNERS, strict=True)
        ]


Enlarged = Journal | Block

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
        self._picture = _picture(ax, shown)
        forces = shown.forces
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
        return [*self._picture.artists, *self._arrows, self._text, self._moment]

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
        feet = self._picture.show(index)
        if self._shown.forces is not None:
            self._show_forces(self._shown.forces[index], feet)
        if (clock := self._clock) is not None:
            time = moment(clock.time[index], decimals(abs(clock.step)))
            self._moment.set_text(f"{time}\n{clock.pace}")

    def _show_forces(self, forces: Array, feet: list[Foot]) -> None:
        """The push at the wall; a pull, which no real contact has, points inwards."""
        for one, force, (foot, along) in zip(self._arrows, forces, feet, strict=True):
            length = LONGEST * self.scale.length(float(force))
            one.set_xy(foot + arrow(along, length, HEAD, SHAFT))
            one.set_color(BLACK if force < 0 else LOAD)
        force = float(forces[np.argmax(np.abs(forces))])
        pull = force < 0
        self._text.set_color(BLACK if pull else LOAD)
        self._text.set_text(self.scale.text(force) + ("\nno contact" if pull else ""))


def _picture(ax: Axes, shown: Enlarged) -> JournalPicture | BlockPicture:
    match shown:
        case Journal():
            return JournalPicture(ax, shown)
        case Block():
            return BlockPicture(ax, shown)
        case _:
            assert_never(shown)


def two_digits(value: float) -> str:
    """A number rounded to two significant digits, without exponent."""
    return f"{float(f'{value:.1e}'):.12g}"


def decimals(step: float) -> int:
    """Decimals of a time in seconds that tell frames apart."""
    return int(np.clip(-np.floor(np.log10(step) + 1e-9), 0, 9))


def moment(time: float, digits: int) -> str:
    """A time in seconds as pictures write it."""
    return f"t = {time:.{digits}f} s".replace("-", "−")
