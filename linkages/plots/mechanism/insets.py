"""Clearances under a magnifying glass: a pin in its hole, and the force between them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon
from matplotlib.text import Text
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.mechanism.bodies import clearance_ends
from linkages.plots.prefixes import scale_for
from linkages.plots.style import BLACK, CLEARANCE, LOAD, PALE, PASSIVE, fitted

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

# In radial clearances, which alone are to scale: the true radius of a pin is not in the file.
PIN, HOLE, WALL = 2.2, 3.2, 3.9
REACH, LONGEST = 7.4, 3.9  # half the picture, and the longest arrow
SHAFT = 0.17  # half the width of an arrow, of one that is long enough
SLENDER = 0.5  # half the width of its head over its length
EXCEPTION = 1.3  # times what three quarters stay below: larger forces have the longest arrow
CORNER = 0.04  # of the picture: where texts stand


class ClearanceMotion(NamedTuple):
    """A clearance over the samples.

    Attributes
    ----------
    name, joint
        Of the clearance, and of the joint that has it.
    size
        Radial clearance in metres.
    offset
        From the middle of the hole to that of the pin, in radial clearances, shape (time, 2).
    force
        Tension positive, in newtons, shape (time,); None if the data do not have it.
    """

    name: str
    joint: str
    size: float
    offset: Array
    force: Array | None


def contacts(data: xr.Dataset, mechanism: Mechanism) -> list[ClearanceMotion]:
    """All clearances whose pin and hole are in the data."""
    found = []
    for hole, joint in clearance_ends(mechanism).items():
        if not {hole, joint} <= {str(name) for name in data["joint"].values}:
            continue
        places = data["joint_position"].transpose("time", "joint", "axis")
        way = np.asarray(places.sel(joint=joint)) - np.asarray(places.sel(joint=hole))
        name = hole.removeprefix(f"{joint}.")
        force = data.get("clearance_force")
        values = None if force is None else np.asarray(force.sel(clearance=name), dtype=float)
        size = next(own.size for own in mechanism.clearances if own.name == name)
        found.append(ClearanceMotion(name, joint, size, way / size, values))
    return found


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


class Inset:
    """The enlarged picture of one clearance; the hole rests, the pin moves in it.

    Parameters
    ----------
    ax
        Where to draw; square.
    contact
        What to draw.
    metres
        How much of the main picture is as wide as `ax`.
    clock
        Its own time, if it has one.
    """

    def __init__(
        self, ax: Axes, contact: ClearanceMotion, metres: float, clock: Clock | None = None
    ) -> None:
        self._contact, self._clock = contact, clock
        self._full = 0.0 if contact.force is None else full_length(contact.force)
        enlarged = metres / (2 * REACH * contact.size)
        self._draw_still(ax, enlarged)
        style: dict[str, Any] = {"zorder": 4, "linewidth": 1.0, "edgecolor": BLACK}
        self._pin = Circle((0, 0), PIN, facecolor="white", **style)
        (self._link,) = ax.plot([], [], color=CLEARANCE, linewidth=1.4, zorder=5)
        (self._dots,) = ax.plot([], [], "o", color=CLEARANCE, markersize=3, zorder=6)
        self._arrow = Polygon(np.zeros((3, 2)), color=LOAD, linewidth=0, zorder=7)
        ax.add_artist(self._pin)
        ax.add_artist(self._arrow)
        self._text: Text = ax.text(
            1 - CORNER, CORNER, "", transform=ax.transAxes, ha="right", color=LOAD, zorder=8
        )
        self._moment: Text = ax.text(
            CORNER, 1 - CORNER, "", transform=ax.transAxes, va="top", fontsize=8, zorder=8
        )
        for artist in self.artists:
            artist.set_animated(True)

    @property
    def artists(self) -> list[Artist]:
        """What moves, in the order in which it is drawn."""
        return [self._pin, self._link, self._dots, self._arrow, self._text, self._moment]

    def _draw_still(self, ax: Axes, enlarged: float) -> None:
        """The hole, and the scale."""
        contact = self._contact
        ax.set(xlim=(-REACH, REACH), ylim=(-REACH, REACH), xticks=[], yticks=[])
        ax.set_aspect("equal")
        ax.grid(visible=False)
        wall = Circle((0, 0), WALL, facecolor=PALE, edgecolor=PASSIVE, linewidth=0.9, zorder=1)
        ax.add_patch(wall)
        ax.add_patch(Circle((0, 0), HOLE, facecolor="white", edgecolor=BLACK, zorder=2))
        inches = ax.bbox.width / ax.figure.dpi
        title = f"{contact.name} at {contact.joint}, {two_digits(enlarged)}×"
        ax.set_title(fitted(title, inches, 8.0), fontsize=8, pad=3, color=CLEARANCE)
        length = nice_below(2.6 * contact.size)
        left, low = (CORNER * 2 - 1) * REACH, (0.02 + CORNER * 2 - 1) * REACH
        right = left + length / contact.size
        ax.plot([left, left, left, right, right, right],
                [low + 0.35, low - 0.05, low, low, low - 0.05, low + 0.35],
                color=BLACK, linewidth=1.0)  # fmt: skip
        ax.text(left, low + 0.6, scale_for(10 * length, "m").text(length), fontsize=8)

    def show(self, index: int) -> None:
        """Put everything where it is at one sample."""
        x, y = self._contact.offset[index]
        self._pin.set_center((x, y))
        self._link.set_data([0.0, x], [0.0, y])
        self._dots.set_data([0.0, x], [0.0, y])
        self._show_force(index, x, y)
        if (clock := self._clock) is not None:
            time = moment(clock.time[index], decimals(abs(clock.step)))
            self._moment.set_text(f"{clock.pace}\n{time}")

    def _show_force(self, index: int, x: float, y: float) -> None:
        """The push of the pin at its hole; a pull, which no real pin has, points inwards."""
        contact = self._contact
        if contact.force is None:
            return
        force = float(contact.force[index])
        distance = float(np.hypot(x, y))
        drawn = np.isfinite(force) and self._full > 0 and distance > 0
        along = np.array([x, y]) / distance if drawn else np.zeros(2)
        length = LONGEST * float(np.clip(force / self._full, -1.0, 1.0)) if drawn else 0.0
        self._arrow.set_xy(HOLE * along + arrow(along, length))
        pull = force < 0
        self._arrow.set_color(BLACK if pull else LOAD)
        self._text.set_color(BLACK if pull else LOAD)
        scale = scale_for(abs(force), "N")
        value = f"{force * scale.factor:.3g}".replace("-", "−")
        self._text.set_text(("no contact\n" if pull else "") + f"{value} {scale.units}")


def full_length(force: Array) -> float:
    """The force whose arrow is longest: the largest, if it is no rare exception."""
    sizes = np.abs(force[np.isfinite(force)])
    if not len(sizes):
        return 0.0
    return float(min(sizes.max(), EXCEPTION * np.quantile(sizes, 0.75)) or sizes.max())


def arrow(along: Array, length: float) -> Array:
    """Corners of an arrow from the origin, shape (7, 2); it points back if its length is < 0."""
    head = np.sign(length) * min(1.1, 0.7 * abs(length))
    wide = SLENDER * abs(head)
    shaft = min(SHAFT, 0.4 * wide)
    across = np.array([-along[1], along[0]])
    neck = length - head
    corners = [(0.0, shaft), (neck, shaft), (neck, wide), (length, 0.0)]
    corners += [(reach, -aside) for reach, aside in reversed(corners[:3])]
    return np.array([reach * along + aside * across for reach, aside in corners])


def nice_below(value: float) -> float:
    """The largest of 1, 2 or 5 times a power of ten that is not above a value."""
    power = 10.0 ** np.floor(np.log10(value))
    steps = np.array([1.0, 2.0, 5.0]) * power
    return float(steps[steps <= value * (1 + 1e-9)].max(initial=power))


def two_digits(value: float) -> str:
    """A number rounded to two significant digits, without exponent."""
    return f"{float(f'{value:.1e}'):.12g}"


def decimals(step: float) -> int:
    """Decimals of a time in seconds that tell frames apart."""
    return int(np.clip(-np.floor(np.log10(step) + 1e-9), 0, 9))


def moment(time: float, digits: int) -> str:
    """A time in seconds as pictures write it."""
    return f"t = {time:.{digits}f} s".replace("-", "−")
