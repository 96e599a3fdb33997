"""Springs, dampers, friction and stops."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np

from linkages.components.contributed.load_measures import GROUND, Distance, Load, Turn
from linkages.components.contributed.state_laws import NOTHING
from linkages.components.stops import AngleStop, DistanceStop, GuideStop
from linkages.plots.mechanism import shapes as outlining
from linkages.plots.mechanism.efforts import force_side
from linkages.plots.mechanism.guide_symbols import (
    APART,
    BARREL,
    barrel_ends,
    grounded,
    half_length,
    mixed,
    pin_of,
    play_of,
    rod_side,
    travel_of,
)
from linkages.plots.mechanism.placing import Frame, body_direction, joints, moved
from linkages.plots.mechanism.pose import Pose, SliderAxis
from linkages.plots.mechanism.roles import (
    by_kind,
    clearance_ends,
    frictions_of,
    ground_direction,
    load_sense,
    springs_of,
    stops_of,
)
from linkages.plots.mechanism.shapes import (
    BENT,
    BLOCK,
    CLEARANCE_RING,
    CUP,
    PIN,
    ROOM,
    SMALL_BLOCK,
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

SPRING, THRUST, ACTUATOR = (Look(role, 1.1) for role in ("spring", "cylinder", "driven"))
BESIDE = 13.0  # points between symbols that lie side by side
STUB = 9.0  # points from a joint to where they part
COIL, AMPLITUDE = 8.0, 4.5  # points along and across
COILS = (4, 14)
WALL, SERIES = 28.0, 48.0  # points from the last place of a block to a wall


def draw_springs(pose: Pose, scale: float) -> list[Shape]:
    """Springs, dampers and cylinders between joints; those of the same two lie side by side."""
    lines: dict[tuple[str, str], list[str]] = {}
    drawn = [(ends, _parts(load)) for ends, load in by_kind(springs_of(pose.mechanism)).lines]
    measures = (own.measure for own in pose.mechanism.actuations.values())
    drawn += [(measure, ["actuator"]) for measure in measures if isinstance(measure, Distance)]
    for ends, parts in drawn:
        if {ends.first, ends.second} <= set(pose.positions):
            first, second = sorted((ends.first, ends.second))
            lines.setdefault((first, second), []).extend(parts)
    result: list[Shape] = []
    for (first, second), parts in lines.items():
        way = np.subtract(pose.positions[second], pose.positions[first])
        length = scale * float(np.hypot(*way))
        if length == 0.0:
            continue
        frame = Frame(pose, joints(first, second))
        result += _abreast(frame, frame.at(first), frame.at(second), length, parts, BESIDE)
    return result


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
    result: list[Shape] = []
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
            look = THRUST if part == "cylinder" else ACTUATOR
        result.append(Strokes(tuple(strokes), look, frame.direction))
    return result


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
        result = of_slider.setdefault(slide.body, [])
        if not load.pushes:
            result += _parts(load)
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


OUTER = 15.0
"""Points: radius of a bent dashpot around a spiral."""


def draw_torsional(pose: Pose) -> list[Shape]:
    """Spirals of torsional springs and bent dashpots of torsional dampers."""
    taken: Counter[str] = Counter()
    result: list[Shape] = []
    rubbing = {pivot(pose, turn) for turn, _ in by_kind(frictions_of(pose.mechanism)).turns}
    for turn, load in by_kind(springs_of(pose.mechanism)).turns:
        joint = pivot(pose, turn)
        if load.given or load.applied or joint is None:
            continue
        full = load.elastic or taken[joint] or joint in rubbing
        free = Frame(pose, Direction(_free_direction(pose, joint) + np.pi * taken[joint]))
        taken[joint] += 1
        if load.states:  # a spring, to which a damper is tied
            strokes = spiral_and_dashpot(OUTER)
            result.append(free.symbol(free.at(joint), strokes, SPRING, name=joint))
            continue
        if load.elastic:
            far = farthest(pose, turn.body, joint)
            frame = Frame(pose, Direction(body=turn.body) if far is None else joints(joint, far))
            result.append(frame.symbol(frame.at(joint), [spiral()], SPRING, name=joint))
        if load.dissipates:
            strokes = bent_dashpot(OUTER if full else BENT)
            result.append(free.symbol(free.at(joint), strokes, SPRING, name=joint))
    return result


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
    result = max(apart, key=lambda name: apart[name], default=joint)
    return result if apart.get(result, 0.0) > 0.0 else None


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


SHOE, HATCH = Look("friction", 0.8, "paper"), Look("friction", 0.7)
THICK = 3.8
"""Points: of a shoe."""

ROD, SHORT = 1.9, 6.0
"""Points: half the height of a rod; half the length of a lining beside it."""


class Lining(NamedTuple):
    """What rubs on both faces of a slider: around an anchor, half as long, from here to there."""

    centre: Anchor
    half: float
    inner: float
    outer: float


def draw_linings(pose: Pose, scale: float) -> list[Shape]:
    """What rubs in guides, on the faces of blocks and beside rods, and along lines."""
    result: list[Shape] = []
    kinds = by_kind(frictions_of(pose.mechanism))
    for ends, load in kinds.lines:
        if {ends.first, ends.second} <= set(pose.positions):
            frame = Frame(pose, joints(ends.first, ends.second))
            name = dotted(load.path)
            result.append(frame.line((frame.at(ends.first), frame.at(ends.second)), SHOE, name))
            centre = frame.between(ends.first, ends.second, 0.5)
            result += _hatched(frame, centre, _linings(Lining(centre, SHORT, ROD, ROD + 2.8)), name)
    for name in dict.fromkeys(slide.body for slide, _ in kinds.slides):
        lining = _lining(pose, name, scale)
        if lining is not None:
            frame = Frame(pose, body_direction(pose, name))
            result += _hatched(frame, lining.centre, _linings(lining), name)
    return result


def draw_shoes(pose: Pose) -> list[Shape]:
    """What rubs at joints, beside their pins or bearings."""
    result: list[Shape] = []
    for turn, _ in by_kind(frictions_of(pose.mechanism)).turns:
        joint = pivot(pose, turn)
        if joint is not None:
            far = farthest(pose, turn.body, joint)
            frame = Frame(pose, Direction(body=turn.body) if far is None else joints(joint, far))
            ring = joint in clearance_ends(pose.mechanism).values()
            inner = (CLEARANCE_RING if ring else PIN) + 1.3
            result += _hatched(frame, frame.at(joint), _shoes(inner, inner + THICK), joint)
    return result


Hatched = list[tuple[Stroke, list[Stroke]]]
"""Outlines and the strokes in them."""


def _hatched(frame: Frame, centre: Anchor, parts: Hatched, name: str) -> list[Shape]:
    edges = [edge for edge, _ in parts]
    strokes = [stroke for _, inside in parts for stroke in inside]
    return [
        frame.symbol(centre, edges, SHOE, closed=True, name=name),
        frame.symbol(centre, strokes, HATCH, name=name),
    ]


def _shoes(inner: float, outer: float) -> Hatched:
    """Two shoes, left and right of the direction that goes along."""
    result: Hatched = []
    half = min(0.95, 5.6 / inner)
    for middle in (0.5 * np.pi, -0.5 * np.pi):
        first, last = middle - half, middle + half
        edge = [*arc(inner, first, last, 13), *arc(outer, last, first, 13)]
        angles = np.linspace(first, last - 0.22 * half, 6)
        ways = [(a, a + 0.22 * half) for a in angles]
        strokes = [
            [(inner * float(np.cos(a)), inner * float(np.sin(a))),
             (outer * float(np.cos(b)), outer * float(np.sin(b)))]
            for a, b in ways
        ]  # fmt: skip
        result.append((edge, strokes))
    return result


def _lining(pose: Pose, name: str, scale: float) -> Lining | None:
    axis = pose.axis(name)
    if axis is None:
        return None
    frame, guide = Frame(pose, body_direction(pose, name)), pose.mechanism.bodies[name].guide
    assert guide is not None
    loose = play_of(pose, name) is not None
    if grounded(pose, name):
        side = rod_side(pose, name, axis, scale)
        if not side:
            face = BLOCK[1] - ROOM * loose
            return Lining(pin_of(pose, name), BLOCK[0] - 1.0, face - 2.8, face)
        low, high = travel_of(pose, name, axis)
        last = frame.fixed(axis.at(high if side > 0 else low), None)
        return Lining(moved(last, side * APART, 0.0), SHORT, ROD, ROD + 2.8)
    ends = barrel_ends(pose, name, axis)
    if ends is None:
        face = SMALL_BLOCK[1] - 0.7 * ROOM * loose
        return Lining(pin_of(pose, name), SMALL_BLOCK[0] - 1.0, face - 2.0, face)
    bottom, rim = ends
    end = frame.fixed(axis.at(rim), guide.body)
    inward = np.sign(bottom - rim) * (SHORT + 1.0)
    return Lining(moved(end, float(inward), 0.0), SHORT, ROD, BARREL - 0.6)


def _linings(lining: Lining) -> Hatched:
    """Over the axis and below it."""
    result: Hatched = []
    _, half, inner, outer = lining
    for side in (1.0, -1.0):
        edge = [(-half, side * inner), (half, side * inner),
                (half, side * outer), (-half, side * outer)]  # fmt: skip
        feet = np.linspace(-half, half - 2.0, max(3, round(half / 1.4))).tolist()
        result.append((edge, [[(x, side * inner), (x + 2.0, side * outer)] for x in feet]))
    return result


EDGE = (9.0, 21.0)
"""Points from a pin to both ends of an edge that a bar meets."""


def draw_stops(pose: Pose) -> list[Shape]:
    """All stops whose place is known."""
    result: list[Shape] = []
    for stop in stops_of(pose.mechanism):
        match stop:
            case GuideStop():
                result += _walls(pose, stop)
            case AngleStop():
                result += _edges(pose, stop)
            case DistanceStop():
                result += _rope(pose, stop)
    return result


def _walls(pose: Pose, stop: GuideStop) -> list[Shape]:
    """A hatched wall where the block of a slider meets it."""
    axis = pose.axis(stop.slider)
    if axis is None:
        return []
    frame = Frame(pose, body_direction(pose, stop.slider))
    guide = pose.mechanism.bodies[stop.slider].guide
    carrier = None if guide is None or grounded(pose, stop.slider) else guide.body
    result: list[Shape] = []
    for limit, side in ((stop.lower, -1.0), (stop.upper, 1.0)):
        if limit is not None:
            across = hatching(-BLOCK[1], BLOCK[1], -half_length(pose, stop.slider))
            strokes = [[(-side * y, x) for x, y in stroke] for stroke in across]
            centre = frame.fixed(axis.at(limit * pose.unit), carrier)
            result.append(frame.symbol(centre, strokes, Look("ink", 1.0), name=stop.slider))
    return result


def _edges(pose: Pose, stop: AngleStop) -> list[Shape]:
    """Hatched edges beside a pin, where the line between a bar's joints meets them."""
    first, second = stop.bars
    shown = pose.shown(second)
    others = pose.mechanism.ground if first == GROUND else pose.shown(first)
    joint = next((name for name in shown if name in others), None)
    apart = pose.apart(second)
    if joint is None or apart is None:
        return []
    # from the pin, a bar may lie in the other direction than its own axis
    own = apart[2] + (np.pi if joint == apart[1] else 0.0)
    result: list[Shape] = []
    for limit, side in ((stop.lower, -1.0), (stop.upper, 1.0)):
        if limit is not None:
            angle = float(own + limit)
            frame = Frame(pose, body_direction(pose, None if first == GROUND else first, angle))
            edge = hatching(*EDGE, 0.0)
            strokes = edge if side < 0 else mirrored(edge)
            result.append(frame.symbol(frame.at(joint), strokes, Look("ink", 1.0), name=second))
    return result


def _rope(pose: Pose, stop: DistanceStop) -> list[Shape]:
    """A dashed line between two joints."""
    first, second = stop.between
    if not {first, second} <= set(pose.positions):
        return []
    frame = Frame(pose, joints(first, second))
    return [frame.line((frame.at(first), frame.at(second)), Look("ink", 0.8, dashes=(4.0, 3.0)))]
