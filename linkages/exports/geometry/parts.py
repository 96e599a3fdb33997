"""Links as parts in millimetres, and the paths of joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.terms import PLAYING
from linkages.exports import Subject
from linkages.exports.geometry.outlines import Outline, rectangle, rounded, thinned
from linkages.options.option import OptionError
from linkages.plots.mechanism.guides import travel_of
from linkages.plots.mechanism.pose import Pose, along_carrier
from linkages.plots.mechanism.samples import pose_at
from linkages.plots.mechanism.traces import moving_joints
from linkages.plots.mechanism.view import Box
from linkages.reading.wording import TOO_LARGE

Array = NDArray[np.float64]

MILLIMETRES = 1000.0
HOLE = 0.03
"""Diameter of a hole over the size of the mechanism, where nobody says it."""

WIDTH = 2.5
"""Width of a link over the diameter of its holes, where nobody says it."""


NARROW = 1e-5
"""Of the size of all paths: how far a line may be from the samples that it stands for."""

NEAR = 1e-6
"""Of the size of the mechanism: what a slider moves less than this has no slot."""


@dataclass(frozen=True)
class Part:
    """A link where the motion begins, in millimetres.

    Parameters
    ----------
    name
        Of the body.
    outline
        Its edge.
    holes
        Joint → centre of its hole, shape (2,).
    slots
        Edges of slots that others slide in.
    """

    name: str
    outline: Outline
    holes: Mapping[str, Array]
    slots: list[Outline]


@dataclass(frozen=True)
class Sizes:
    """Diameter of holes and width of links in millimetres."""

    hole: float
    width: float


@dataclass(frozen=True)
class Drawn:
    """What a drawing shows, in millimetres.

    Parameters
    ----------
    parts, paths
        Links, and joints with the places that they go through, shape (time, 2).
    sizes
        Of holes and links.
    """

    parts: list[Part]
    paths: dict[str, Array]
    sizes: Sizes

    @property
    def box(self) -> tuple[Array, Array]:
        """Low and high corner of everything."""
        corners = [part.outline.corners for part in self.parts]
        everything = np.vstack([*corners, *self.paths.values()])
        margin = self.sizes.width  # round ends reach beyond corners
        return everything.min(axis=0) - margin, everything.max(axis=0) + margin


def first_pose(subject: Subject) -> Pose:
    """Where the motion begins, in millimetres; InputError if it is too large for that."""
    with np.errstate(over="ignore", invalid="ignore"):
        pose = pose_at(subject.solution.data, subject.mechanism, 0).scaled(MILLIMETRES)
        sound = np.isfinite(pose.extent) and np.isfinite([*pose.positions.values()]).all()
    if not sound:
        message = f"the mechanism is too large to draw in millimetres. {TOO_LARGE}"
        raise subject.mechanism.error([((), message)])
    return pose


def sizes_of(pose: Pose, hole: float | None, width: float | None) -> Sizes:
    """Sizes in millimetres from those that are given in metres, or a default for either.

    Raises
    ------
    OptionError
        For holes of no positive diameter, and links that are no wider than their holes.
    """
    diameter = HOLE * pose.extent if hole is None else MILLIMETRES * hole
    wide = WIDTH * diameter if width is None else MILLIMETRES * width
    if not 0.0 < diameter < np.inf:
        raise OptionError("hole", f"hole must be > 0 m, found {diameter / MILLIMETRES:g}")
    if not diameter < wide < np.inf:
        raise OptionError(
            "width", f"width must be larger than the holes of {diameter:g} mm, found {wide:g} mm"
        )
    return Sizes(diameter, wide)


def parts_of(pose: Pose, sizes: Sizes) -> list[Part]:
    """All links whose places are known: bars, plates, blocks; clearances are none."""
    parts = []
    for name, body in pose.mechanism.bodies.items():
        holes = {joint: np.array(place) for joint, place in pose.shown(name).items()}
        slots, angle = travels_on(pose, name), pose.angle(name)
        if body.kind in PLAYING or not holes or (len(holes) < 2 and angle is None):
            continue
        if len(holes) > 1 or slots:
            outline = rounded(np.vstack([*holes.values(), *slots]), 0.5 * sizes.width)
        else:
            (centre,) = holes.values()
            outline = rectangle(centre, float(angle or 0.0), 2.0 * sizes.width, sizes.width)
        parts.append(Part(name, outline, holes, [rounded(e, 0.5 * sizes.hole) for e in slots]))
    return parts


def travels_on(pose: Pose, carrier: str) -> list[Array]:
    """First and last place of every slider in a slot of a body, shape (2, 2) each.

    One that leaves the bar that carries it along its own line is a rod and has no slot.
    """
    found = []
    for name, body in pose.mechanism.bodies.items():
        if body.kind in PLAYING or body.guide is None or body.guide.body != carrier:
            continue
        axis, ends = pose.axis(name), along_carrier(pose, name)
        if axis is None:
            continue
        low, high = travel_of(pose, name, axis)
        near = NEAR * pose.extent
        if high - low > near and (ends is None or ends[0] - near < low < high < ends[1] + near):
            found.append(np.array([axis.at(low), axis.at(high)]))
    return found


def paths_of(subject: Subject) -> dict[str, Array]:
    """Moving joint → places that it goes through, shape (n, 2), in millimetres.

    They are samples, as many as the path needs: lines between them leave it by at most `NARROW`.
    Samples where the joint is not known are left out at both ends.

    Raises
    ------
    ValueError
        If a path has gaps.
    """
    found = {}
    moving = moving_joints(subject.solution.data, subject.mechanism)
    size = Box.around(np.vstack([*moving.values()])).extent if moving else 0.0
    for name, path in moving.items():
        known = np.flatnonzero(np.isfinite(path).all(axis=1))
        if not len(known):
            continue
        part = path[known[0] : known[-1] + 1]
        if len(part) != len(known):
            raise ValueError(f"the path of joint {name} has gaps: it cannot be one line")
        found[name] = MILLIMETRES * thinned(part, NARROW * size)
    return found
