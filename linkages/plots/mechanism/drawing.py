"""A labelled drawing of a mechanism in one position, with its gears, racks and cams."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from linkages.components.contributed.functions import evaluated, polynomials
from linkages.components.contributed.load_measures import GROUND
from linkages.components.contributed.terms import UNSEEN
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.transmissions import Cam, Gear, Rack
from linkages.kernel.system import System
from linkages.plots.mechanism import efforts, links, load_symbols
from linkages.plots.mechanism.annotations import (
    Labels,
    centre_lines,
    draw_centres,
    frame_lines,
    frame_words,
    length_words,
)
from linkages.plots.mechanism.guide_symbols import (
    RAIL,
    draw_blocks,
    draw_guides,
    draw_rods,
    slider_of,
)
from linkages.plots.mechanism.inked_shapes import LIGHT, MEANINGS, Inked, points_per_unit
from linkages.plots.mechanism.placing import Cover, Frame, at_joint, body_direction, joints, placed
from linkages.plots.mechanism.plane_view import (
    ROOM,
    Box,
    Positions,
    frame,
    legend_below,
    picture,
    room_in,
)
from linkages.plots.mechanism.pose import Pose, Poses, pose_at
from linkages.plots.mechanism.roles import body_role, clearance_ends, parts_of
from linkages.plots.mechanism.shapes import (
    BLOCK,
    CLEARANCE_RING,
    PIN,
    Anchor,
    Disc,
    Look,
    Pair,
    Shape,
    Strokes,
    Word,
)
from linkages.plots.style import styled

if TYPE_CHECKING:
    import xarray as xr


Array = NDArray[np.float64]

PITCH = (7.0, 2.0, 1.5, 2.0)
BELT = 0.28  # of the distance of the axes: the sum of the radii of pulleys


class Wheels(NamedTuple):
    """Joints at which two wheels turn, their pitch radii, and whether a belt connects them."""

    joints: tuple[str, str]
    radii: tuple[float, float]
    belt: bool


def wheels(pose: Pose, gear: Gear) -> Wheels | None:
    """Pitch circles of a gear, in the units of the pose; None if its axes are not known.

    Wheels on the ground that turn the same way are joined by a belt; one that turns with the same
    sense against a moving carrier meshes inside the other.
    """
    first, second = (_axis(pose, bar, gear.carrier) for bar in gear.bars)
    if first is None or second is None:
        return None
    way = np.subtract(pose.positions[second], pose.positions[first])
    distance, ratio = float(np.hypot(*way)), gear.ratio
    if distance <= 1e-9 * pose.extent:
        return None
    carried = gear.carrier not in (None, GROUND)
    belt = ratio > 0 and (not carried or ratio == 1.0)
    whole = BELT * distance / (1.0 + ratio) if belt else distance / abs(1.0 - ratio)
    return Wheels((first, second), (whole * abs(ratio), whole), belt)


def _axis(pose: Pose, wheel: str, carrier: str | None) -> str | None:
    """The joint at which a wheel turns on its carrier."""
    ground = set(pose.mechanism.ground)
    fixed = ground if carrier in (None, GROUND) else set(pose.shown(str(carrier)))
    own = ground if wheel == GROUND else set(pose.shown(wheel))
    shared = sorted(fixed & own & set(pose.positions))
    return shared[0] if len(shared) == 1 else None


def draw_gears(pose: Pose) -> list[Shape]:
    """Pitch circles and belts of gears whose axes are known."""
    result: list[Shape] = []
    for gear in parts_of(pose.mechanism, Gear):
        pair = wheels(pose, gear)
        if pair is None:
            continue
        for name, joint, radius in zip(gear.bars, pair.joints, pair.radii, strict=True):
            result.append(_circle(pose, name, joint, radius))
        if pair.belt:
            result.append(_belt(pose, pair))
    return result


def _circle(pose: Pose, name: str, joint: str, radius: float) -> Disc:
    role = "bar" if name == GROUND else body_role(pose.mechanism, name)
    look = Look(role, 1.0, dashes=PITCH)
    return Disc(at_joint(joint), look, metres=radius / pose.unit, name=name)


def _belt(pose: Pose, pair: Wheels) -> Strokes:
    """The two outer tangents of both circles."""
    frame = Frame(pose, joints(*pair.joints))
    places = [np.asarray(pose.positions[joint]) for joint in pair.joints]
    sine = (pair.radii[0] - pair.radii[1]) / float(np.hypot(*(places[1] - places[0])))
    cosine = float(np.sqrt(1.0 - sine**2))
    strokes = tuple(
        tuple(
            Anchor(((joint, 1.0),), (radius * sine / pose.unit, side * radius * cosine / pose.unit))
            for joint, radius in zip(pair.joints, pair.radii, strict=True)
        )
        for side in (1.0, -1.0)
    )
    return Strokes(strokes, Look("guide", 1.0), frame.direction)


def draw_racks(pose: Pose) -> list[Shape]:
    """The pitch circle of each pinion, and the line that it rolls on."""
    result: list[Shape] = []
    for rack in parts_of(pose.mechanism, Rack):
        joint, angle = _centre(pose, rack), pose.angle(rack.slider)
        block = next(iter(pose.shown(rack.slider)), None)
        if joint is None or angle is None or block is None:
            continue
        rolls = joint == block  # the wheel goes with the slider, its rack stands still
        radius = rack.radius * pose.unit
        result.append(_circle(pose, rack.bar, joint, abs(radius)))
        along = np.array([np.cos(angle), np.sin(angle)])
        out = np.array([along[1], -along[0]]) * (-radius if rolls else radius)
        meshing = np.asarray(pose.positions[joint]) + out
        reach = float((np.asarray(pose.positions[block]) - meshing) @ along)
        first, last = min(reach, -2.0 * abs(radius)), max(reach, 2.0 * abs(radius))
        frame = Frame(pose, body_direction(pose, rack.slider))
        guide = pose.mechanism.bodies[rack.slider].guide
        assert guide is not None
        goes_with = guide.body if rolls else rack.slider
        line = [frame.fixed(meshing + share * along, goes_with) for share in (first, last)]
        role = "bar" if rolls else body_role(pose.mechanism, rack.slider)
        result.append(frame.line(line, Look(role, 1.6), rack.slider))
    return result


def draw_cams(pose: Pose) -> list[Shape]:
    """The outline of each cam whose size is known, around its pin, through its roller's centre.

    That of one under a flat face is its profile.
    """
    result: list[Shape] = []
    for cam, outline in cam_outlines(pose):
        frame = Frame(pose, body_direction(pose, cam.bar))
        anchors = [frame.fixed(place, cam.bar) for place in outline]
        look = Look(body_role(pose.mechanism, cam.bar), 1.0, dashes=PITCH)
        result.append(frame.line(anchors, look, cam.bar))
        follower = at_joint(next(iter(pose.mechanism.bodies[cam.slider].points)))
        edge = Look(body_role(pose.mechanism, cam.slider), 0.9)
        if cam.roller_radius:
            result.append(Disc(follower, edge, metres=cam.roller_radius, name=cam.slider))
        if cam.flat:
            face = Frame(pose, body_direction(pose, cam.slider))
            reach = float(np.abs(_lifts(cam, _ALL_AROUND)[1]).max()) + FACE * (
                cam.base_radius or 0.0
            )
            ends = [replace(follower, metres=(0.0, side * reach)) for side in (-1.0, 1.0)]
            result.append(face.line(ends, replace(edge, width=2.0), cam.slider))
    return result


_ALL_AROUND = np.linspace(0.0, 2.0 * np.pi, 361)

FACE = 0.2
"""How far a flat face reaches beyond where it touches its cam, over the base radius."""


def _lifts(cam: Cam, angles: Array) -> tuple[Array, Array]:
    """The lift of a cam at some angles, and its derivative."""
    knots = polynomials(cam.table)
    lift, slope, _ = evaluated(knots.x, knots.c, cam.table.periodic, angles)
    return lift, slope


def cam_outlines(pose: Pose) -> Iterator[tuple[Cam, Array]]:
    """Cams whose size and place are known, with their pitch curves, shape (n, 2)."""
    for cam in parts_of(pose.mechanism, Cam):
        joint, axis = _axis(pose, cam.bar, None), pose.angle(cam.slider)
        turned = pose.angle(cam.bar)
        if cam.base_radius is None or joint is None or axis is None or turned is None:
            continue
        lift, slope = _lifts(cam, _ALL_AROUND)
        aside: float | Array = slope if cam.flat else cam.eccentricity
        reach = cam.base_radius + cam.roller_radius
        height = np.sqrt(reach**2 - cam.eccentricity**2) + lift
        way = axis + turned - _ALL_AROUND
        out = height * np.array([np.cos(way), np.sin(way)])
        beside = aside * np.array([np.sin(way), -np.cos(way)])
        yield cam, np.asarray(pose.positions[joint]) + pose.unit * (out + beside).T


def _centre(pose: Pose, rack: Rack) -> str | None:
    """Where a pinion turns: on its carrier, or on the slider itself as a wheel that rolls."""
    joint = _axis(pose, rack.bar, rack.carrier)
    own, slid = pose.shown(rack.bar), pose.shown(rack.slider)
    return next((name for name in own if name in slid), None) if joint is None else joint


GUIDED = RAIL + 2.0  # points from the joint of a slider to the name of its room


def words_of(pose: Pose) -> list[Word]:
    """Names of joints, sliders, clearances and bodies, and sizes of loads, most important first."""
    mechanism, shown = pose.mechanism, pose.positions
    hidden = {*clearance_ends(mechanism), *mechanism.feet}
    result = [
        _beside(joint, joint, PIN + 2.0, "ink", strong=True)
        for joint in shown
        if joint not in hidden and "." not in joint  # which no definition can name
    ]
    for body in mechanism.bodies.values():
        joints = list(pose.shown(body.name))
        if joints and body.guide is not None and body.kind not in UNSEEN:
            gap, role = BLOCK[1] + 2.0, body_role(mechanism, body.name)
            result.append(_beside(body.name, joints[0], gap, role))
    result += [
        _beside(term.name, term.joint, CLEARANCE_RING + 2.0, "clearance")
        for term in mechanism.displacements
        if term.joint in shown
    ]
    result += [
        Word(play.name, (slider.pin,), Look("clearance"), GUIDED, name=play.name)
        for play in mechanism.plays
        if (slider := slider_of(pose, play.slider)) is not None
    ]
    for body, corners, direction in links.anchored_outlines(pose):
        if body.rotates:
            look = Look(body_role(mechanism, body.name))
            result.append(Word(body.name, corners, look, direction=direction, name=body.name))
    loads = efforts.draw_forces(pose, 1.0)
    return [*result, *(shape for shape in loads if isinstance(shape, Word))]


def _beside(text: str, joint: str, gap: float, role: str, *, strong: bool = False) -> Word:
    return Word(text, (at_joint(joint),), Look(role), gap, name=text, strong=strong)


INCHES = 5.0  # how wide a mechanism is in a picture, roughly
LOOKS = 24  # positions from which the size of a picture is told, besides the places of all joints


@styled
def figure(data: xr.Dataset, mechanism: Mechanism) -> Figure | None:
    """The mechanism at the first sample; None for data without joint positions."""
    pose = pose_at(data, mechanism, 0)
    return posed(pose) if pose.positions else None


@styled
def start_figure(system: System, *, dimensions: bool = False) -> Figure:
    """A mechanism at t = 0, without a motion; with lengths and centres of mass if that is asked."""
    return posed(start_pose(system), dimensions=dimensions)


def start_pose(system: System) -> Pose:
    """A mechanism at t = 0, in metres, without a motion."""
    places = system.places()
    positions = {name: tuple(places[name].tolist()) for name in system.topology.joints}
    variables = [name for name, body in system.mechanism.bodies.items() if body.rotates]
    nodes = [system.model.positions.angle(name) for name in variables]
    angles = dict(zip(variables, system.evaluate(nodes)[:, 0].tolist(), strict=True))
    return Pose(system.mechanism, positions, angles)


def posed(pose: Pose, *, dimensions: bool = False) -> Figure:
    """The figure of a mechanism in a position, given in metres."""
    result, ax = picture(reach(pose, dimensions=dimensions))
    draw_pose(ax, pose, dimensions=dimensions)
    return result


def reach(pose: Pose, room: Pair = ROOM, *, dimensions: bool = False) -> Box:
    """The part of the plane that a drawing takes, for a position in metres.

    `room` is width and height of its picture in points, without margins for labels; `dimensions` is
    that of `draw_pose`.
    """
    joints = np.array(list(pose.positions.values()), dtype=float).reshape(-1, 2)
    marks = draw_centres(pose) if dimensions else ()
    return _cover([pose], joints, room, marks).fitted(room)


def _cover(poses: Sequence[Pose], joints: Array, room: Pair, marks: Sequence[Shape] = ()) -> Cover:
    """What the shapes of the first position cover in all of them, and all joints, shape (n, 2)."""
    first, size = poses[0], Box.around(joints).size
    scale = float(np.min(np.divide(room, np.maximum(size, 1e-9 * size.max()))))
    shapes = [*under(first, scale), *over(first, scale), *marks]
    points = Cover(joints, np.zeros_like(joints))
    return Cover.joined([points, *(Cover.of(pose, shapes) for pose in poses)])


def framed(data: xr.Dataset, mechanism: Mechanism, room: Pair = ROOM) -> tuple[Poses, Box]:
    """Positions at all samples in pictures of one size, and the part of the plane that they sweep.

    Films and traces have the same frame, in pictures of the same `room`, as `reach` has it. The
    data must have at least one sample.
    """
    places = np.asarray(data["joint_position"], dtype=float)
    poses = Poses(data, mechanism, Box.around(places).extent or None)
    looks = np.unique(np.linspace(0, len(poses.places) - 1, LOOKS).round().astype(int))
    shown = [poses.at(int(look)) for look in looks]
    return poses, _cover(shown, poses.places.reshape(-1, 2), room).fitted(room)


def shapes_of(pose: Pose, scale: float | None = None) -> list[Shape]:
    """The whole drawing of a mechanism as shapes, in the order of drawing.

    `pose`: a position in metres; the shapes are right for all others, too.
    `scale`: points per metre of the picture: how many coils and strokes of hatching symbols have.
    Default: as if it were five inches wide.
    """
    scale = 72.0 * INCHES / pose.extent if scale is None else scale
    return [*under(pose, scale), *over(pose, scale), *words_of(pose)]


def under(pose: Pose, scale: float) -> list[Shape]:
    """Guides, wheels, bodies, springs between joints, blocks, bearings and pins."""
    return [
        *links.draw_walls(pose, scale),
        *draw_guides(pose, scale),
        *draw_rods(pose, scale),
        *draw_gears(pose),
        *draw_racks(pose),
        *draw_cams(pose),
        *links.draw_clearances(pose),
        *links.draw_links(pose),
        *links.draw_bearings(pose),
        *load_symbols.draw_springs(pose, scale),
        *load_symbols.draw_guide_springs(pose, scale),
        *draw_blocks(pose, scale),
        *load_symbols.draw_linings(pose, scale),
        *load_symbols.draw_stops(pose),
        *links.draw_welds(pose),
        *links.draw_masses(pose),
        *links.draw_pins(pose),
        *load_symbols.draw_torsional(pose),
        *load_symbols.draw_shoes(pose),
    ]


def over(pose: Pose, scale: float) -> list[Shape]:
    """Arrows of drives and loads."""
    shapes = [*efforts.draw_drives(pose, scale), *efforts.draw_forces(pose, scale)]
    return [shape for shape in shapes if not isinstance(shape, Word)]


def draw(
    ax: Axes, mechanism: Mechanism, positions: Positions, angles: Mapping[str, float] | None = None
) -> Axes:
    """Draw a mechanism with its bodies, joints, guides, drives and loads labelled.

    Parameters
    ----------
    ax
        Where to draw; its limits are set.
    mechanism
        What to draw.
    positions
        Joint → (x, y) in metres. Bodies without known joints are left out.
    angles
        Bar → its angle in radians; only needed for bodies with a single known joint.
    """
    return draw_pose(ax, Pose(mechanism, positions, angles or {}))


def draw_pose(ax: Axes, pose: Pose, *, dimensions: bool = False) -> Axes:
    """Draw a mechanism in a position, given in metres; the limits of the axes are set."""
    scale = frame(ax, reach(pose, room_in(ax), dimensions=dimensions), pose.mechanism)
    factor = scale.factor
    shapes = shapes_of(pose, points_per_unit(ax) * factor)
    if dimensions:
        shapes = [*frame_lines(pose), *centre_lines(pose), *shapes, *draw_centres(pose)]
        shapes += [*length_words(pose, scale), *frame_words(pose, scale)]
    shown, labels = pose.scaled(factor), Labels(ax)
    Inked(ax, shapes, shown)
    note_gears(ax, pose)
    colour_legend(ax, shapes)
    write(labels, shapes, shown)
    return ax


def write(labels: Labels, shapes: Sequence[Shape], shown: Pose) -> None:
    """Write words where there is room, one after the other."""
    point = 1.0 / points_per_unit(labels.ax)
    for word in shapes:
        if isinstance(word, Word):
            places = placed(shown, word.beside, word.direction, point)
            size = {"fontsize": 8.0} if word.look.role == "load" or word.gap < 4.0 else {}
            weight = "bold" if word.strong else "normal"
            font = {"color": LIGHT[word.look.role], "weight": weight, **size}
            labels.beside(word.text, places, word.gap, along=word.along, **font)
    labels.improve()


def note_gears(ax: Axes, pose: Pose) -> None:
    """Write down the gears whose axes are not known."""
    notes = []
    for gear in parts_of(pose.mechanism, Gear):
        if wheels(pose, gear) is None:
            (first, second), carrier = gear.bars, gear.carrier
            on = "" if carrier in (None, GROUND) else f" on {carrier}"
            notes.append(f"gear{on}: {second} turns {gear.ratio:.4g} times as fast as {first}")
    if notes:
        ax.text(0.01, 0.012, "\n".join(notes), transform=ax.transAxes, fontsize=8,
                color=LIGHT["bar"], gid="note")  # fmt: skip


def colour_legend(ax: Axes, shapes: Sequence[Shape]) -> None:
    """Say under the axes what those colours mean that occur."""
    roles = {shape.look.role for shape in shapes}
    words: dict[str, list[str]] = {}  # of roles that have one colour
    for role, meaning in MEANINGS.items():
        if meaning and role in roles:
            words.setdefault(LIGHT[role], []).append(meaning)
    if not words:
        return
    named = ((colour, ", ".join(own)) for colour, own in words.items())
    legend_below(ax, [Line2D([], [], color=c, linewidth=2.4, label=text) for c, text in named])
