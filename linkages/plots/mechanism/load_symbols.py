"""Springs, dampers, friction and stops."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np

from linkages.components.contributed.load_measures import GROUND, Distance, Load, Slide, Turn
from linkages.components.contributed.state_laws import NOTHING
from linkages.components.stops import AngleStop, DistanceStop, GuideStop
from linkages.plots.mechanism import guide_symbols as guides
from linkages.plots.mechanism import roles
from linkages.plots.mechanism.efforts import force_side
from linkages.plots.mechanism.placing import (
    Frame,
    at_joint,
    body_direction,
    joints,
    mixed,
    moved,
    spanned,
)
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.shapes import (
    BENT,
    BLOCK,
    CLEARANCE_RING,
    PIN,
    SPANS,
    Anchor,
    Direction,
    Look,
    Shape,
    Stroke,
    Strokes,
    arc,
    bent_dashpot,
    hatching,
    mirrored,
    spiral,
    spiral_and_dashpot,
)
from linkages.reading.paths import dotted

SPRING = Look("spring", 1.1)
LOOKS = {"cylinder": Look("cylinder", 1.1), "actuator": Look("driven", 1.1)}
BESIDE = 13.0  # points between symbols that lie side by side
STUB = 9.0  # points from a joint to where they part
WALL, SERIES = 28.0, 48.0  # points from the last place of a block to a wall


def draw_springs(pose: Pose, scale: float) -> list[Shape]:
    """Springs, dampers and cylinders between joints; those of the same two lie side by side."""
    lines: dict[tuple[str, str], list[str]] = {}
    springs = roles.measured(roles.springs_of(pose.mechanism), Distance)
    drawn = [(ends, _parts(load)) for ends, load in springs]
    measures = (own.measure for own in pose.mechanism.actuations.values())
    drawn += [(measure, ["actuator"]) for measure in measures if isinstance(measure, Distance)]
    for ends, parts in drawn:
        if {ends.first, ends.second} <= set(pose.positions):
            first, second = sorted((ends.first, ends.second))
            lines.setdefault((first, second), []).extend(parts)
    result: list[Shape] = []
    for (first, second), parts in lines.items():
        way = np.subtract(pose.positions[second], pose.positions[first])
        if length := scale * float(np.hypot(*way)):
            ends_ = at_joint(first), at_joint(second)
            result += _abreast(joints(first, second), *ends_, length, parts, BESIDE)
    return result


def _parts(load: Load) -> list[str]:
    if load.passive and load.states:  # of the spring, to which a damper is tied
        return ["series"]
    elastic = load.elastic or (load.passive and load.energy != NOTHING)
    thrusts = not (load.passive or load.absent)
    moving = ["cylinder"] if thrusts else ["damper"] * load.dissipates
    return ["spring"] * elastic + moving


def _abreast(
    direction: Direction, first: Anchor, second: Anchor, length: float, parts: list[str],
    beside: float,
) -> list[Shape]:  # fmt: skip
    """Symbols side by side between two anchors that are so many points apart."""
    stub = min(STUB, 0.16 * length)
    start, end = moved(first, stub, 0.0), moved(second, -stub, 0.0)
    result: list[Shape] = []
    for index, part in enumerate(parts):
        shift = beside * (index - 0.5 * (len(parts) - 1))
        a, b = moved(start, 0.0, shift), moved(end, 0.0, shift)
        span = spanned(a, b, SPANS[part](length - 2 * stub))
        strokes = ((first, start, a), (b, end, second), *span)
        result.append(Strokes(strokes, LOOKS.get(part, SPRING), direction))
    return result


def draw_guide_springs(pose: Pose, scale: float) -> list[Shape]:
    """Springs and dampers in guides: from the block to a wall beyond its travel."""
    of_slider: dict[str, list[str]] = {}
    for slide, load in roles.measured(roles.springs_of(pose.mechanism), Slide):
        of_slider.setdefault(slide.body, []).extend([] if load.pushes else _parts(load))
    shapes: list[Shape] = []
    for name, parts in of_slider.items():
        slider = guides.slider_of(pose, name)
        if slider is None or not parts:
            continue
        barrel = None if slider.grounded else guides.barrel_ends(slider)
        if barrel is not None:
            shapes += _beside_barrel(slider, barrel[0], parts, scale)
            continue
        side, (low, high), frame = _damper_side(slider), slider.travel, slider.frame
        last, start = high if side > 0 else low, slider.half[0]
        room = SERIES if "series" in parts else WALL
        wall = slider.fixed(last, (side * (start + room), 0.0))
        block = moved(slider.pin, side * start, 0.0)
        length = abs(last - slider.axis.reach) * scale + room
        first, second = (block, wall) if side > 0 else (wall, block)
        shapes += _abreast(frame.direction, first, second, length, parts, 10.0)
        half = 5.0 * len(parts)
        shapes.append(frame.line((moved(wall, 0.0, half), moved(wall, 0.0, -half)), SPRING, name))
    return shapes


def _beside_barrel(
    slider: guides.DrawnSlider, bottom: float, parts: list[str], scale: float
) -> list[Shape]:
    """Beside a cylinder, from its bottom to the pin of its rod."""
    aside = guides.BARREL + 8.0 + 5.0 * (len(parts) - 1)
    stems = [(end, moved(end, 0.0, -aside)) for end in (slider.fixed(bottom), slider.pin)]
    first, second = (stem[1] for stem in (stems if slider.axis.reach > bottom else stems[::-1]))
    length, direction = scale * abs(slider.axis.reach - bottom), slider.frame.direction
    shapes = _abreast(direction, first, second, length, parts, 10.0)
    return [*shapes, Strokes(tuple(stems), SPRING, direction)]


def _damper_side(slider: guides.DrawnSlider) -> int:
    """Where a damper finds room: where no bars are, unless a force stands there."""
    mechanism = slider.pose.mechanism
    slides = roles.measured(roles.springs_of(mechanism), Slide)
    forces = [load for slide, load in slides if slide.body == slider.name and load.pushes]
    side = force_side(slider, -1)
    stands = [force_side(slider, roles.load_sense(load, mechanism)) for load in forces]
    return -side if side in stands else side


OUTER = 15.0  # points: radius of a bent dashpot around a spiral


def draw_torsional(pose: Pose) -> list[Shape]:
    """Spirals of torsional springs and bent dashpots of torsional dampers."""
    taken: Counter[str] = Counter()
    result: list[Shape] = []
    frictions = roles.measured(roles.frictions_of(pose.mechanism), Turn)
    rubbing = {pivot(pose, turn) for turn, _ in frictions}
    for turn, load in roles.measured(roles.springs_of(pose.mechanism), Turn):
        joint = pivot(pose, turn)
        if load.given or load.applied or joint is None:
            continue
        full = load.elastic or taken[joint] or joint in rubbing
        free = Frame(pose, Direction(_free_direction(pose, joint) + np.pi * taken[joint]))
        taken[joint] += 1
        symbols = []
        if load.states:  # a spring, to which a damper is tied
            symbols.append((free, spiral_and_dashpot(OUTER)))
        else:
            if load.elastic:
                symbols.append((_along(pose, turn.body, joint), [spiral()]))
            if load.dissipates:
                symbols.append((free, bent_dashpot(OUTER if full else BENT)))
        result += [
            frame.symbol(at_joint(joint), strokes, SPRING, name=joint) for frame, strokes in symbols
        ]
    return result


def pivot(pose: Pose, turn: Turn) -> str | None:
    """Where one body turns against another (None: the ground): a joint of both, if there is one.

    Otherwise a joint of the body.
    """
    shown = pose.shown(turn.body)
    others = pose.mechanism.ground if turn.reference is None else pose.shown(turn.reference)
    return next((joint for joint in shown if joint in others), next(iter(shown), None))


def _along(pose: Pose, body: str, joint: str) -> Frame:
    """A frame from a joint of a body to the one that is farthest away, or of the body itself."""
    shown, place = pose.shown(body), pose.positions[joint]
    apart = {j: float(np.hypot(*np.subtract(p, place))) for j, p in shown.items()}
    far = max(apart, key=lambda name: apart[name], default=joint)
    return Frame(pose, joints(joint, far) if apart.get(far, 0.0) > 0.0 else Direction(body=body))


def _free_direction(pose: Pose, joint: str) -> float:
    """The direction from a joint that is farthest from all bars there."""
    place = pose.positions[joint]
    groups = [list(pose.shown(name).values()) for name in pose.mechanism.bodies]
    springs = roles.measured(roles.springs_of(pose.mechanism), Distance)
    pairs = [(line.first, line.second) for line, _ in springs]
    groups += [[pose.positions[j] for j in pair if j in pose.positions] for pair in pairs]
    ways = [
        np.subtract(p, place) for group in groups if place in group for p in group if p != place
    ]
    bearings = [j for j in pose.mechanism.ground if pose.positions.get(j) == place]
    angles = [np.arctan2(way[1], way[0]) for way in ways]
    taken = np.array([*angles, *(roles.ground_direction(pose, name) for name in bearings)] or [0.0])
    around = np.pi * (0.75 + np.arange(16) / 8.0)
    nearest = [float(np.cos(angle - taken).max()) for angle in around]
    return float(around[int(np.argmin(np.round(nearest, 6)))])


SHOE, HATCH = Look("friction", 0.8, "paper"), Look("friction", 0.7)
THICK = 3.8  # points: of a shoe
ROD, SHORT = 1.9, 6.0  # points: half the height of a rod; half the length of a lining beside it


class Lining(NamedTuple):
    """What rubs on both faces of a slider: around an anchor, half as long, from here to there."""

    centre: Anchor
    half: float
    inner: float
    outer: float


def draw_linings(pose: Pose, scale: float) -> list[Shape]:
    """What rubs in guides, on the faces of blocks and beside rods, and along lines."""
    result: list[Shape] = []
    frictions = roles.frictions_of(pose.mechanism)
    for ends, load in roles.measured(frictions, Distance):
        if {ends.first, ends.second} <= set(pose.positions):
            frame = Frame(pose, joints(ends.first, ends.second))
            pair, name = (at_joint(ends.first), at_joint(ends.second)), dotted(load.path)
            result.append(frame.line(pair, SHOE, name))
            centre = mixed(*pair, 0.5)
            result += _hatched(frame, centre, _linings(Lining(centre, SHORT, ROD, ROD + 2.8)), name)
    for name in dict.fromkeys(slide.body for slide, _ in roles.measured(frictions, Slide)):
        if (slider := guides.slider_of(pose, name)) is not None:
            lining = _lining(slider, scale)
            result += _hatched(slider.frame, lining.centre, _linings(lining), name)
    return result


def draw_shoes(pose: Pose) -> list[Shape]:
    """What rubs at joints, beside their pins or bearings."""
    result: list[Shape] = []
    rings = roles.clearance_ends(pose.mechanism).values()
    for turn, _ in roles.measured(roles.frictions_of(pose.mechanism), Turn):
        if joint := pivot(pose, turn):
            inner = (CLEARANCE_RING if joint in rings else PIN) + 1.3
            frame = _along(pose, turn.body, joint)
            result += _hatched(frame, at_joint(joint), _shoes(inner, inner + THICK), joint)
    return result


Hatched = list[tuple[Stroke, list[Stroke]]]
"""Outlines and the strokes in them."""


def _hatched(frame: Frame, centre: Anchor, parts: Hatched, name: str) -> list[Shape]:
    strokes = [stroke for _, inside in parts for stroke in inside]
    return [
        frame.symbol(centre, [edge for edge, _ in parts], SHOE, closed=True, name=name),
        frame.symbol(centre, strokes, HATCH, name=name),
    ]


def _shoes(inner: float, outer: float) -> Hatched:
    """Two shoes, left and right of the direction that goes along."""
    result: Hatched = []
    half = min(0.95, 5.6 / inner)
    for middle in (0.5 * np.pi, -0.5 * np.pi):
        first, last = middle - half, middle + half
        edge = [*arc(inner, first, last, 13), *arc(outer, last, first, 13)]
        feet = arc(inner, first, last - 0.22 * half, 6), arc(outer, first + 0.22 * half, last, 6)
        result.append((edge, [[a, b] for a, b in zip(*feet, strict=True)]))
    return result


def _lining(slider: guides.DrawnSlider, scale: float) -> Lining:
    (half, face), thick = slider.half, 2.8 if slider.grounded else 2.0
    on_block = Lining(slider.pin, half - 1.0, face - thick, face)
    if slider.grounded:
        side = guides.rod_side(slider, scale)
        if not side:
            return on_block
        last = slider.fixed(slider.travel[side > 0])
        return Lining(moved(last, side * guides.APART, 0.0), SHORT, ROD, ROD + 2.8)
    ends = guides.barrel_ends(slider)
    if ends is None:
        return on_block
    bottom, rim = ends
    inward = float(np.sign(bottom - rim) * (SHORT + 1.0))
    return Lining(slider.fixed(rim, (inward, 0.0)), SHORT, ROD, guides.BARREL - 0.6)


def _linings(lining: Lining) -> Hatched:
    """Over the axis and below it."""
    result: Hatched = []
    _, half, inner, outer = lining
    for side in (1.0, -1.0):
        low, high = side * inner, side * outer
        feet = np.linspace(-half, half - 2.0, max(3, round(half / 1.4))).tolist()
        edge = [(-half, low), (half, low), (half, high), (-half, high)]
        result.append((edge, [[(x, low), (x + 2.0, high)] for x in feet]))
    return result


EDGE = (9.0, 21.0)  # points from a pin to both ends of an edge that a bar meets
STOP = Look("ink", 1.0)


def draw_stops(pose: Pose) -> list[Shape]:
    """All stops whose place is known: hatched walls and edges, and ropes."""
    result: list[Shape] = []
    for stop in pose.mechanism.components:
        match stop:
            case GuideStop():
                result += _walls(pose, stop)
            case AngleStop():
                result += _edges(pose, stop)
            case DistanceStop(between=(first, second)):
                if {first, second} <= set(pose.positions):
                    rope = Look("ink", 0.8, dashes=(4.0, 3.0))
                    ends = at_joint(first), at_joint(second)
                    result.append(Strokes((ends,), rope, joints(first, second)))
    return result


def _walls(pose: Pose, stop: GuideStop) -> list[Shape]:
    """A hatched wall where the block of a slider meets it."""
    slider = guides.slider_of(pose, stop.slider)
    if slider is None:
        return []
    across = hatching(-BLOCK[1], BLOCK[1], -slider.half[0])
    result: list[Shape] = []
    for limit, side in ((stop.lower, -1.0), (stop.upper, 1.0)):
        if limit is not None:
            strokes = [[(-side * y, x) for x, y in stroke] for stroke in across]
            centre = slider.fixed(limit * pose.unit)
            result.append(slider.frame.symbol(centre, strokes, STOP, name=stop.slider))
    return result


def _edges(pose: Pose, stop: AngleStop) -> list[Shape]:
    """Hatched edges beside a pin, where the line between a bar's joints meets them."""
    first, second = stop.bars
    others = pose.mechanism.ground if first == GROUND else pose.shown(first)
    joint = next((name for name in pose.shown(second) if name in others), None)
    apart = pose.apart(second)
    if joint is None or apart is None:
        return []
    # from the pin, a bar may lie in the other direction than its own axis
    own = apart[2] + (np.pi if joint == apart[1] else 0.0)
    edge, result = hatching(*EDGE, 0.0), list[Shape]()
    for limit, strokes in ((stop.lower, edge), (stop.upper, mirrored(edge))):
        if limit is not None:
            body = None if first == GROUND else first
            frame = Frame(pose, body_direction(pose, body, float(own + limit)))
            result.append(frame.symbol(at_joint(joint), strokes, STOP, name=second))
    return result
