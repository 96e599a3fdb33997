"""A mechanism in motion: its poses at the samples of a solution, and what of a drawing moves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.mechanism.bodies import draw_bodies
from linkages.plots.mechanism.drawing import draw_bearings, draw_joints, reach
from linkages.plots.mechanism.gears import draw_cams, draw_gears, draw_racks, draw_welds, note_gears
from linkages.plots.mechanism.labels import Labels
from linkages.plots.mechanism.loads import draw_masses, draw_springs, draw_torsional
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.samples import Poses
from linkages.plots.mechanism.sliders import draw_guide_springs, draw_guides, draw_sliders
from linkages.plots.mechanism.view import Box

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

LOOKS = 24
"""Positions from which the size of a picture is told, besides the places of all joints."""


def framed(data: xr.Dataset, mechanism: Mechanism) -> tuple[Poses, Box]:
    """Positions at all samples in pictures of one size, and the part of the plane that they sweep.

    Raises
    ------
    ValueError
        For data that do not say where joints are.
    """
    if "joint_position" not in data or not data.sizes["time"]:
        raise ValueError("nothing to animate: the data have no samples of joint_position")
    places = np.asarray(data["joint_position"], dtype=float).reshape(-1, 2)
    poses = Poses(data, mechanism, Box.around(places).extent or None)
    looks = np.unique(np.linspace(0, data.sizes["time"] - 1, LOOKS).round().astype(int))
    boxes = [reach(poses.at(index)) for index in looks]
    corners = [corner for box in boxes for corner in (box.low, box.high)]
    return poses, Box.around(np.vstack([places, *corners]))


class Unlabelled(Labels):
    """What takes the place of labels in a drawing without any: it keeps no account of pixels."""

    def avoid(self, covered: Array) -> None:
        """Nothing to keep clear of."""

    def avoid_line(self, points: ArrayLike) -> None:
        """Nothing to keep clear of."""


def draw_still(ax: Axes, first: Pose, labels: Labels) -> None:
    """Draw what stays where it is: bearings, guides on the ground, notes."""
    draw_guides(ax, first, labels)
    draw_bearings(ax, first, labels)
    note_gears(ax, first)


def draw_moving(ax: Axes, pose: Pose, first: Pose) -> None:
    """Draw everything that moves, without names.

    Parameters
    ----------
    ax
        Where to draw.
    pose, first
        The present position and the first one, in the units of the axes.
    """
    labels = Unlabelled(ax)
    draw_bodies(ax, pose)
    draw_gears(ax, pose, labels)
    draw_racks(ax, pose, labels)
    draw_cams(ax, pose, labels)
    draw_springs(ax, pose, labels)
    draw_sliders(ax, pose, labels, rails=False)
    draw_welds(ax, pose, labels)
    draw_masses(ax, pose, labels)
    draw_joints(ax, pose, labels)
    draw_torsional(ax, pose, labels, first)
    draw_guide_springs(ax, pose, labels, first)
