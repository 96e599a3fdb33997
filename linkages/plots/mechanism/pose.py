"""Poses of a mechanism from the positions of its joints."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.terms import UNSEEN, Parameter
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.mechanism.plane_view import Positions

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]
Place = tuple[float, float]

LEAST = 0.14  # of the picture's size: how far a slot reaches beyond its pin if nothing says more


class SliderAxis(NamedTuple):
    """A slider's axis: where displacements count from, its direction, where its pin is on it."""

    origin: Array
    angle: float
    reach: float

    def at(self, reach: float) -> Array:
        """The point so far from the origin."""
        return self.origin + reach * np.array([np.cos(self.angle), np.sin(self.angle)])


@dataclass(frozen=True)
class Pose:
    """A mechanism in one position."""

    mechanism: Mechanism  # whose position it is
    positions: Positions  # joint → (x, y); joints may be missing
    # Bar → its angle in radians; only needed for bodies that show a single joint
    angles: Mapping[str, float] = field(default_factory=dict)
    # Slider → least and largest displacement that a picture allows for, in metres
    travel: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    unit: float = 1.0  # units of `positions` per metre
    size: float | None = None  # of the picture, in metres; what the joints span if not given

    def scaled(self, factor: float) -> Pose:
        """The same in other units."""
        positions = {name: (x * factor, y * factor) for name, (x, y) in self.positions.items()}
        unit = self.unit * factor
        return replace(self, positions=positions, unit=unit)

    def shown(self, name: str) -> dict[str, Place]:
        """The joints of a body whose places are known, in the order of the definition."""
        points = self.mechanism.bodies[name].points
        return {joint: self.positions[joint] for joint in points if joint in self.positions}

    def angle(self, name: str | None) -> float | None:
        """How a body's own frame is turned; None if that cannot be told."""
        if name is None:
            return 0.0
        body = self.mechanism.bodies[name]
        if body.guide is not None:
            carrier = self.angle(body.guide.body)
            return None if carrier is None else carrier + body.guide.angle.value
        if apart := self.apart(name):
            first, second, own = apart
            return _direction(np.subtract(self.positions[second], self.positions[first])) - own
        known = np.isfinite(self.angles.get(name, np.nan))
        return float(self.angles[name]) if known else self._angle_of_others(name)

    def apart(self, name: str) -> tuple[str, str, float] | None:
        """The two joints of a body that are farthest apart, and their direction in its frame."""
        points = self.mechanism.bodies[name].points
        own = {joint: _numbers(points[joint]) for joint in self.shown(name)}
        apart = [(float(np.hypot(*(own[b] - own[a]))), a, b) for a, b in combinations(own, 2)]
        if not apart or max(apart)[0] == 0.0:
            return None
        _, first, second = max(apart)
        return first, second, _direction(own[second] - own[first])

    def _angle_of_others(self, name: str) -> float | None:
        """From a weld or a gear that says how a body follows others."""
        for relation in self.mechanism.relations:
            parts = [(self.angles.get(other), ratio.value) for other, ratio in relation.parts]
            if relation.body == name and all(angle is not None for angle, _ in parts):
                turned = [ratio * angle for angle, ratio in parts if angle is not None]
                return float(relation.offset.value + sum(turned))
        return None

    def place(self, name: str | None, point: tuple[Parameter, Parameter]) -> Array | None:
        """Where a point of a body's own frame is; None if that cannot be told."""
        own = _numbers(point) * self.unit
        if name is None:
            return own
        shown, angle = self.shown(name), self.angle(name)
        if not shown or angle is None:
            return None
        joint, place = next(iter(shown.items()))
        from_joint = own - _numbers(self.mechanism.bodies[name].points[joint]) * self.unit
        return np.asarray(place) + _turned(from_joint, angle)

    def axis(self, name: str) -> SliderAxis | None:
        """The axis of a slider; None if it cannot be told, or the slider's pin is not known."""
        body = self.mechanism.bodies[name]
        if body.guide is None or body.kind in UNSEEN:
            return None
        pin, angle = next(iter(body.points)), self.angle(name)
        if pin not in self.positions or angle is None:
            return None
        assert not isinstance(body.guide.origin, str)
        origin = self.place(body.guide.body, body.guide.origin)
        if origin is None:
            return None
        way = np.subtract(self.positions[pin], origin)
        return SliderAxis(origin, angle, float(way @ (np.cos(angle), np.sin(angle))))

    def slot(self, name: str) -> Array | None:
        """Both ends of the slot that a slider moves in, shape (2, 2)."""
        axis = self.axis(name)
        if axis is None:
            return None
        beyond = 0.3 * LEAST * self.extent
        if name in self.travel:
            low, high = (self.unit * value for value in self.travel[name])
        else:
            low, high = axis.reach - LEAST * self.extent, axis.reach + LEAST * self.extent
        ends = (min(low, axis.reach) - beyond, max(high, axis.reach) + beyond)
        return np.array([axis.at(end) for end in ends])

    @cached_property
    def meeting(self) -> Counter[str]:
        """Joint → how many bodies have it."""
        return Counter(joint for body in self.mechanism.bodies.values() for joint in body.points)

    @cached_property
    def extent(self) -> float:
        """The larger of width and height of the picture."""
        if self.size is not None:
            return self.size * self.unit
        places = np.array(list(self.positions.values()) or [(0.0, 0.0)], dtype=float)
        return float(np.ptp(places, axis=0).max()) or self.unit


def along_carrier(pose: Pose, name: str) -> tuple[float, float] | None:
    """Between which displacements the carrier of a slider has its axis as its own line.

    None for a carrier that is no bar, or a bar that the axis does not run along: it has a slot.
    """
    guide = pose.mechanism.bodies[name].guide
    axis = pose.axis(name)
    if guide is None or guide.body is None or axis is None:
        return None
    if not pose.mechanism.bodies[guide.body].rotates:
        return None
    places = np.array(list(pose.shown(guide.body).values()))
    if len(places) < 2:
        return None
    along = np.array([np.cos(axis.angle), np.sin(axis.angle)])
    ways = places - axis.origin
    across = ways @ (-along[1], along[0])
    if np.abs(across).max() > 1e-3 * float(np.ptp(places, axis=0).max()):
        return None
    reach = ways @ along
    return float(reach.min()), float(reach.max())


def _numbers(pair: tuple[Parameter, Parameter]) -> Array:
    return np.array([pair[0].value, pair[1].value])


def _direction(vector: Array) -> float:
    return float(np.arctan2(vector[1], vector[0]))


def _turned(vector: Array, angle: float) -> Array:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([cos * vector[0] - sin * vector[1], sin * vector[0] + cos * vector[1]])


class Poses:
    """Positions at all samples, in metres, as far as the data tell them.

    `data`, `mechanism`: a motion, and what moves.
    `size`: of the picture in metres, the same for all of them; what joints span at each if not
    given.
    `places`: of all joints, shape (time, joints, 2).
    """

    def __init__(self, data: xr.Dataset, mechanism: Mechanism, size: float | None = None) -> None:
        self.mechanism, self._size = mechanism, size
        self._joints, self.places = _named(data, "joint_position", "joint", "axis")
        self._bars, self._angles = _named(data, "bar_angle", "bar")
        self._travel = _travel(data)

    def at(self, index: int) -> Pose:
        """The position at one sample."""
        there = len(self.places) > 0
        positions = {
            name: (float(x), float(y))
            for name, (x, y) in zip(self._joints, self.places[index] if there else (), strict=there)
            if np.isfinite((x, y)).all()
        }
        angles = dict(zip(self._bars, self._angles[index].tolist() if there else (), strict=there))
        return Pose(self.mechanism, positions, angles, self._travel, size=self._size)


def pose_at(data: xr.Dataset, mechanism: Mechanism, index: int) -> Pose:
    """The position of a mechanism at one sample."""
    return Poses(data, mechanism).at(index)


def _named(data: xr.Dataset, variable: str, *dims: str) -> tuple[list[str], Array]:
    """Names along the first of some dimensions, and values over time; none where there are none."""
    if variable not in data:
        return [], np.empty((data.sizes["time"], 0, *(2 for _ in dims[1:])))
    array = data[variable].transpose("time", *dims)
    return [str(name) for name in array[dims[0]].values], np.asarray(array, dtype=float)


def _travel(data: xr.Dataset) -> dict[str, tuple[float, float]]:
    """Slider → its least and largest displacement in metres."""
    names, values = _named(data, "slider_position", "slider")
    finite = {
        name: column[np.isfinite(column)] for name, column in zip(names, values.T, strict=True)
    }
    return {name: (float(v.min()), float(v.max())) for name, v in finite.items() if v.size}
