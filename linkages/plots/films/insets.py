"""Clearances under a magnifying glass: what touches, and the forces there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, assert_never

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from matplotlib.text import Text
from matplotlib.transforms import Affine2D, ScaledTranslation, Transform
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.films.arrows import ROOT, ArrowScale, arrow
from linkages.plots.films.guides import Block, BlockPicture, blocks
from linkages.plots.films.journals import Foot, Journal, JournalPicture, journals
from linkages.plots.prefixes import nice_below, scale_for
from linkages.plots.style import BLACK, CLEARANCE, LOAD, fitted

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]
Enlarged = Journal | Block

# In clearances.
REACH, LONGEST = 7.4, 3.4  # half the picture, and the longest arrow
HEAD, SHAFT = 1.1, 0.17  # length of its head and half its width
KEY = 0.4
"""Of the width of the picture: where the arrow that explains the scale begins."""

SMALL, LINE = 8.0, 11.5
"""Size of texts and distance of lines in points."""

TICK = (-0.015, 0.015)
"""Of the picture: ends of the line that explains lengths."""


class Clock(NamedTuple):
    """The time of enlarged clearances, where it is not that of the mechanism.

    Attributes
    ----------
    time
        Of the samples, in seconds.
    pace
        How fast they are shown, in words.
    step
        Time between frames in seconds.
    """

    time: Array
    pace: str
    step: float


def enlarged(data: xr.Dataset, mechanism: Mechanism) -> list[Enlarged]:
    """All clearances that are in the data."""
    return [*journals(data, mechanism), *blocks(data, mechanism)]


class Inset:
    """The enlarged picture of one clearance, and under it what explains it.

    Parameters
    ----------
    ax
        Where to draw; square.
    shown
        What to draw.
    metres
        How much of the main picture is as wide as `ax`.
    samples
        Of the film: the largest force among them has the longest arrow.
    clock
        Its own time, if it has one.
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
        figure = self._ax.get_figure(root=True)
        assert figure is not None
        down = ScaledTranslation(0.0, -points / 72.0, figure.dpi_scale_trans)
        return self._ax.transAxes + down

    def _draw_scales(self, enlarged: float) -> None:
        """Name and enlargement above; below, what lengths and arrows stand for."""
        shown, ax = self._shown, self._ax
        root = ROOT if self.scale.root else ""
        inches = ax.bbox.width / ax.figure.dpi - 0.06 * len(root)
        title = f"{shown.name} at {shown.joint}, {two_digits(enlarged)}×"
        look: dict[str, Any] = {"fontsize": SMALL, "pad": 3}
        ax.set_title(fitted(title, inches, SMALL), color=CLEARANCE, **look)
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
