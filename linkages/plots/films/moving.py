"""A mechanism in motion: its poses at the samples of a solution, and what of a drawing moves."""

from __future__ import annotations

from itertools import takewhile
from typing import TYPE_CHECKING

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.mechanism import drawing
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.samples import Poses
from linkages.plots.mechanism.shapes import Shape, stands_still
from linkages.plots.mechanism.view import Box

if TYPE_CHECKING:
    import xarray as xr


def framed(data: xr.Dataset, mechanism: Mechanism) -> tuple[Poses, Box]:
    """Positions at all samples in pictures of one size, and the part of the plane that they sweep.

    Raises
    ------
    ValueError
        For data that do not say where joints are.
    """
    if "joint_position" not in data or not data.sizes["time"]:
        raise ValueError("nothing to animate: the data have no samples of joint_position")
    return drawing.framed(data, mechanism)


def parts(first: Pose, scale: float) -> tuple[list[Shape], list[Shape]]:
    """Shapes of a drawing that stay where they are, and those that move or lie above one that does.

    Parameters
    ----------
    first
        The first position, in metres.
    scale
        Points per metre of the picture.
    """
    shapes, ground = drawing.under(first, scale), first.mechanism.ground
    still = list(takewhile(lambda shape: stands_still(shape, ground), shapes))
    return still, shapes[len(still) :]
