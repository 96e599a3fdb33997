"""The drawing of a mechanism as a page places it again at every frame."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.films.moving import framed
from linkages.plots.mechanism.drawing import shapes_of
from linkages.plots.mechanism.shapes import as_json
from linkages.viewer.anchored import anchored

if TYPE_CHECKING:
    import xarray as xr

LOAD = "load"
"""Role of arrows of loads: pages draw those as long as the loads are at the time."""


def drawn(data: xr.Dataset, mechanism: Mechanism) -> dict[str, Any]:
    """The drawing of a mechanism that moves.

    Parameters
    ----------
    data, mechanism
        A motion, whose whole travel guides show, and what moves.

    Returns
    -------
    ``shapes`` in the order of drawing, in metres and typographic points, the ``places`` on axes
    that they name beside joints, and the ``box`` that they sweep: left, low, right, high in metres.

    Raises
    ------
    ValueError
        For data that do not say where joints are.
    """
    poses, box = framed(data, mechanism)
    shapes = [shape for shape in shapes_of(poses.at(0)) if shape.look.role != LOAD]
    places: dict[str, Any] = {}
    if "slider_position" in data:
        shapes, places = anchored(shapes, poses.at(0))
    return {
        "shapes": as_json(shapes),
        "places": places,
        "box": [*map(float, box.low), *map(float, box.high)],
    }
