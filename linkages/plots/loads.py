"""Springs, dampers, forces, torques and point masses in a drawing."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes

from linkages.components.functions import Function, Number
from linkages.components.terms import Torque
from linkages.plots import symbols
from linkages.plots.arrows import STRAIGHT, TORQUE, TORQUE_SPAN, arc_arrow, straight_arrow
from linkages.plots.bodies import ground_direction
from linkages.plots.kinds import by_kind
from linkages.plots.labels import Labels
from linkages.plots.pose import Place, Pose
from linkages.plots.prefixes import scale_for
from linkages.plots.senses import force_direction, load_sense
from linkages.plots.sliders import block_place, force_side
from linkages.plots.springs import bent_dashpot, dashpot, spiral, zigzag
from linkages.plots.style import LOAD
from linkages.plots.view import per_point, pixels

BESIDE = 12.0  # points between symbols that lie side by side
OUTER = 15.0  # radius of a bent dashpot around a spiral


def draw_masses(ax: Axes, pose: Pose, labels: Labels) -> None:
    """Discs at joints that carry a concentrated mass."""
    for mass in pose.mechanism.point_masses:
        if mass.joint in pose.positions and mass.mass.value > 0.0:
            labels.avoid(symbols.point_mass(ax, pose.positions[mass.joint]))


def draw_springs(ax: Axes, pose: Pose, labels: Labels) -> None:
    """Springs and dampers between joints; several between the same two lie side by side."""
    lines: dict[tuple[str, ...], list[bool]] = {}
    for load in by_kind(pose.mechanism.loads).springs:
        if {load.first, load.second} <= set(pose.positions):
            found = lines.setdefault(tuple(sorted((load.first, load.second))), [])
            found += [True] * (not load.stiffness.absent)
            found += [False] * (not load.damping.absent)
    for (first, second), parts in lines.items():
        ends = pose.positions[first], pose.positions[second]
        if ends[0] == ends[1]:
            continue
        for index, elastic in enumerate(parts):
            shift = BESIDE * (index - 0.5 * (len(parts) - 1))
            labels.avoid((zigzag if elastic else dashpot)(ax, *ends, shift))


def draw_torsional(ax: Axes, pose: Pose, labels: Labels, first: Pose | None = None) -> None:
    """Spirals of torsional springs and bent dashpots of torsional dampers.

    Dashpots point where there was room in a first position, if one is given.
    """
    first = first or pose
    taken: Counter[Place] = Counter()
    for load in by_kind(pose.mechanism.loads).torsional:
        place = pivot(pose, load.body, load.reference)
        before = pivot(first, load.body, load.reference)
        if place is None or before is None:
            continue
        angle = _free_direction(first, before)
        if not load.stiffness.absent:
            labels.avoid(spiral(ax, place, _direction_of(pose, load.body, place)))
        if not load.damping.absent:
            radius = OUTER if not load.stiffness.absent or taken[place] else 9.5
            labels.avoid(bent_dashpot(ax, place, angle + np.pi * taken[place], radius))
        taken[place] += 1


def draw_forces(ax: Axes, pose: Pose, labels: Labels) -> None:
    """Arrows of forces at joints and arcs of torques on bodies."""
    mechanism = pose.mechanism
    kinds = by_kind(mechanism.loads)
    for force in kinds.forces:
        if force.joint not in pose.positions:
            continue
        angle, sense = force_direction(force.force, mechanism)
        place = pose.positions[force.joint]
        if sense:
            covered = straight_arrow(ax, place, angle, (symbols.MASS + 1.0, 0.0), sense, LOAD)
            labels.avoid(covered)
    for torque in kinds.torques:
        spot = _torque_place(pose, torque)
        sense = load_sense(torque.torque, mechanism)
        if spot and sense:
            angle = _direction_of(pose, torque.body, spot) + np.pi / 2
            labels.avoid(arc_arrow(ax, spot, angle, TORQUE, TORQUE_SPAN, sense, LOAD))


def load_texts(ax: Axes, pose: Pose) -> Iterator[tuple[str, Place, float]]:
    """What is written at loads: text, place, and its least distance from there in points."""
    kinds = by_kind(pose.mechanism.loads)
    for force in kinds.forces:
        size = _size(force.force, "N")
        angle, sense = force_direction(force.force, pose.mechanism)
        if force.joint in pose.positions and size and sense:
            yield size, _tip(ax, pose.positions[force.joint], angle, 1), 4.0
    for axial in kinds.axial:
        place, size = block_place(pose, axial.body), _size((axial.force,), "N")
        sense, turned = load_sense(axial.force, pose.mechanism), pose.angle(axial.body)
        if place and size and sense and turned is not None:
            side = force_side(pose, axial.body, sense)
            yield size, _tip(ax, place, turned, side), 4.0 if side else 16.0
    for torque in kinds.torques:
        place, size = _torque_place(pose, torque), _size((torque.torque,), "N·m")
        if place and size:
            yield size, place, TORQUE + 3.0


def _tip(ax: Axes, place: Place, angle: float, sense: int) -> Place:
    """Near the outer end of a force's arrow; the place itself if the arrow stands over it."""
    reach = sense * STRAIGHT * per_point(ax)
    pixel = pixels(ax, place)[0] + reach * np.array([np.cos(angle), np.sin(angle)])
    x, y = ax.transData.inverted().transform(pixel)
    return float(x), float(y)


def _size(parts: tuple[Function, ...], units: str) -> str:
    """The magnitude of a load, or the symbol of one that varies; empty for none."""
    numbers = [part.parameter.value for part in parts if isinstance(part, Number)]
    if len(numbers) < len(parts):
        return "F(t)" if units == "N" else "M(t)"
    size = float(np.hypot.reduce(numbers)) if len(numbers) > 1 else abs(numbers[0])
    return scale_for(size, units).text(size) if size else ""


def pivot(pose: Pose, body: str, reference: str | None) -> Place | None:
    """Where one body turns against another (None: the ground): a joint of both, if there is one.

    Otherwise a joint of the body.
    """
    shown = pose.shown(body)
    others = pose.mechanism.ground if reference is None else pose.shown(reference)
    return next(
        (shown[joint] for joint in shown if joint in others), next(iter(shown.values()), None)
    )


def _torque_place(pose: Pose, load: Torque) -> Place | None:
    """The joint between two bodies, or the middle of one that the ground turns."""
    if load.reference is None:
        return _middle(pose, load.body)
    return pivot(pose, load.body, load.reference)


def _middle(pose: Pose, body: str) -> Place | None:
    places = list(pose.shown(body).values())
    if not places:
        return None
    x, y = np.mean(places, axis=0)
    return float(x), float(y)


def _direction_of(pose: Pose, body: str, place: Place) -> float:
    """From a place to the joint of a body that is farthest away."""
    ways = [np.subtract(other, place) for other in pose.shown(body).values()]
    way = max(ways, key=lambda way: float(np.hypot(*way)))
    return float(np.arctan2(way[1], way[0]))


def _free_direction(pose: Pose, place: Place) -> float:
    """The direction from a joint that is farthest from all bars there."""
    groups = [list(pose.shown(name).values()) for name in pose.mechanism.bodies]
    springs = by_kind(pose.mechanism.loads).springs
    pairs = [(spring.first, spring.second) for spring in springs]
    groups += [[pose.positions[j] for j in pair if j in pose.positions] for pair in pairs]
    ways = [
        np.subtract(other, place)
        for group in groups
        if place in group
        for other in group
        if other != place
    ]
    bearings = [j for j in pose.mechanism.ground if pose.positions.get(j) == place]
    angles = [np.arctan2(way[1], way[0]) for way in ways]
    taken = np.array([*angles, *(ground_direction(pose, joint) for joint in bearings)] or [0.0])
    around = np.pi * (0.75 + np.arange(16) / 8.0)
    nearest = [float(np.cos(angle - taken).max()) for angle in around]
    return float(around[int(np.argmin(np.round(nearest, 6)))])
