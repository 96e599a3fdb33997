"""Arrows of a drawing: drives, forces and torques, with the sizes that are written at them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from linkages.components.contributed.functions import Number
from linkages.components.contributed.load_measures import (
    BodyAxis,
    Load,
    Slide,
    Turn,
    named,
)
from linkages.components.contributed.terms import GUIDED
from linkages.plots.mechanism.guide_symbols import DrawnSlider, rod_side, slider_of
from linkages.plots.mechanism.placing import Frame, at_joint, body_direction, joints, moved
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.roles import (
    BOTH,
    AtJoint,
    at_joints,
    drive_sense,
    force_direction,
    load_sense,
    measured,
)
from linkages.plots.mechanism.shapes import (
    BLOCK,
    MASS,
    PIN,
    SMALL_BLOCK,
    Anchor,
    Direction,
    Disc,
    Look,
    Shape,
    Stroke,
    Word,
    arc,
    arrow_head,
)
from linkages.plots.style import scale_for

RADII, SPAN = (6.5, 18.0), 1.9  # of the arrow about a driven body's pin
SHORT, OUTSIDE, LONG = 20.0, 10.0, 26.0
"""Points: cranks with an arrow beyond their ends, how far beyond, and how long it is."""

TORQUE, TORQUE_SPAN = (6.0, 10.0), 4.2
RING = PIN + 3.0  # points: about a joint that a drive moves
STRAIGHT = 23.0
SHAFT = 1.2


def draw_drives(pose: Pose, scale: float) -> list[Shape]:
    """The sense in which each drive moves its body; nothing for one that stands still."""
    mechanism = pose.mechanism
    result: list[Shape] = []
    for name in mechanism.prescribed:
        sense = drive_sense(mechanism, name)
        if not mechanism.bodies[name].rotates:
            result += _beside_block(slider_of(pose, name), sense, "driven", scale, over=True)
            continue
        shown = sorted(pose.shown(name), key=lambda joint: joint not in mechanism.ground)
        if len(shown) > 1 and sense:
            way = np.subtract(pose.positions[shown[1]], pose.positions[shown[0]])
            length = scale * float(np.hypot(*way))
            radius = float(np.clip(0.55 * length, *RADII))
            span = min(SPAN, SPAN * length / RADII[0])
            if length < SHORT:  # no room between its pins: beyond the outer one
                radius, span = length + OUTSIDE, LONG / (length + OUTSIDE)
            frame = Frame(pose, joints(shown[0], shown[1]))
            result += _arc(frame, at_joint(shown[0]), radius, 0.0, span, sense, "driven", name)
    guided = (body for body in mechanism.bodies.values() if body.kind == GUIDED)
    for joint in dict.fromkeys(joint for body in guided for joint in body.points):
        if joint in pose.positions:
            ring = Look("driven", 2.0 * SHAFT)
            result.append(Disc(at_joint(joint), ring, points=RING, name=joint))
    for actuation in mechanism.actuations.values():
        match actuation.measure:
            case Turn(body) as turn if spot := _torque_spot(pose, turn, pinned=True):
                result += _about(pose, spot, body, 0.0, BOTH, "driven", scale)
            case Slide(body):
                result += _beside_block(slider_of(pose, body), BOTH, "driven", scale, over=True)
    return result


def _about(
    pose: Pose, spot: Anchor, body: str, middle: float, sense: int, role: str, scale: float
) -> list[Shape]:
    """The arc of a torque on a body."""
    places = np.array(list(pose.shown(body).values()))
    span = float(np.hypot(*np.ptp(places, axis=0)))
    frame = Frame(pose, body_direction(pose, body))
    radius = float(np.clip(0.3 * scale * span, *TORQUE))
    return _arc(frame, spot, radius, middle, TORQUE_SPAN, sense, role, body)


def _arc(
    frame: Frame, centre: Anchor, radius: float, middle: float, span: float, sense: int, role: str,
    name: str,
) -> list[Shape]:  # fmt: skip
    half = -0.5 * span if sense < 0 else 0.5 * span
    return _arrow(frame, centre, arc(radius, middle - half, middle + half), sense, role, name)


def _arrow(
    frame: Frame, centre: Anchor, line: Stroke, sense: int, role: str, name: str
) -> list[Shape]:
    """A line in points about an anchor with a head at its end, or with one at both."""
    heads = [arrow_head(line), *([arrow_head(line[::-1])] if sense == BOTH else [])]
    shaft = [line[1 if sense == BOTH else 0 : -1]]
    return [
        frame.symbol(centre, shaft, Look(role, SHAFT), name=name),
        frame.symbol(centre, heads, Look(role, 0.3, role), closed=True, name=name),
    ]


def draw_forces(pose: Pose, scale: float) -> list[Shape]:
    """Arrows of forces at joints and blocks, arcs of torques on bodies, and words at them."""
    mechanism, loads = pose.mechanism, pose.mechanism.loads
    result: list[Shape] = []
    for (_, joint), force in at_joints(loads).items():
        frame, sense = _along(pose, force)
        if sense and frame is not None and joint in pose.positions:
            line = _straight(MASS + 1.0, 0.0, sense)
            result += _arrow(frame, at_joint(joint), line, sense, "load", joint)
            tip = at_joint(joint, (STRAIGHT if sense == BOTH else sense * (STRAIGHT + MASS), 0.0))
            result += _size([load for _, load in force], tip, 4.0, joint, frame.direction)
    for turn, torque in measured(loads, Turn):
        spot = _torque_spot(pose, turn) if torque.given or torque.applied else None
        if spot:
            if sense := load_sense(torque, mechanism):
                result += _about(pose, spot, turn.body, 0.5 * np.pi, sense, "load", scale)
            result += _size([torque], spot, TORQUE[1] + 3.0, turn.body)
    for slide, load in measured(loads, Slide):
        sense, slider = load_sense(load, mechanism), slider_of(pose, slide.body)
        if load.pushes and sense and slider is not None:
            result += _beside_block(slider, sense, "load", scale)
            side = force_side(slider, sense)
            end, gap = moved(slider.pin, side * (STRAIGHT + 8.0), 0.0), 4.0 if side else 16.0
            result += _size([load], end, gap, slide.body, slider.frame.direction)
    return result


def _straight(start: float, across: float, sense: int) -> Stroke:
    """From a start along the way in which a force points; about the middle for both ways."""
    if sense == BOTH:
        start = -0.5 * STRAIGHT - 3.0
        ends = np.linspace(start, -start, 15)
    else:
        ends = float(np.sign(sense)) * np.linspace(start, start + STRAIGHT, 15)
    return [(float(x), across) for x in ends]


def _beside_block(
    slider: DrawnSlider | None, sense: int, role: str, scale: float, *, over: bool = False
) -> list[Shape]:
    """An arrow over a block, or before or behind it: pulling or pushing."""
    if slider is None or sense == 0:
        return []
    side = 0 if over else force_side(slider, sense)
    if side and slider.grounded and rod_side(slider, scale) == side:
        side = 0  # there is the rod of the slider
    half, height = BLOCK if slider.grounded else SMALL_BLOCK
    if side == 0:
        line = _straight(-half if sense != BOTH else 0.0, height + 8.0, sense)
    else:
        ends = np.linspace(half + 2.0, half + 2.0 + STRAIGHT, 15)
        line = [(float(side * x), 0.0) for x in (ends if side == sense else ends[::-1])]
    return _arrow(slider.frame, slider.pin, line, sense, role, slider.name)


def force_side(slider: DrawnSlider, sense: int) -> int:
    """On which side of a slider, along its axis, an arrow of a force stands: where no bars are.

    There it pulls at the block, or pushes it, as its sense wants. 0 for a force of both senses,
    whose arrow stands over the block.
    """
    if sense == BOTH:
        return 0
    pose, block = slider.pose, slider.block
    shown = pose.shown(block)
    balance = sum(
        float(np.subtract(other, shown[joint]) @ slider.along)
        for joint in shown
        for body in pose.mechanism.bodies
        if body != block and joint in pose.shown(body)
        for other in pose.shown(body).values()
    )
    if abs(balance) < 1e-6 * pose.extent:
        return sense
    return -1 if balance > 0.0 else 1


def _along(pose: Pose, force: Sequence[tuple[AtJoint, Load]]) -> tuple[Frame | None, int]:
    """Direction of a force in the plane and its sense, 0 where its body is not shown."""
    angle, sense = force_direction(force, pose.mechanism)
    measure = force[0][0]
    body = measure.body if isinstance(measure, BodyAxis) else None
    if body is not None and pose.angle(body) is None:
        return None, 0
    return Frame(pose, body_direction(pose, body, angle)), sense


def _size(
    loads: list[Load], place: Anchor, gap: float, name: str, direction: Direction | None = None
) -> list[Word]:
    """The magnitude of loads that are one arrow, or the symbol of what varies; none for zero."""
    turning = loads[0].twists
    numbers = [load.law.parameter.value for load in loads if isinstance(load.law, Number)]
    if len(numbers) < len(loads):
        result = dict.fromkeys(name for load in loads for name in named(load.law))
        text = f"{'M' if turning else 'F'}({', '.join(result)})"
    elif size := float(np.hypot.reduce(numbers)) if len(numbers) > 1 else abs(numbers[0]):
        text = scale_for(size, "N·m" if turning else "N").text(size)
    else:
        return []
    return [Word(text, (place,), Look("load"), gap, direction or Direction(), name)]


def _torque_spot(pose: Pose, turn: Turn, *, pinned: bool = False) -> Anchor | None:
    """The joint between two bodies; the middle, or the pin, of one that the ground turns."""
    shown = list(pose.shown(turn.body))
    if not shown:
        return None
    pins = [joint for joint in shown if joint in pose.mechanism.ground]
    if turn.reference is None and pins and pinned:
        return at_joint(pins[0])
    if turn.reference is None:
        return Anchor(tuple((joint, 1.0 / len(shown)) for joint in shown))
    others = pose.shown(turn.reference)
    return at_joint(next((joint for joint in shown if joint in others), shown[0]))
