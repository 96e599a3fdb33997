"""The way of a block in its guide: its two free coordinates, and where corners touch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from linkages.components.contributed.contacts import Contact, CornerAtWall
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.prefixes import scale_for
from linkages.plots.style import BLACK

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

ROOM = 1.12
"""Half the picture over the largest offset and the largest angle."""


def corners_of(mechanism: Mechanism) -> dict[str, tuple[str, ...]]:
    """Clearance of a guide → its corners, as results name them."""
    found: dict[str, tuple[str, ...]] = {}
    for contact in mechanism.contacts:
        if isinstance(contact.geometry, CornerAtWall):
            name = contact.geometry.play.name
            found[name] = (*found.get(name, ()), contact.name)
    return found


def free_offset(contact: Contact, angle: Array) -> Array:
    """Largest offset in metres at which a block at some angles in its guide touches no wall."""
    corner = contact.geometry
    assert isinstance(corner, CornerAtWall)
    length, height = corner.length.value, corner.height.value
    reach = 0.5 * (length * np.abs(np.sin(angle)) + height * np.cos(angle))
    return np.asarray(corner.size.value + 0.5 * height - reach)


def draw_path(ax: Axes, data: xr.Dataset, contact: Contact, corners: Sequence[str]) -> Array:
    """Draw the border within which no corner touches; return the way in units of the axes.

    Parameters
    ----------
    ax
        Where to draw.
    data
        `clearance_offset`.
    contact
        One of the corners.
    corners
        Their names in the data.

    Returns
    -------
    Shape (time, 2): degrees, and offsets of the middle of the block.
    """
    size, corner = contact.size.value, contact.geometry
    assert isinstance(corner, CornerAtWall)
    across = data["clearance_offset"].sel(clearance=list(corners), axis="y")
    rear, front, _, opposite = np.asarray(across.transpose("clearance", "time"), dtype=float)
    angle, offset = np.arcsin((front - rear) / corner.length.value), 0.5 * (rear + opposite)
    scale = scale_for(size, "m")
    widest = 2.0 * size / corner.length.value
    while free_offset(contact, np.array(widest)) > 0.0:
        widest *= 1.05
    border = np.linspace(-widest, widest, 801)
    border = border[free_offset(contact, border) >= 0.0]
    limit = free_offset(contact, border) * scale.factor
    degrees = np.rad2deg(border)
    for sign in (-1.0, 1.0):
        ax.plot(degrees, sign * limit, color=BLACK, linewidth=1.0, zorder=3)
    half = np.rad2deg(max(widest, float(np.abs(angle).max()))) * ROOM
    reach = scale.factor * max(size, float(np.abs(offset).max())) * ROOM
    ax.set(xlim=(-half, half), ylim=(-reach, reach), aspect="auto")
    ax.set_xlabel("angle in the guide [°]")
    ax.set_ylabel(scale.label("offset"))
    return np.stack([np.rad2deg(angle), scale.factor * offset], axis=1)
