"""Drawing of a mechanism as the page updates it at every frame."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.films.stage import framed
from linkages.plots.mechanism.drawing import shapes_of
from linkages.plots.mechanism.guide_symbols import travel_of
from linkages.plots.mechanism.load_symbols import draw_stops
from linkages.plots.mechanism.placing import angle_of, placed
from linkages.plots.mechanism.pose import Pose, SliderAxis
from linkages.plots.mechanism.shapes import (
    Anchor,
    Direction,
    Disc,
    Shape,
    Strokes,
    Weights,
    as_json,
)

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

NEAR = 1e-9
"""Of the picture: what round-off may part."""


def anchored(
    shapes: Iterable[Shape], pose: Pose
) -> tuple[list[Shape], dict[str, dict[str, str | float]]]:
    """The same drawing, in which what lies on a slider's axis counts from places on that axis.

    Between both ends of the travel a shape follows these; stops keep their displacement. What lies
    nowhere else than on a body stays as it is.

    Returns
    -------
    The shapes, and the places on axes that they name beside joints: ``slider``, and ``at`` which
    displacement, ``low`` and ``high`` for the ends of its travel.
    """
    axes = {name: axis for name in pose.mechanism.bodies if (axis := _axis(pose, name)) is not None}
    stops, places = set(draw_stops(pose)), dict[str, dict[str, str | float]]()
    return [_shape(one, _Axes(pose, axes, places, one in stops)) for one in shapes], places


def _axis(pose: Pose, name: str) -> SliderAxis | None:
    """The axis of a slider whose travel is known."""
    return pose.axis(name) if pose.mechanism.bodies[name].kind == "slider" else None


def _shape(shape: Shape, axes: _Axes) -> Shape:
    direction = axes.direction(shape.name, shape.direction)
    match shape:
        case Strokes():
            strokes = tuple(
                tuple(axes.anchor(one, shape.direction) for one in stroke)
                for stroke in shape.strokes
            )
            return replace(shape, strokes=strokes, direction=direction)
        case Disc():
            return replace(shape, centre=axes.anchor(shape.centre, shape.direction))
        case _:
            return shape


class _Axes:
    """The axes of a position.

    Parameters
    ----------
    pose, axes
        The position, and the axes in it.
    places
        Gets the places that anchors name.
    keeping
        Whether displacements stay what they are.
    """

    def __init__(
        self,
        pose: Pose,
        axes: dict[str, SliderAxis],
        places: dict[str, dict[str, str | float]],
        keeping: bool,
    ) -> None:
        self._pose, self._axes, self._places, self._keeping = pose, axes, places, keeping

    def direction(self, name: str, own: Direction) -> Direction:
        """A direction by the body that has it: the slider of that name, or what carries it."""
        body = self._pose.mechanism.bodies.get(name)
        if name in self._axes and body is not None:
            turned = angle_of(self._pose, own) - self._axes[name].angle
            if abs(np.sin(turned)) < NEAR and np.cos(turned) > 0.0:
                return Direction(body=name)
        return own

    def anchor(self, own: Anchor, direction: Direction) -> Anchor:
        """An anchor from places on an axis, if it is on one."""
        if own.metres == (0.0, 0.0):
            return own
        for name, axis in self._axes.items():
            found = self._on_axis(name, axis, own, direction)
            if found is not None:
                return found
        return own

    def _on_axis(
        self, name: str, axis: SliderAxis, own: Anchor, direction: Direction
    ) -> Anchor | None:
        guide = self._pose.mechanism.bodies[name].guide
        assert guide is not None
        carrier = None if guide.body is None else next(iter(self._pose.shown(guide.body)), None)
        pin = next(iter(self._pose.mechanism.bodies[name].points))
        kept = {joint: weight for joint, weight in own.joints if joint == pin and joint != carrier}
        if {joint for joint, _ in own.joints} - {pin, carrier}:
            return None
        share = 1.0 - sum(kept.values())  # of a place that goes along with the carrier
        if guide.body is not None and carrier is None:
            return None
        (here,) = placed(self._pose, [replace(own, points=(0.0, 0.0))], direction, 0.0)
        (beside,) = placed(self._pose, [Anchor(tuple(kept.items()))], direction, 0.0)
        rod = abs(share) < NEAR  # what is fixed to the slider itself
        place = here if rod else (here - beside) / share
        way = place - (beside if rod else axis.origin)
        along = np.array([np.cos(axis.angle), np.sin(axis.angle)])
        if abs(way @ (-along[1], along[0])) > NEAR * self._pose.extent:
            return None
        if rod:
            ends = self._stroke(name, axis, float(way @ along))
            if not ends:
                return None
            return replace(own, joints=(*own.joints, *ends), metres=(0.0, 0.0))
        joint = self._joint(guide.body, place)
        weights = {joint: 1.0} if joint else self._between(name, axis, float(way @ along))
        total = {**kept, **{key: share * weight for key, weight in weights.items()}}
        return Anchor(tuple(total.items()), points=own.points)

    def _joint(self, carrier: str | None, place: Array) -> str | None:
        """The joint of a carrier that is there."""
        shown = {} if carrier is None else self._pose.shown(carrier)
        near = NEAR * self._pose.extent
        return next((j for j, at in shown.items() if np.hypot(*(place - at)) < near), None)

    def _between(self, name: str, axis: SliderAxis, reach: float) -> dict[str, float]:
        """Weights of places on an axis."""
        low, high = travel_of(self._pose, name, axis)
        if self._keeping or high - low < NEAR * self._pose.extent:
            return {self._place(name, reach): 1.0}
        share = (reach - low) / (high - low)
        return {self._place(name, "low"): 1.0 - share, self._place(name, "high"): share}

    def _stroke(self, name: str, axis: SliderAxis, length: float) -> Weights:
        """Weights of the ends of a travel that give a share of it; none where there is none."""
        low, high = travel_of(self._pose, name, axis)
        if high - low < NEAR * self._pose.extent:
            return ()
        share = length / (high - low)
        return (self._place(name, "low"), -share), (self._place(name, "high"), share)

    def _place(self, slider: str, at: str | float) -> str:
        name = f"@{slider}.{at}"
        self._places[name] = {"slider": slider, "at": at}
        return name


LOAD = "load"
"""Role of arrows of loads: pages draw those as long as the loads are at the time."""


def drawn(data: xr.Dataset, mechanism: Mechanism) -> dict[str, Any]:
    """The drawing of a mechanism that moves.

    Returns
    -------
    ``shapes`` in the order of drawing, in metres and typographic points, the ``places`` on axes
    that they name beside joints, and the ``box`` that they sweep: left, low, right, high in metres.
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
