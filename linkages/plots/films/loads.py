"""Loads, and reactions of joints, as arrows that are as long as these are at the time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, assert_never

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from matplotlib.patheffects import withStroke
from matplotlib.transforms import Affine2D, ScaledTranslation
from numpy.typing import NDArray

from linkages.components.contributed.measures import BodyAxis, Coordinate, Distance, Slide, Turn
from linkages.kernel.system import System
from linkages.plots.films.arrows import ROOT, ArrowScale, arrow, ring
from linkages.plots.mechanism.inked import points_per_unit
from linkages.plots.mechanism.pose import Pose
from linkages.plots.style import LOAD, PALETTE

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

LOADS = ("load_force", "load_torque")
"""Outputs with what acts from outside."""

REACTION = PALETTE[8]
LONGEST, HEAD, SHAFT = 48.0, 9.0, 1.1  # points: the longest arrow, its head, half its width
RADIUS, SPAN = 13.0, 1.5 * np.pi
"""Points and radians: of the arc of the largest torque."""


@dataclass(frozen=True)
class Push:
    """A force or torque over the samples.

    Parameters
    ----------
    joint
        Where it acts.
    values
        A force in newtons as x and y in the frame of a body, shape (time, 2); or one along a line,
        or a torque in newton metres, shape (time,).
    body
        In whose frame; None for that of the ground.
    away
        The joint from which a force along a line points away.
    reaction
        Whether it is none from outside.
    """

    joint: str
    values: Array
    body: str | None = None
    away: str | None = None
    reaction: bool = False

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
    found: list[Push] = []
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
                found.append(Push(next(iter(bodies[body].points)), along, body))
            case Distance(first, second):
                found += [Push(first, values, away=second), Push(second, values, away=first)]
            case Turn(body):
                points = bodies[body].points
                ends = [joint for joint in points if joint in system.mechanism.ground]
                found.append(Push([*ends, *points][0], values))
            case _:
                assert_never(measure)
    return [*(Push(joint, both, body) for (_, joint, body), both in vectors.items()), *found]


def reactions(data: xr.Dataset, joints: Sequence[str]) -> list[Push]:
    """Reactions of joints; of shared pins an arrow for the force on each body.

    Raises
    ------
    ValueError
        For a joint that has none.
    """
    if not joints:
        return []
    known = [str(name) for name in data["joint"].values]
    pins = [str(name) for name in data["pin"].values] if "pin" in data.coords else []
    found = []
    for joint in joints:
        if joint not in known:
            raise ValueError(f"no joint {joint!r}; expected one of: {', '.join(known)}")
        shared = [pin for pin in pins if pin.rpartition(".")[0] == joint]
        chosen = [data["pin_reaction"].sel(pin=pin) for pin in shared]
        for force in chosen or [data["joint_reaction"].sel(joint=joint)]:
            values = np.asarray(force.transpose("time", "axis"), float)
            found.append(Push(joint, values, reaction=True))
    return found


class Pushes:
    """Arrows of forces and torques over a film, each kind with one scale.

    Parameters
    ----------
    ax
        Where to draw; its limits are final.
    pushes
        What to draw.
    samples
        Of the film: the largest among them have the longest arrows.
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
        figure = ax.get_figure(root=True)
        assert figure is not None
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
