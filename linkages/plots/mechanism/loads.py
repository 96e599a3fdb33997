"""Springs, dampers, forces, torques and point masses in a drawing."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes

from linkages.components.contributed.functions import Number
from linkages.components.contributed.measures import BodyAxis, Coordinate, Load, Turn
from linkages.components.contributed.sensing import named
from linkages.components.contributed.state_laws import NOTHING
from linkages.plots.mechanism import symbols
from linkages.plots.mechanism.arrows import STRAIGHT, TORQUE, TORQUE_SPAN, arc_arrow, straight_arrow
from linkages.plots.mechanism.bodies import ground_direction
from linkages.plots.mechanism.kinds import by_kind
from linkages.plots.mechanism.labels import Labels
from linkages.plots.mechanism.pose import Place, Pose
from linkages.plots.mechanism.senses import force_direction, load_sense
from linkages.plots.mechanism.sliders import block_place, force_side
from linkages.plots.mechanism.springs import bent_dashpot, dashpot, spiral, zigzag
from linkages.plots.mechanism.view import per_point, pixels
from linkages.plots.prefixes import scale_for
from linkages.plots.style import LOAD

BESIDE = 12.0  # points between symbols that lie side by side
OUTER = 15.0  # radius of a bent dashpot around a spiral


def draw_masses(ax: Axes, pose: Pose, labels: Labels) -> None:
    """Discs at joints that carry a concentrated mass."""
    for mass in pose.mechanism.point_masses:
        if mass.joint in pose.positions and mass.mass.value > 0.0:
            labels.avoid(symbols.point_mass(ax, pose.positions[mass.joint]))


def draw_springs(ax: Axes, pose: Pose, labels: Labels) -> None:
    """Springs, dampers and cylinders between joints; those of the same two lie side by side."""
    lines: dict[tuple[str, ...], list[bool]] = {}
    for ends, load in by_kind(pose.mechanism.loads).lines:
        if {ends.first, ends.second} <= set(pose.positions):
            found = lines.setdefault(tuple(sorted((ends.first, ends.second))), [])
            found += [True] * (load.elastic or (load.passive and load.energy != NOTHING))
            thrusts = not (load.passive or load.absent)
            found += [False] * (load.dissipates or thrusts)
    for (first, second), parts in lines.items():
        start, end = pose.positions[first], pose.positions[second]
        if start == end:
            continue
        for index, elastic in enumerate(parts):
            shift = BESIDE * (index - 0.5 * (len(parts) - 1))
            labels.avoid((zigzag if elastic else dashpot)(ax, start, end, shift))


def draw_torsional(ax: Axes, pose: Pose, labels: Labels, first: Pose | None = None) -> None:
    """Spirals of torsional springs and bent dashpots of torsional dampers.

    Dashpots point where there was room in a first position, if one is given.
    """
    first = first or pose
    taken: Counter[Place] = Counter()
    for turn, load in by_kind(pose.mechanism.loads).turns:
        place, before = pivot(pose, turn), pivot(first, turn)
        if load.given or load.applied or place is None or before is None:
            continue
        angle = _free_direction(first, before)
        if load.elastic:
            labels.avoid(spiral(ax, place, _direction_of(pose, turn.body, place)))
        if load.dissipates:
            radius = OUTER if load.elastic or taken[place] else 9.5
            labels.avoid(bent_dashpot(ax, place, angle + np.pi * taken[place], radius))
        taken[place] += 1


def draw_forces(ax: Axes, pose: Pose, labels: Labels) -> None:
    """Arrows of forces at joints and arcs of torques on bodies."""
    mechanism = pose.mechanism
    kinds = by_kind(mechanism.loads)
    for (_, joint), force in kinds.joints.items():
        angle, sense = _direction(pose, force)
        if sense and joint in pose.positions:
            place = pose.positions[joint]
            covered = straight_arrow(ax, place, angle, (symbols.MASS + 1.0, 0.0), sense, LOAD)
            labels.avoid(covered)
    for turn, torque in kinds.turns:
        spot = _torque_place(pose, turn) if torque.given or torque.applied else None
        if spot and (sense := load_sense(torque, mechanism)):
            angle = _direction_of(pose, turn.body, spot) + np.pi / 2
            labels.avoid(arc_arrow(ax, spot, angle, TORQUE, TORQUE_SPAN, sense, LOAD))


def load_texts(ax: Axes, pose: Pose) -> Iterator[tuple[str, Place, float]]:
    """What is written at loads: text, place, and its least distance from there in points."""
    kinds = by_kind(pose.mechanism.loads)
    for (_, joint), force in kinds.joints.items():
        size = _size([load for _, load in force])
        angle, sense = _direction(pose, force)
        if joint in pose.positions and size and sense:
            yield size, _tip(ax, pose.positions[joint], angle, 1), 4.0
    for slide, axial in kinds.slides:
        place, size = block_place(pose, slide.body), _size([axial])
        sense, turned = load_sense(axial, pose.mechanism), pose.angle(slide.body)
        if axial.pushes and place and size and sense and turned is not None:
            side = force_side(pose, slide.body, sense)
            yield size, _tip(ax, place, turned, side), 4.0 if side else 16.0
    for turn, torque in kinds.turns:
        place, size = _torque_place(pose, turn), _size([torque])
        if (torque.given or torque.applied) and place and size:
            yield size, place, TORQUE + 3.0


def _direction(
    pose: Pose, force: Sequence[tuple[Coordinate | BodyAxis, Load]]
) -> tuple[float, int]:
    """Direction of a force in the plane and its sense, 0 where its body is not shown."""
    angle, sense = force_direction(force, pose.mechanism)
    measure = force[0][0]
    turned = pose.angle(measure.body) if isinstance(measure, BodyAxis) else 0.0
    return (0.0, 0) if turned is None else (angle + turned, sense)


def _tip(ax: Axes, place: Place, angle: float, sense: int) -> Place:
    """Near the outer end of a force's arrow; the place itself if the arrow stands over it."""
    reach = sense * STRAIGHT * per_point(ax)
    pixel = pixels(ax, place)[0] + reach * np.array([np.cos(angle), np.sin(angle)])
    x, y = ax.transData.inverted().transform(pixel)
    return float(x), float(y)


def _size(loads: list[Load]) -> str:
    """The magnitude of loads that are one arrow, or the symbol of what varies; empty for none."""
    turning = loads[0].twists
    numbers = [load.law.parameter.value for load in loads if isinstance(load.law, Number)]
    if len(numbers) < len(loads):
        found = dict.fromkeys(name for load in loads for name in named(load.law))
        return f"{'M' if turning else 'F'}({', '.join(found)})"
    size = float(np.hypot.reduce(numbers)) if len(numbers) > 1 else abs(numbers[0])
    return scale_for(size, "N·m" if turning else "N").text(size) if size else ""


def pivot(pose: Pose, turn: Turn) -> Place | None:
    """Where one body turns against another (None: the ground): a joint of both, if there is one.

    Otherwise a joint of the body.
    """
    shown = pose.shown(turn.body)
    others = pose.mechanism.ground if turn.reference is None else pose.shown(turn.reference)
    return next(
        (shown[joint] for joint in shown if joint in others), next(iter(shown.values()), None)
    )


def _torque_place(pose: Pose, turn: Turn) -> Place | None:
    """The joint between two bodies, or the middle of one that the ground turns."""
    return _middle(pose, turn.body) if turn.reference is None else pivot(pose, turn)


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
    pairs = [(line.first, line.second) for line, _ in by_kind(pose.mechanism.loads).lines]
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
