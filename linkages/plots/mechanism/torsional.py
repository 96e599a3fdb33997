"""Torsional springs and dampers of a drawing, about their pins."""

from __future__ import annotations

from collections import Counter

import numpy as np

from linkages.components.contributed.measures import Turn
from linkages.plots.mechanism import outlining
from linkages.plots.mechanism.bodies import ground_direction
from linkages.plots.mechanism.frames import Frame, joints
from linkages.plots.mechanism.kinds import by_kind, frictions_of, springs_of
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.shapes import Direction, Shape
from linkages.plots.mechanism.springs import SPRING

OUTER = 15.0
"""Points: radius of a bent dashpot around a spiral."""


def draw_torsional(pose: Pose) -> list[Shape]:
    """Spirals of torsional springs and bent dashpots of torsional dampers."""
    taken: Counter[str] = Counter()
    found: list[Shape] = []
    rubbing = {pivot(pose, turn) for turn, _ in by_kind(frictions_of(pose.mechanism)).turns}
    for turn, load in by_kind(springs_of(pose.mechanism)).turns:
        joint = pivot(pose, turn)
        if load.given or load.applied or joint is None:
            continue
        full = load.elastic or taken[joint] or joint in rubbing
        free = Frame(pose, Direction(_free_direction(pose, joint) + np.pi * taken[joint]))
        taken[joint] += 1
        if load.states:  # a spring, to which a damper is tied
            strokes = outlining.spiral_and_dashpot(OUTER)
            found.append(free.symbol(free.at(joint), strokes, SPRING, name=joint))
            continue
        if load.elastic:
            far = farthest(pose, turn.body, joint)
            frame = Frame(pose, Direction(body=turn.body) if far is None else joints(joint, far))
            found.append(frame.symbol(frame.at(joint), [outlining.spiral()], SPRING, name=joint))
        if load.dissipates:
            strokes = outlining.bent_dashpot(OUTER if full else outlining.BENT)
            found.append(free.symbol(free.at(joint), strokes, SPRING, name=joint))
    return found


def pivot(pose: Pose, turn: Turn) -> str | None:
    """Where one body turns against another (None: the ground): a joint of both, if there is one.

    Otherwise a joint of the body.
    """
    shown = pose.shown(turn.body)
    others = pose.mechanism.ground if turn.reference is None else pose.shown(turn.reference)
    return next((joint for joint in shown if joint in others), next(iter(shown), None))


def farthest(pose: Pose, body: str, joint: str) -> str | None:
    """The joint of a body that is farthest away from one; None if there is no other."""
    shown, place = pose.shown(body), pose.positions[joint]
    apart = {j: float(np.hypot(*np.subtract(p, place))) for j, p in shown.items()}
    found = max(apart, key=lambda name: apart[name], default=joint)
    return found if apart.get(found, 0.0) > 0.0 else None


def _free_direction(pose: Pose, joint: str) -> float:
    """The direction from a joint that is farthest from all bars there."""
    place = pose.positions[joint]
    groups = [list(pose.shown(name).values()) for name in pose.mechanism.bodies]
    pairs = [(line.first, line.second) for line, _ in by_kind(springs_of(pose.mechanism)).lines]
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
    taken = np.array([*angles, *(ground_direction(pose, name) for name in bearings)] or [0.0])
    around = np.pi * (0.75 + np.arange(16) / 8.0)
    nearest = [float(np.cos(angle - taken).max()) for angle in around]
    return float(around[int(np.argmin(np.round(nearest, 6)))])
