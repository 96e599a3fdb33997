"""A journal in its bearing, enlarged."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.mechanism.bodies import clearance_ends
from linkages.plots.style import BLACK, CLEARANCE, PALE, PASSIVE

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]
Foot = tuple[Array, Array]
"""Where a force is drawn, and the direction in which it presses."""

# In radial clearances, which alone are to scale: the true radius of a pin is not in the file.
PIN, HOLE, WALL = 2.2, 3.2, 3.9


class Journal(NamedTuple):
    """A clearance over the samples.

    Attributes
    ----------
    name, joint
        Of the clearance, and of the joint that has it.
    size
        Radial clearance in metres.
    offset
        From the middle of the hole to that of the pin, in radial clearances, shape (time, 2).
    forces
        Pressing positive, in newtons, shape (time, 1); None if the data do not have it.
    """

    name: str
    joint: str
    size: float
    offset: Array
    forces: Array | None


def journals(data: xr.Dataset, mechanism: Mechanism) -> list[Journal]:
    """All clearances whose pin and hole are in the data."""
    found = []
    for hole, joint in clearance_ends(mechanism).items():
        if not {hole, joint} <= {str(name) for name in data["joint"].values}:
            continue
        places = data["joint_position"].transpose("time", "joint", "axis")
        way = np.asarray(places.sel(joint=joint)) - np.asarray(places.sel(joint=hole))
        name = hole.removeprefix(f"{joint}.")
        force = data.get("clearance_force")
        values = None if force is None else np.asarray(force.sel(clearance=[name]), dtype=float)
        size = next(own.size for own in mechanism.clearances if own.name == name)
        found.append(Journal(name, joint, size, way / size, values))
    return found


class JournalPicture:
    """The hole rests, the pin moves in it.

    Parameters
    ----------
    ax
        Where to draw, in radial clearances.
    journal
        What to draw.
    """

    def __init__(self, ax: Axes, journal: Journal) -> None:
        self._journal = journal
        wall = Circle((0, 0), WALL, facecolor=PALE, edgecolor=PASSIVE, linewidth=0.9, zorder=1)
        ax.add_patch(wall)
        ax.add_patch(Circle((0, 0), HOLE, facecolor="white", edgecolor=BLACK, zorder=2))
        style: dict[str, Any] = {"zorder": 4, "linewidth": 1.0, "edgecolor": BLACK}
        self._pin = Circle((0, 0), PIN, facecolor="white", **style)
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
