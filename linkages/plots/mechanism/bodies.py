"""What drawings ask about bodies: their role, their slots, hulls, and where the ground lies."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.mechanism.pose import Pose, along_carrier

Array = NDArray[np.float64]


def clearance_ends(mechanism: Mechanism) -> dict[str, str]:
    """Points of bars that sit beside a pin with clearance → the joint of that pin."""
    return {term.renamed: term.joint for term in mechanism.displacements}


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


def body_role(mechanism: Mechanism, name: str) -> str:
    """By what determines a body's motion: a drive, nothing, or the other bodies."""
    if name in mechanism.prescribed:
        return "driven"
    return "free" if name in mechanism.initial else "bar"
