"""A drawing of a mechanism where it starts, without a motion."""

from __future__ import annotations

from matplotlib.figure import Figure

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.mechanism.drawing import draw_pose, reach
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.view import Positions, picture
from linkages.plots.style import styled


@styled
def position_figure(mechanism: Mechanism, positions: Positions) -> Figure:
    """A labelled drawing.

    Parameters
    ----------
    mechanism
        What to draw.
    positions
        Joint → (x, y) in metres.
    """
    pose = Pose(mechanism, positions)
    result, ax = picture(reach(pose))
    draw_pose(ax, pose)
    return result
