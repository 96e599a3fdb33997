"""Roles of bodies and loads in drawings."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar, assert_never

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.components.contributed.functions import Table
from linkages.components.contributed.load_measures import (
    BodyAxis,
    Coordinate,
    Distance,
    Load,
    Slide,
    Turn,
)
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.inputs import law_values
from linkages.plots.mechanism.pose import Pose, along_carrier
from linkages.reading.paths import KeyPath

Array = NDArray[np.float64]


def clearance_ends(mechanism: Mechanism) -> dict[str, str]:
    """Points of bars that sit beside a pin with clearance → the joint of that pin."""
    return {term.renamed: term.joint for term in mechanism.displacements}


def slots_of(pose: Pose, carrier: str) -> list[Array]:
    """Ends of the slots in a body, shape (2, 2) each."""
    result = []
    for name, body in pose.mechanism.bodies.items():
        if body.guide is not None and body.guide.body == carrier:
            ends = None if along_carrier(pose, name) else pose.slot(name)
            result += [] if ends is None else [ends]
    return result


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


Kind = TypeVar("Kind")


def parts_of(mechanism: Mechanism, kind: type[Kind]) -> list[Kind]:
    """All components of a kind."""
    return [part for part in mechanism.components if isinstance(part, kind)]


def measured(loads: Iterable[Load], kind: type[Kind]) -> list[tuple[Kind, Load]]:
    """Loads that act along one kind of measure, each after its measure."""
    return [(load.measure, load) for load in loads if isinstance(load.measure, kind)]


AtJoint = Coordinate | BodyAxis


def at_joints(loads: Iterable[Load]) -> dict[tuple[KeyPath, str], list[tuple[AtJoint, Load]]]:
    """Loads at joints by their entries, of which each is one arrow."""
    result: dict[tuple[KeyPath, str], list[tuple[AtJoint, Load]]] = {}
    for load in loads:
        match load.measure:
            case Coordinate(joint) | BodyAxis(joint) as measure:
                result.setdefault((load.path, joint), []).append((measure, load))
            case Distance() | Slide() | Turn():
                pass  # `measured` has these
            case _:
                assert_never(load.measure)
    return result


def frictions_of(mechanism: Mechanism) -> list[Load]:
    """All loads that rub at joints and in guides, and are no dampers."""
    return [load for load in mechanism.loads if load.called == "friction"]


def springs_of(mechanism: Mechanism) -> list[Load]:
    """All loads but those of stops and friction, which are no springs or dampers to look at."""
    return [load for load in mechanism.loads if load.called not in ("stop", "friction")]


SAMPLES = 721
BOTH = 2
NEGLIGIBLE = 1e-9  # of the largest magnitude


def run_times(mechanism: Mechanism) -> Array:
    """Times over the run that the definition asks for, shape (`SAMPLES`,), in seconds."""
    return np.linspace(0.0, mechanism.simulation.end, SAMPLES)


def sense_of(values: ArrayLike) -> int:
    """The sign that all values have: 1, −1, 0 if all are zero, `BOTH` if they differ."""
    array = np.asarray(values, dtype=float)
    array = array[np.isfinite(array)]
    least = NEGLIGIBLE * float(np.abs(array).max(initial=0.0))
    rises, falls = bool((array > least).any()), bool((array < -least).any())
    return BOTH if rises and falls else rises - falls


def load_sense(load: Load, mechanism: Mechanism) -> int:
    """Which way a force or torque acts during the run.

    One that depends on the motion acts both ways, unless all values of its table have one sign.
    """
    if load.given:
        return sense_of(law_values(load.law, run_times(mechanism)))
    return sense_of(load.law.values) if isinstance(load.law, Table) else BOTH


def drive_sense(mechanism: Mechanism, name: str) -> int:
    """Which way a drive moves its body during the run."""
    return sense_of(np.diff(law_values(mechanism.prescribed[name].law, run_times(mechanism))))


def force_direction(
    force: Iterable[tuple[AtJoint, Load]], mechanism: Mechanism
) -> tuple[float, int]:
    """Direction of a force where it is largest, in radians, and its sense along that (or 0).

    That of a force that turns with a body is the one in the body's own frame.

    One that depends on the motion acts both ways along the first axis in which it does.
    """
    times = run_times(mechanism)
    vectors = np.zeros((len(times), 2))
    for measure, load in force:
        if not load.given:
            return 0.5 * np.pi * measure.axis, BOTH
        vectors[:, measure.axis] += law_values(load.law, times)
    vectors = vectors[np.isfinite(vectors).all(axis=1)]
    if not vectors.any():
        return 0.0, 0
    largest = vectors[np.argmax(np.hypot(*vectors.T))]
    return float(np.arctan2(largest[1], largest[0])), sense_of(vectors @ largest)
