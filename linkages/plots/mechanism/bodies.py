"""The bodies of a mechanism as lines and polygons."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from linkages.components.contributed.terms import PLAYING, Body
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.mechanism.pose import Pose, along_carrier
from linkages.plots.style import CLEARANCE, DRIVEN, FREE, GREY, PASSIVE

Array = NDArray[np.float64]

THICKNESS = 3.4  # points


def clearance_ends(mechanism: Mechanism) -> dict[str, str]:
    """Points of bars that sit beside a pin with clearance → the joint of that pin."""
    return {term.renamed: term.joint for term in mechanism.displacements}


def outlines(pose: Pose) -> Iterator[tuple[Body, Array]]:
    """Each body that is a line or a plate, with its corners, shape (n, 2), n ≥ 2.

    Bodies that carry a slot reach to its ends. Clearances and plain blocks are left out.
    """
    for name, body in pose.mechanism.bodies.items():
        if body.kind in (*PLAYING, "block"):
            continue
        places = [np.array(list(pose.shown(name).values())).reshape(-1, 2)]
        if body.rotates:
            places += slots_of(pose, name)
        corners = np.vstack(places)
        if len(corners) > 1:
            yield body, convex_hull(corners)


def slots_of(pose: Pose, carrier: str) -> list[Array]:
    """Ends of the slots in a body, shape (2, 2) each."""
    found = []
    for name, body in pose.mechanism.bodies.items():
        if body.guide is not None and body.guide.body == carrier:
            ends = None if along_carrier(pose, name) else pose.slot(name)
            found += [] if ends is None else [ends]
    return found


def convex_hull(points: Array) -> Array:
    """Corners of the convex hull, counter-clockwise (Andrew's monotone chain).

    Collinear points give the two that are farthest apart.
    """

    def chain(ordered: list[tuple[float, float]]) -> list[tuple[float, float]]:
        kept: list[tuple[float, float]] = []
        for point in ordered:
            while len(kept) > 1 and _turn(kept[-2], kept[-1], point) <= tolerance:
                kept.pop()
            kept.append(point)
        return kept[:-1]

    ordered = sorted({(float(x), float(y)) for x, y in points})
    tolerance = 1e-9 * float(np.ptp(points, axis=0).max()) ** 2
    return np.array([*chain(ordered), *chain(ordered[::-1])] or ordered)


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    """Positive if a, b, c turn to the left."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def ground_direction(pose: Pose, joint: str) -> float:
    """Where the ground lies at a pin: below it, unless bars go that way."""
    shown = pose.positions
    bars = [
        np.arctan2(shown[other][1] - shown[joint][1], shown[other][0] - shown[joint][0])
        for body in pose.mechanism.bodies.values()
        if joint in body.points
        for other in body.points
        if other != joint and other in shown
    ]
    sides = np.array([-0.5, 0.5, 1.0, 0.0]) * np.pi
    nearness = [max((np.cos(side - bar) for bar in bars), default=-1.0) for side in sides]
    best = int(np.argmin(nearness))
    return float(sides[0] if nearness[0] < 0.5 else sides[best])


def body_colour(mechanism: Mechanism, name: str) -> str:
    """By what determines a body's motion: a drive, nothing, or the other bodies."""
    if name in mechanism.prescribed:
        return DRIVEN
    return FREE if name in mechanism.initial else PASSIVE


def draw_bodies(ax: Axes, pose: Pose, *, muted: bool = False, width: float = THICKNESS) -> None:
    """Draw bars as thick lines, plates as filled polygons, clearances as thin lines.

    Parameters
    ----------
    ax
        Where to draw.
    pose
        In the units of the axes.
    muted
        In grey, as a background.
    width
        Of bars in points, unless muted.
    """
    mechanism, positions = pose.mechanism, pose.positions
    for displaced, joint in clearance_ends(mechanism).items():
        if {displaced, joint} <= set(positions):
            ends = np.array([positions[joint], positions[displaced]])
            colour = GREY if muted else CLEARANCE
            ax.add_artist(Line2D(*ends.T, color=colour, linewidth=1.2, zorder=5))
    for body, corners in outlines(pose):
        colour = GREY if muted else body_colour(mechanism, body.name)
        thickness = 1.2 if muted else width
        if len(corners) > 2:
            fill = Polygon(corners, facecolor=colour, edgecolor="none", alpha=0.22, zorder=2)
            ax.add_artist(fill)
            corners = np.vstack((corners, corners[:1]))
            thickness = 0.6 * thickness
        _line(ax, corners, colour, thickness, muted)


def _line(ax: Axes, corners: Array, colour: str, width: float, muted: bool) -> None:
    ax.add_artist(
        Line2D(
            *corners.T,
            color=colour,
            linewidth=width,
            solid_capstyle="round",
            solid_joinstyle="round",
            zorder=1.5 if muted else 3,
        )
    )
