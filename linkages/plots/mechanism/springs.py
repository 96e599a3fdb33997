"""Springs, dampers and cylinders of a drawing, along lines and in guides."""

from __future__ import annotations

import numpy as np

from linkages.components.contributed.measures import Load
from linkages.components.contributed.state_laws import NOTHING
from linkages.plots.mechanism import outlining
from linkages.plots.mechanism.blocks import BARREL, barrel_ends
from linkages.plots.mechanism.efforts import force_side
from linkages.plots.mechanism.frames import Frame, body_direction, joints, moved
from linkages.plots.mechanism.guides import grounded, half_length, mixed, pin_of, travel_of
from linkages.plots.mechanism.kinds import by_kind, springs_of
from linkages.plots.mechanism.outlining import CUP
from linkages.plots.mechanism.pose import Pose, SliderAxis
from linkages.plots.mechanism.senses import load_sense
from linkages.plots.mechanism.shapes import Anchor, Look, Shape, Strokes

SPRING, THRUST = Look("spring", 1.1), Look("cylinder", 1.1)
BESIDE = 13.0  # points between symbols that lie side by side
STUB = 9.0  # points from a joint to where they part
COIL, AMPLITUDE = 8.0, 4.5  # points along and across
COILS = (4, 14)
WALL, SERIES = 28.0, 48.0  # points from the last place of a block to a wall


def draw_springs(pose: Pose, scale: float) -> list[Shape]:
    """Springs, dampers and cylinders between joints; those of the same two lie side by side."""
    lines: dict[tuple[str, str], list[str]] = {}
    for ends, load in by_kind(springs_of(pose.mechanism)).lines:
        if {ends.first, ends.second} <= set(pose.positions):
            first, second = sorted((ends.first, ends.second))
            lines.setdefault((first, second), []).extend(_parts(load))
    found: list[Shape] = []
    for (first, second), parts in lines.items():
        way = np.subtract(pose.positions[second], pose.positions[first])
        length = scale * float(np.hypot(*way))
        if length == 0.0:
            continue
        frame = Frame(pose, joints(first, second))
        found += _abreast(frame, frame.at(first), frame.at(second), length, parts, BESIDE)
    return found


def _parts(load: Load) -> list[str]:
    if load.passive and load.states:  # of the spring, to which a damper is tied
        return ["series"]
    elastic = load.elastic or (load.passive and load.energy != NOTHING)
    thrusts = not (load.passive or load.absent)
    moving = ["cylinder"] if thrusts else ["damper"] * load.dissipates
    return ["spring"] * elastic + moving


def _abreast(
    frame: Frame, first: Anchor, second: Anchor, length: float, parts: list[str], beside: float
) -> list[Shape]:
    """Symbols side by side between two anchors that are so many points apart."""
    stub = min(STUB, 0.16 * length)
    start, end = moved(first, stub, 0.0), moved(second, -stub, 0.0)
    shifts = [beside * (index - 0.5 * (len(parts) - 1)) for index in range(len(parts))]
    found: list[Shape] = []
    for part, shift in zip(parts, shifts, strict=True):
        a, b = moved(start, 0.0, shift), moved(end, 0.0, shift)
        strokes: list[tuple[Anchor, ...]] = [(first, start, a), (b, end, second)]
        room = length - 2 * stub
        look = SPRING
        if part == "spring":
            strokes.append(_zigzag(a, b, room))
        elif part == "damper":
            strokes += _dashpot(a, b, room)
        elif part == "series":
            middle = mixed(a, b, 0.5)
            strokes += [_zigzag(a, middle, 0.5 * room), *_dashpot(middle, b, 0.5 * room)]
        else:
            strokes += _barrel(a, b, room)
            look = THRUST
        found.append(Strokes(tuple(strokes), look, frame.direction))
    return found


def _zigzag(first: Anchor, second: Anchor, length: float) -> tuple[Anchor, ...]:
    """Coils all along the way: they part as a spring is drawn out."""
    coils = int(np.clip(round(length / COIL), *COILS))
    shares = (np.arange(2 * coils) + 0.5) / (2 * coils)
    heights = min(AMPLITUDE, 0.3 * length) * (-1.0) ** np.arange(2 * coils)
    teeth = [
        moved(mixed(first, second, float(share)), 0.0, float(height))
        for share, height in zip(shares, heights, strict=True)
    ]
    return (first, *teeth, second)


def _dashpot(first: Anchor, second: Anchor, length: float) -> list[tuple[Anchor, ...]]:
    """A cup about the middle, and a piston in it."""
    middle, cup, half = mixed(first, second, 0.5), min(CUP[0], 0.6 * length), CUP[1]
    bottom = moved(middle, -0.5 * cup, 0.0)
    return [
        (first, bottom),
        tuple(moved(middle, *point) for point in outlining.cup(-0.5 * cup, 0.5 * cup, 0.0, half)),
        (moved(middle, 0.0, 0.7 * half), moved(middle, 0.0, -0.7 * half)),
        (middle, second),
    ]


def _barrel(first: Anchor, second: Anchor, length: float) -> list[tuple[Anchor, ...]]:
    """A barrel that ends with its own length, and a rod with a piston in it."""
    half = CUP[1]
    bottom, rim = moved(first, 0.08 * length, 0.0), moved(first, 0.62 * length, 0.0)
    piston = moved(second, -0.58 * length, 0.0)
    around = [moved(rim, 0.0, half), moved(bottom, 0.0, half), moved(bottom, 0.0, -half)]
    return [
        (first, bottom),
        (*around, moved(rim, 0.0, -half), moved(rim, 0.0, half)),
        (moved(piston, 0.0, 0.8 * half), moved(piston, 0.0, -0.8 * half)),
        (piston, second),
    ]


def draw_guide_springs(pose: Pose, scale: float) -> list[Shape]:
    """Springs and dampers in guides: from the block to a wall beyond its travel."""
    of_slider: dict[str, list[str]] = {}
    for slide, load in by_kind(springs_of(pose.mechanism)).slides:
        found = of_slider.setdefault(slide.body, [])
        if not load.pushes:
            found += _parts(load)
    shapes: list[Shape] = []
    for name, parts in of_slider.items():
        axis = pose.axis(name)
        if axis is None or not parts:
            continue
        barrel = None if grounded(pose, name) else barrel_ends(pose, name, axis)
        if barrel is not None:
            shapes += _beside_barrel(pose, name, axis, barrel[0], parts, scale)
            continue
        side, (low, high) = _damper_side(pose, name), travel_of(pose, name, axis)
        frame = Frame(pose, body_direction(pose, name))
        carrier = None if grounded(pose, name) else pose.mechanism.bodies[name].guide.body  # type: ignore[union-attr]
        last = high if side > 0 else low
        start = half_length(pose, name)
        room = SERIES if "series" in parts else WALL
        wall = frame.fixed(axis.at(last), carrier, (side * (start + room), 0.0))
        block = moved(pin_of(pose, name), side * start, 0.0)
        length = abs(last - axis.reach) * scale + room
        first, second = (block, wall) if side > 0 else (wall, block)
        shapes += _abreast(frame, first, second, length, parts, 10.0)
        half = 5.0 * len(parts)
        ends = (moved(wall, 0.0, half), moved(wall, 0.0, -half))
        shapes.append(frame.line(ends, SPRING, name))
    return shapes


def _beside_barrel(
    pose: Pose, name: str, axis: SliderAxis, bottom: float, parts: list[str], scale: float
) -> list[Shape]:
    """Beside a cylinder, from its bottom to the pin of its rod."""
    frame, guide = Frame(pose, body_direction(pose, name)), pose.mechanism.bodies[name].guide
    assert guide is not None
    side = 1.0 if axis.reach > bottom else -1.0
    ends = [frame.fixed(axis.at(bottom), guide.body), pin_of(pose, name)]
    aside = BARREL + 8.0 + 5.0 * (len(parts) - 1)
    stems = [(end, moved(end, 0.0, -aside)) for end in ends]
    first, second = (stem[1] for stem in (stems if side > 0 else stems[::-1]))
    length = scale * abs(axis.reach - bottom)
    shapes = _abreast(frame, first, second, length, parts, 10.0)
    return [*shapes, Strokes(tuple(stems), SPRING, frame.direction)]


def _damper_side(pose: Pose, name: str) -> int:
    """Where a damper finds room: where no bars are, unless a force stands there."""
    slides = by_kind(springs_of(pose.mechanism)).slides
    forces = [load for slide, load in slides if slide.body == name and load.pushes]
    side = force_side(pose, name, -1)
    stands = [force_side(pose, name, load_sense(load, pose.mechanism)) for load in forces]
    return -side if side in stands else side
