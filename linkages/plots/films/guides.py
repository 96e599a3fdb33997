"""A block between the rails of its guide, enlarged across it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from linkages.components.contributed.contacts import CORNERS, CornerAtWall
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.films.journals import Foot
from linkages.plots.style import BLACK, CLEARANCE, PALE, PASSIVE

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

# In plays of one side, which alone are to scale, and across the guide only.
HALF, HEIGHT = 4.0, 1.7  # half length and half height of the block
RAIL, DEPTH, BEYOND = HEIGHT + 1.0, 0.6, 6.4  # from the axis; thickness; half length


class Block(NamedTuple):
    """A block with room in its guide over the samples.

    Attributes
    ----------
    name, joint
        Of the clearance, and of the joint in the middle of the block.
    size
        Distance from each wall in metres, of a block in the middle.
    angle
        Of the guide in the picture, in radians; 0 for one that turns.
    offset
        Across the guide, of corners in the order of `CORNERS`, in plays, shape (time, 4).
    forces
        On their walls, pressing positive, in newtons, shape (time, 4); None if the data do not
        have it.
    """

    name: str
    joint: str
    size: float
    angle: float
    offset: Array
    forces: Array | None


def blocks(data: xr.Dataset, mechanism: Mechanism) -> list[Block]:
    """All blocks with room in their guides whose corners are in the data."""
    corners: dict[str, list[tuple[str, CornerAtWall]]] = {}
    for contact in mechanism.contacts:
        if isinstance(own := contact.geometry, CornerAtWall):
            corners.setdefault(own.play.name, []).append((contact.name, own))
    found = []
    for name, all_of_it in corners.items() if "clearance_offset" in data else ():
        names, corner = [own for own, _ in all_of_it], all_of_it[0][1]
        guide = mechanism.bodies[corner.play.slider].guide
        assert guide is not None
        turning = guide.body is not None and mechanism.bodies[guide.body].rotates
        size, force = corner.size.value, data.get("clearance_force")
        across = data["clearance_offset"].transpose("time", "clearance", "axis")[..., 1]
        joint = next(iter(mechanism.bodies[corner.play.block].points))
        found.append(
            Block(
                name, joint, size,
                0.0 if turning else guide.angle.value,
                np.asarray(across.sel(clearance=names), dtype=float) / size,
                None if force is None else np.asarray(force.sel(clearance=names), dtype=float),
            )
        )  # fmt: skip
    return found


class BlockPicture:
    """The rails rest, the block moves and turns between them.

    Parameters
    ----------
    ax
        Where to draw, in plays.
    block
        What to draw.
    """

    def __init__(self, ax: Axes, block: Block) -> None:
        self._block = block
        cos, sin = np.cos(block.angle), np.sin(block.angle)
        self._turn = np.array([[cos, sin], [-sin, cos]])
        for side in (-1.0, 1.0):
            inner, outer = side * RAIL, side * (RAIL + DEPTH)
            rail = [(-BEYOND, inner), (BEYOND, inner), (BEYOND, outer), (-BEYOND, outer)]
            look: dict[str, Any] = {"facecolor": PALE, "edgecolor": PASSIVE, "linewidth": 0.9}
            ax.add_patch(Polygon(np.array(rail) @ self._turn, zorder=1, **look))
            edge = np.array([(-BEYOND, inner), (BEYOND, inner)]) @ self._turn
            ax.plot(*edge.T, color=BLACK, linewidth=1.0, zorder=2)
        axis = np.array([(-BEYOND, 0.0), (BEYOND, 0.0)]) @ self._turn
        ax.plot(*axis.T, color=PASSIVE, linewidth=0.7, dashes=(9, 2, 1.5, 2), zorder=2)
        self._body = Polygon(
            np.zeros((4, 2)), facecolor="white", edgecolor=BLACK, linewidth=1.0, zorder=4
        )
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
