"""Loads and reactions as arrows."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, assert_never

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from matplotlib.patheffects import withStroke
from matplotlib.transforms import Affine2D, ScaledTranslation
from numpy.typing import ArrayLike, NDArray

from linkages.components.contributed.load_measures import (
    BodyAxis,
    Coordinate,
    Distance,
    Slide,
    Turn,
)
from linkages.kernel.system import System
from linkages.plots.mechanism.inked_shapes import points_per_unit
from linkages.plots.mechanism.pose import Pose
from linkages.plots.style import LOAD, PALETTE, figure_of, largest_magnitude, nice_below, scale_for

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

NARROW = 0.2
"""Arrows show the root of forces if a tenth of these are less than this much of the largest."""

NOTHING = 1e-9  # of the largest force: no force
SHORTEST = 0.2  # of the longest arrow: as long is that of any force, so that it is seen
ROOT = "arrows ∝ √F"  # what is written where lengths are no multiples of forces


@dataclass(frozen=True)
class ArrowScale:
    """How long arrows are, over the longest one."""

    full: float  # what the longest stands for, in SI units; 0 if there is nothing to show
    units: str = "N"  # of forces or torques
    root: bool = False  # whether lengths go with the root of a force, else with the force

    @classmethod
    def of(cls, values: Iterable[ArrayLike], units: str = "N") -> ArrowScale:
        """A scale for all values of a film: to the largest, by the root if their range is great."""
        flat = [np.ravel(np.asarray(own, dtype=float)) for own in values]
        sizes = np.abs(np.concatenate([np.empty(0), *flat]))
        full = largest_magnitude(sizes)
        acting = sizes[np.isfinite(sizes) & (sizes > NOTHING * full)]
        root = bool(len(acting)) and bool(np.quantile(acting, 0.1) < NARROW * full)
        return cls(full, units, root)

    @property
    def key(self) -> float:
        """A round value whose arrow explains the scale."""
        return nice_below(self.full)

    def length(self, value: float) -> float:
        """Of the arrow of a value, with its sign; 0 for none."""
        size = abs(value) / self.full if self.full and np.isfinite(value) else 0.0
        if size <= NOTHING:
            return 0.0
        return float(np.sign(value)) * max(SHORTEST, min(1.0, size**0.5 if self.root else size))

    def text(self, value: float) -> str:
        """A value in words."""
        scale = scale_for(abs(value), self.units)
        return f"{value * scale.factor:.3g} {scale.units}".replace("-", "−")


def arrow(along: Array, length: float, head: float, width: float) -> Array:
    """Corners of an arrow from the origin, shape (7, 2); it points back if its length is < 0."""
    tip = float(np.sign(length)) * min(head, 0.6 * abs(length))
    wide = 0.42 * abs(tip)
    shaft = min(width, 0.4 * wide)
    across = np.array([-along[1], along[0]])
    neck = length - tip
    corners = [(0.0, shaft), (neck, shaft), (neck, wide), (length, 0.0)]
    corners += [(reach, -aside) for reach, aside in reversed(corners[:3])]
    return np.array([reach * along + aside * across for reach, aside in corners])


def ring(radius: float, span: float, head: float, width: float) -> Array:
    """Corners of an arrow along a circle about the origin, shape (n, 2).

    `span`: angle from its foot to its tip in radians, counter-clockwise if > 0; its middle is on
    top.
    """
    reach, aside = arrow(np.array([1.0, 0.0]), radius * span, head, width).T
    ends = [np.linspace(reach[k], reach[k + 1], 25) for k in (0, 5)]
    along = [ends[0], reach[2:5], ends[1]]
    turn = 0.5 * (np.pi - span) + np.concatenate(along) / radius
    out = radius + np.repeat(aside[1:6], [25, 1, 1, 1, 25])
    return np.column_stack((out * np.cos(turn), out * np.sin(turn)))


LOADS = ("load_force", "load_torque")  # outputs with what acts from outside
REACTION = PALETTE[8]
LONGEST, HEAD, SHAFT = 48.0, 9.0, 1.1  # points: the longest arrow, its head, half its width
RADIUS, SPAN = 13.0, 1.5 * np.pi  # points and radians: of the arc of the largest torque


@dataclass(frozen=True)
class Push:
    """A force or torque over the samples."""

    joint: str  # where it acts
    # A force in newtons as x and y in the frame of a body, shape (time, 2); or one along a line, or
    # a torque in newton metres, shape (time,)
    values: Array
    body: str | None = None  # in whose frame; None for that of the ground
    away: str | None = None  # the joint from which a force along a line points away
    reaction: bool = False  # whether it is none from outside

    @property
    def twists(self) -> bool:
        """Whether it is a torque."""
        return self.away is None and self.values.ndim == 1

    @property
    def sizes(self) -> Array:
        """Magnitudes, shape (time,)."""
        return np.hypot(*self.values.T) if self.values.ndim > 1 else np.abs(self.values)

    def vector(self, pose: Pose, index: int) -> Array | None:
        """Of a force at one sample; None where its direction is not known."""
        value = self.values[index]
        if self.away is None:
            angle = pose.angle(self.body)
            if angle is None:
                return None
            cos, sin = np.cos(angle), np.sin(angle)
            return np.asarray(value @ np.array([[cos, sin], [-sin, cos]]))
        if self.away not in pose.positions:
            return None
        way = np.subtract(pose.positions[self.joint], pose.positions[self.away])
        return np.asarray(value * way / np.hypot(*way)) if way.any() else None


def loads(data: xr.Dataset, system: System) -> list[Push]:
    """Forces and torques from outside that the data have; components of a force are one arrow."""
    result: list[Push] = []
    vectors: dict[tuple[object, str, str | None], Array] = {}
    bodies = system.mechanism.bodies
    for load in system.model.loads:
        name = f"load_{load.dimension}"
        if name not in LOADS or name not in data:
            continue
        values = np.asarray(data[name].sel({load.dimension: load.label}), dtype=float)
        match measure := load.load.measure:
            case Coordinate(joint, axis) | BodyAxis(joint, _, axis):
                body = measure.body if isinstance(measure, BodyAxis) else None
                key = (load.load.path, joint, body)
                vectors.setdefault(key, np.zeros((len(values), 2)))[:, axis] += values
            case Slide(body):
                along = np.column_stack((values, np.zeros_like(values)))
                result.append(Push(next(iter(bodies[body].points)), along, body))
            case Distance(first, second):
                result += [Push(first, values, away=second), Push(second, values, away=first)]
            case Turn(body):
                points = bodies[body].points
                ends = [joint for joint in points if joint in system.mechanism.ground]
                result.append(Push([*ends, *points][0], values))
            case _:
                assert_never(measure)
    return [*(Push(joint, both, body) for (_, joint, body), both in vectors.items()), *result]


def reactions(data: xr.Dataset, joints: Sequence[str]) -> list[Push]:
    """Reactions of joints; of shared pins an arrow for the force on each body."""
    if not joints:
        return []
    known = [str(name) for name in data["joint"].values]
    pins = [str(name) for name in data["pin"].values] if "pin" in data.coords else []
    result = []
    for joint in joints:
        if joint not in known:
            raise ValueError(f"no joint {joint!r}; expected one of: {', '.join(known)}")
        shared = [pin for pin in pins if pin.rpartition(".")[0] == joint]
        chosen = [data["pin_reaction"].sel(pin=pin) for pin in shared]
        for force in chosen or [data["joint_reaction"].sel(joint=joint)]:
            values = np.asarray(force.transpose("time", "axis"), float)
            result.append(Push(joint, values, reaction=True))
    return result


class Pushes:
    """Arrows of forces and torques over a film, each kind with one scale.

    `ax`: where to draw; its limits are final.
    `pushes`: what to draw.
    `samples`: of the film: the largest among them have the longest arrows.
    """

    def __init__(self, ax: Axes, pushes: Sequence[Push], samples: NDArray[np.intp]) -> None:
        self._point = 1.0 / points_per_unit(ax)
        self._pushes = list(pushes)
        self.forces = ArrowScale.of(p.sizes[samples] for p in pushes if not p.twists)
        self.torques = ArrowScale.of((p.sizes[samples] for p in pushes if p.twists), "N·m")
        self._arrows = []
        for push in self._pushes:
            colour = REACTION if push.reaction else LOAD
            one = Polygon(np.zeros((3, 2)), facecolor=colour, linewidth=0, zorder=9, animated=True)
            one.set_path_effects([withStroke(linewidth=2.0, foreground="white")])
            self._arrows.append(one)
            ax.add_artist(one)

    @property
    def artists(self) -> list[Artist]:
        """What moves, in the order of drawing."""
        return list(self._arrows)

    def draw_key(self, ax: Axes, x: float, y: float) -> None:
        """Explain the scales under the axes, from a place in points from their lower left."""
        figure = figure_of(ax)
        for scale in (self.forces, self.torques):
            if not scale.full:
                continue
            length, right = scale.length(scale.key), np.array([1.0, 0.0])
            if scale is self.forces:
                corners = arrow(right, LONGEST * length, HEAD, SHAFT)
            else:
                corners = ring(RADIUS, SPAN * length, HEAD, SHAFT) + RADIUS * np.array([1.0, -0.5])
            place = ScaledTranslation(x / 72.0, y / 72.0, figure.dpi_scale_trans)
            corner = Affine2D().translate(*ax.bbox.p0.tolist())
            there = Affine2D().scale(1.0 / 72.0) + figure.dpi_scale_trans + corner + place
            figure.add_artist(
                Polygon(corners, transform=there, color=LOAD, linewidth=0, clip_on=False)
            )
            x += float(corners[:, 0].max()) + 4.0
            place = ScaledTranslation(x / 72.0, y / 72.0, figure.dpi_scale_trans)
            text = scale.text(scale.key) + (f", {ROOT}" if scale.root else "")
            ax.text(0.0, 0.0, text, transform=ax.transAxes + place, va="center", color=LOAD,
                    fontsize=8)  # fmt: skip
            x += 4.6 * len(text) + 10.0

    def show(self, pose: Pose, index: int) -> None:
        """Put every arrow where it is in a position, in the units of the axes."""
        for push, artist in zip(self._pushes, self._arrows, strict=True):
            corners = self._corners(push, pose, index)
            artist.set_visible(corners is not None)
            if corners is not None:
                place = np.asarray(pose.positions[push.joint])
                artist.set_xy(place + self._point * corners)

    def _corners(self, push: Push, pose: Pose, index: int) -> Array | None:
        """In points from the joint; None if there is nothing to show."""
        if push.joint not in pose.positions:
            return None
        if push.twists:
            part = self.torques.length(float(push.values[index]))
            return ring(RADIUS, SPAN * part, HEAD, SHAFT) if part else None
        vector = push.vector(pose, index)
        size = 0.0 if vector is None else float(np.hypot(*vector))
        length = self.forces.length(size)
        if vector is None or not length:
            return None
        return arrow(vector / size, LONGEST * length, HEAD, SHAFT)
