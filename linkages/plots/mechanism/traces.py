"""Traces of the moving joints, with the mechanism where it starts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.mechanism.bodies import clearance_ends
from linkages.plots.mechanism.drawing import under
from linkages.plots.mechanism.inked import Inked, points_per_unit
from linkages.plots.mechanism.labels import Labels
from linkages.plots.mechanism.samples import pose_at
from linkages.plots.mechanism.view import Box, frame, picture, pixels
from linkages.plots.style import line_style, styled

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

MARGIN = 0.3  # inches
STILL = 1e-9  # of the picture's size: what moves less is at rest
COUPLER, LED = 1.8, 0.9  # points
SAME = 0.01  # of the picture's size: traces no farther apart look the same


@styled
def figure(data: xr.Dataset, mechanism: Mechanism) -> Figure | None:
    """Traces over the run; None for data without joint positions."""
    if not pose_at(data, mechanism, 0).positions:
        return None
    result, ax = picture(Box.around(np.asarray(data["joint_position"], dtype=float)), MARGIN)
    draw(ax, data, mechanism)
    return result


def moving_joints(data: xr.Dataset, mechanism: Mechanism) -> dict[str, Array]:
    """Joints that move and their places, shape (time, 2), in metres.

    Points beside a pin with clearance are left out where their trace looks like the pin's, and
    places on the axes of blocks that have joints beside them.
    """
    array = data["joint_position"].transpose("time", "joint", "axis")
    places = np.asarray(array, dtype=float)
    size = Box.around(places).extent
    names = [str(name) for name in array["joint"].values]
    paths = {name: places[:, i] for i, name in enumerate(names)}
    hidden = {
        displaced
        for displaced, joint in clearance_ends(mechanism).items()
        if displaced in paths
        and joint in paths
        and not (np.abs(paths[displaced] - paths[joint]) > SAME * size).any()
    }
    hidden.update(mechanism.feet)
    return {
        name: path
        for name, path in paths.items()
        if name not in hidden and Box.around(path).extent > STILL * size
    }


def led_joints(mechanism: Mechanism) -> set[str]:
    """Joints that a pin or a guide on the ground leads along an arc or a line.

    All others draw coupler curves.
    """
    ground = set(mechanism.ground)
    return {
        joint
        for body in mechanism.bodies.values()
        if ground & set(body.points) or (body.guide is not None and body.guide.body is None)
        for joint in body.points
    }


def draw(ax: Axes, data: xr.Dataset, mechanism: Mechanism) -> Axes:
    """Draw the trace of each moving joint over the mechanism at the first sample.

    Coupler curves are thicker than the arcs and lines that the ground leads joints along.

    Parameters
    ----------
    ax
        Where to draw; its limits are set.
    data
        With ``joint_position`` and at least one sample.
    mechanism
        Whose motion it is.
    """
    box = Box.around(np.asarray(data["joint_position"], dtype=float))
    scale = frame(ax, box, mechanism, MARGIN)
    pose = pose_at(data, mechanism, 0)
    shapes = under(pose, points_per_unit(ax) * scale.factor)
    labels = Labels(ax)
    Inked(ax, shapes, pose.scaled(scale.factor), pale=True).avoided(labels)
    paths = {n: path * scale.factor for n, path in moving_joints(data, mechanism).items()}
    names, led = list(paths), led_joints(mechanism)
    for index, path in enumerate(paths.values()):
        width = LED if names[index] in led else COUPLER
        ax.plot(*path.T, color=line_style(index)["color"], linewidth=width)
        labels.avoid(pixels(ax, path[:: max(1, len(path) // 1000)]))
    for index, (name, path) in enumerate(paths.items()):
        if np.isfinite(path).all(axis=1).any():
            colour = line_style(index)["color"]
            finite = path[np.isfinite(path).all(axis=1)]
            labels.beside_curve(name, finite, color=colour, weight="bold")
    return ax
