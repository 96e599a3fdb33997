"""A motion as the page stores it: frames, series, and the drawing of the mechanism."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError
from linkages.exports.writers.source_code import javascript_module
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.plots.films.stage import framed
from linkages.plots.mechanism.drawing import shapes_of
from linkages.plots.mechanism.guide_symbols import DrawnSlider
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
from linkages.solution.run_options import samples_per_swing
from linkages.solution.series import REACTIONS, STATE, TIME, available, data_series, requested
from linkages.solution.simulate import simulate
from linkages.solution.solution import Solution, labelled

if TYPE_CHECKING:
    import xarray as xr


Array = NDArray[np.float64]

BESIDE = (
    "joint_position", "bar_angle", "slider_position", "clearance_force", "clearance_angle",
    "clearance_offset", "clearance_state", "joint_reaction", "pin_reaction", "load_force",
    "load_torque", "spring_force", "torsional_spring_torque", "transmission_angle",
    "kinetic_energy", "potential_energy", "shaking_force", "shaking_moment",
)  # fmt: skip
"""Outputs that a page has besides the usual ones: what it draws, and what people ask for."""

PLAYED = "offset_position", "offset_rate", "tilt_angle", "tilt_speed"
"""Outputs that are coordinates of guides with play."""

PER_SWING = 10
"""Frames with which a swing can be followed."""

FEWEST, MOST = 600, 3000
NUMBERS = 156_000
"""All numbers of a page together, about: it stays at a few hundred kilobytes."""

ASIDE = 0.03
"""Of its range: what a series may do between two frames without its least and largest there."""

BANDS = 400
"""Stretches for which a page has the least and the largest value, at most: as many as pixels."""


COARSE = 5
"""Frames per swing below which a curve over another series would be invented."""

DETAIL = 2000
"""Samples of the last swings that a page has where its frames are coarse."""

MOST_SECTIONS = 2000
"""Points of a Poincaré section that a page has, at most: the last ones."""


def wanted(system: System, outputs: Iterable[str] | None = None) -> list[str]:
    """The outputs that a page shows: those asked for or the usual ones, and what it needs."""
    own = available(system)
    beside = [*BESIDE, *(PLAYED if system.mechanism.plays else ())]
    return list(
        dict.fromkeys([*requested(system, outputs), *(name for name in beside if name in own)])
    )


def dense(solution: Solution) -> xr.Dataset:
    """Data of a solution with all that a page shows, at samples that show every swing."""
    given = [str(name) for name in solution.data.data_vars]
    names = wanted(solution.system, given)
    known = {*given, *REACTIONS, STATE}
    shown = [name for name in names if name in known or not VARIABLES[name].whole]
    close = solution.closely
    result = labelled(solution.system, close.motion, {name: close.values(name) for name in shown})
    return result.assign_attrs(solution.data.attrs)


def chosen(data: xr.Dataset) -> NDArray[np.intp]:
    """Indices of the samples that become frames, the first and the last among them."""
    samples = data.sizes["time"]
    series = sum(int(np.prod(array.shape[1:])) for array in data.data_vars.values())
    moving = [a for name, a in data.data_vars.items() if VARIABLES[str(name)].coordinate]
    swing = samples_per_swing(np.asarray(array, dtype=float) for array in moving)
    needed = PER_SWING * samples / swing if np.isfinite(swing) else 0.0
    most = int(np.clip(NUMBERS / max(series, 1), FEWEST, MOST))
    count = min(samples, most, max(FEWEST, int(np.ceil(needed))))
    return np.unique(np.linspace(0, samples - 1, count).round().astype(np.intp))


def bounds(values: Array, frames: NDArray[np.intp]) -> tuple[int, Array, Array] | None:
    """Least and largest value of stretches of so many frames, which is returned first.

    None where frames alone show the series, as they do mostly: nothing between two of them is
    aside of both by more than `ASIDE` of the range.
    """
    if len(frames) == len(values) or not np.isfinite(values).all():
        return None
    low, high = _between(values, frames)
    first, second = values[frames[:-1]], values[frames[1:]]
    aside = np.maximum(np.minimum(first, second) - low, high - np.maximum(first, second))
    if aside.max() <= ASIDE * np.ptp(values):
        return None
    stretch = -(-len(frames) // BANDS)
    return stretch, *_between(values, frames[[*range(0, len(frames) - 1, stretch), -1]])


def _between(values: Array, ends: NDArray[np.intp]) -> tuple[Array, Array]:
    """Least and largest value from each sample to the next one, both included."""
    last = values[ends[1:]]
    low = np.minimum(np.minimum.reduceat(values, ends[:-1]), last)
    return low, np.maximum(np.maximum.reduceat(values, ends[:-1]), last)


Place = tuple[int, int]
"""Where an array begins among all numbers, and how many it has."""


class Packed:
    """Arrays one behind the other; `assets/unpack.js` reads their text."""

    def __init__(self) -> None:
        self._arrays: list[NDArray[np.float32]] = []
        self._count = 0

    def add(self, values: ArrayLike) -> Place:
        """Append an array, rounded to 32 bits; return its place."""
        with np.errstate(over="ignore"):  # what is beyond the range of 32 bits is infinite
            array = np.asarray(values, dtype=np.float64).ravel().astype(np.float32)
        self._arrays.append(array)
        place = (self._count, len(array))
        self._count += len(array)
        return place

    def add_exact(self, values: Sequence[float] | NDArray[np.float64]) -> tuple[Place, Place]:
        """Append an array as two: rounded, and what rounding took away."""
        exact = np.asarray(values, dtype=np.float64)
        rounded = exact.astype(np.float32)
        return self.add(rounded), self.add(exact - rounded)

    def text(self) -> str:
        """All of it, about half as long as plain base 64.

        Neighbours are alike, so what is compressed are differences of bit patterns, first all of
        their lowest bytes, then the next ones.
        """
        whole = np.concatenate([np.zeros(0, np.float32), *self._arrays]).view(np.uint32)
        steps = np.diff(whole, prepend=np.uint32(0))
        planes = steps.astype("<u4").view(np.uint8).reshape(-1, 4).T
        return deflated(planes.tobytes())


def deflated(data: bytes) -> str:
    """Bytes as compressed text, which `assets/unpack.js` reads."""
    return base64.b64encode(zlib.compress(data, 9)).decode("ascii")


PLACES = "joint_position"


def ideal_of(system: System) -> System | None:
    """The mechanism without clearances; None where there are none, or it cannot move alike."""
    if not system.mechanism.loose:
        return None
    try:
        return System(system.mechanism.ideal())
    except InputError:  # without clearances it has no mobility left, or too much
        return None


def ideal_module(system: System, options: RunOptions) -> str:
    """Its module of JavaScript, with what deviations are measured against; empty for none."""
    ideal = ideal_of(system)
    if ideal is None:
        return ""
    compared = [VARIABLES[name].compared for name in available(system)]
    return javascript_module(ideal, options, [PLACES, *filter(None, compared)])


def recorded(
    data: xr.Dataset,
    system: System,
    packed: Packed,
    state: Sequence[str | None] = (),
    period: float | None = None,
) -> dict[str, Any]:
    """Frames of a motion.

    `state`: names of series that are the coordinates of the state and their rates.
    `period`: of drives and loads, in seconds.

    Returns: ``time``, exactly, in two parts; ``series``, each with its values at the frames and,
    where those do not show it, its least and largest value of every ``stretch`` of frames;
    ``ghost``: joints of the same mechanism without clearances, where it has any; ``samples`` before
    frames were chosen; ``section``: the state once per period; ``detail``: the last samples of the
    state, where frames are too few to show its swings.
    """
    frames = chosen(data)
    time = np.asarray(data["time"], dtype=float)
    known = data_series(data)
    moved = {name: np.asarray(known[name].of(data), dtype=float) for name in state if name in known}
    series = []
    for name, own in known.items():
        if name == TIME or VARIABLES[own.variable].flags:
            continue
        values = np.asarray(own.of(data), dtype=float)
        between = bounds(values, frames)
        series.append(
            {
                "name": name,
                "values": packed.add(values[frames]),
                "bounds": None if between is None
                else {"stretch": between[0], "sides": [packed.add(side) for side in between[1:]]},
            }
        )  # fmt: skip
    return {
        "time": packed.add_exact(time[frames]),
        "samples": len(time),
        "series": series,
        "ghost": _ghost(time[frames], system, packed),
        "section": section(time, moved, period, packed),
        "detail": detail(time, moved, len(frames), packed),
    }


def section(
    time: Array, moved: Mapping[str, Array], period: float | None, packed: Packed
) -> dict[str, Any] | None:
    """The state at the start and once per period after it, from cubic splines of the samples.

    None where there is none, or samples do not show the swings between them.
    """
    if period is None or not moved or not all(np.isfinite(one).all() for one in moved.values()):
        return None
    if samples_per_swing(moved.values()) < PER_SWING:
        return None
    sign = np.sign(time[-1] - time[0])
    count = int(abs(time[-1] - time[0]) / period * (1 + 1e-12)) + 1
    if count < 2:
        return None
    times = time[0] + sign * period * np.arange(max(0, count - MOST_SECTIONS), count)
    at = np.clip(np.searchsorted(sign * time, sign * times), 1, len(time) - 1)
    spans = [slice(max(0, k - 4), k + 4) for k in at]  # splines far away change nothing here
    return {
        "time": packed.add_exact(times),
        "series": {
            name: packed.add([
                float(CubicSpline(sign * time[near], values[near])(sign * t))
                for near, t in zip(spans, times, strict=True)
            ])
            for name, values in moved.items()
        },
    }  # fmt: skip


def detail(
    time: Array, moved: Mapping[str, Array], frames: int, packed: Packed
) -> dict[str, Any] | None:
    """The last samples of the state; None where frames show its swings, or samples do not."""
    swing = samples_per_swing(moved.values()) if moved else np.inf
    if not np.isfinite(swing) or swing < COARSE or frames * swing >= COARSE * len(time):
        return None
    return {
        "time": packed.add_exact(time[-DETAIL:]),
        "series": {name: packed.add(values[-DETAIL:]) for name, values in moved.items()},
    }


def _ghost(time: np.ndarray[Any, Any], system: System, packed: Packed) -> Any:
    """The same motion without clearances; None where there are none, or it cannot move alike."""
    ideal = ideal_of(system)
    if ideal is None or ideal.topology.free:
        return None
    own = time[np.unique(np.linspace(0, len(time) - 1, FEWEST).round().astype(int))]
    moved = simulate(ideal.mechanism, times=own, outputs=[PLACES], throw=False)
    if not moved.completed:
        return None
    places = moved.data[PLACES].transpose("joint", "axis", "time")
    joints = {
        str(name): [packed.add(x), packed.add(y)]
        for name, (x, y) in zip(places["joint"].values, np.asarray(places), strict=True)
    }
    return {"time": packed.add_exact(own), "joints": joints}


NEAR = 1e-9
"""Of the picture: what round-off may part."""


def anchored(
    shapes: Iterable[Shape], pose: Pose
) -> tuple[list[Shape], dict[str, dict[str, str | float]]]:
    """The same drawing, in which what lies on a slider's axis counts from places on that axis.

    Between both ends of the travel a shape follows these; stops keep their displacement. What lies
    nowhere else than on a body stays as it is.

    Returns: the shapes, and the places on axes that they name beside joints: ``slider``, and ``at``
    which displacement, ``low`` and ``high`` for the ends of its travel.
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

    `pose`, `axes`: the position, and the axes in it.
    `places`: gets the places that anchors name.
    `keeping`: whether displacements stay what they are.
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
            result = self._on_axis(name, axis, own, direction)
            if result is not None:
                return result
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
        low, high = DrawnSlider(self._pose, name, axis).travel
        if self._keeping or high - low < NEAR * self._pose.extent:
            return {self._place(name, reach): 1.0}
        share = (reach - low) / (high - low)
        return {self._place(name, "low"): 1.0 - share, self._place(name, "high"): share}

    def _stroke(self, name: str, axis: SliderAxis, length: float) -> Weights:
        """Weights of the ends of a travel that give a share of it; none where there is none."""
        low, high = DrawnSlider(self._pose, name, axis).travel
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

    Returns: ``shapes`` in the order of drawing, in metres and typographic points, the ``places`` on
    axes that they name beside joints, and the ``box`` that they sweep: left, low, right, high in
    metres.
    """
    poses, box = framed(data, mechanism)
    shapes = [shape for shape in shapes_of(poses.at(0)) if shape.look.role != LOAD]
    shapes = pivots_above(shapes, mechanism.ground)
    places: dict[str, Any] = {}
    if "slider_position" in data:
        shapes, places = anchored(shapes, poses.at(0))
    return {
        "shapes": as_json(shapes),
        "places": places,
        "box": [*map(float, box.low), *map(float, box.high)],
    }


def pivots_above(shapes: Sequence[Shape], ground: Iterable[str]) -> list[Shape]:
    """The same shapes, with bearings on the ground behind pins only, not behind slotted bars."""
    fixed = set(ground)
    bearings = [s for s in shapes if isinstance(s, Strokes) and s.name in fixed]
    others = [s for s in shapes if not (isinstance(s, Strokes) and s.name in fixed)]
    first = next(
        (k for k, s in enumerate(others) if isinstance(s, Disc) and s.name in fixed), len(others)
    )
    return [*others[:first], *bearings, *others[first:]]
