"""The bodies of a mechanism as lines and polygons."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from linkages.components.mechanism import Mechanism
from linkages.components.terms import Body
from linkages.plots.style import CLEARANCE, DRIVEN, FREE, GREY, PASSIVE
from linkages.plots.view import Positions

Array = NDArray[np.float64]

THICKNESS = 3.4  # points


def clearance_ends(mechanism: Mechanism) -> dict[str, str]:
    """Points of bars that sit beside a pin with clearance → the joint of that pin."""
    ends = {}
    for body in mechanism.bodies.values():
        if body.kind == "clearance":
            joint, displaced = body.points
            ends[displaced] = joint
    return ends


def outlines(mechanism: Mechanism, positions: Positions) -> Iterator[tuple[Body, Array]]:
    """Each turning body with its corners, shape (n, 2), n ≥ 2; clearances are left out."""
    for body in mechanism.bodies.values():
        places = [positions[joint] for joint in body.points if joint in positions]
        if body.rotates and body.kind != "clearance" and len(places) > 1:
            yield body, convex_hull(np.array(places, dtype=float))


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


def body_colour(mechanism: Mechanism, name: str) -> str:
    """By what determines a body's motion: a drive, nothing, or the other bodies."""
    if name in mechanism.prescribed:
        return DRIVEN
    return FREE if name in mechanism.initial else PASSIVE


def draw_bodies(
    ax: Axes, mechanism: Mechanism, positions: Positions, *, muted: bool = False
) -> None:
    """Draw bars as thick lines, plates as filled polygons, clearances as thin lines.

    Parameters
    ----------
    ax
        Where to draw.
    mechanism, positions
        Joint → (x, y) in the units of the axes.
    muted
        In grey, as a background.
    """
    for displaced, joint in clearance_ends(mechanism).items():
        if {displaced, joint} <= set(positions):
            ends = np.array([positions[joint], positions[displaced]])
            ax.plot(*ends.T, color=GREY if muted else CLEARANCE, linewidth=1.2, zorder=5)
    for body, corners in outlines(mechanism, positions):
        colour = GREY if muted else body_colour(mechanism, body.name)
        width = 1.2 if muted else THICKNESS
        if len(corners) > 2:
            fill = Polygon(corners, facecolor=colour, edgecolor="none", alpha=0.22, zorder=2)
            ax.add_patch(fill)
            corners = np.vstack((corners, corners[:1]))
            width = 0.6 * width
        ax.plot(
            *corners.T,
            color=colour,
            linewidth=width,
            solid_capstyle="round",
            solid_joinstyle="round",
            zorder=1.5 if muted else 3,
        )
