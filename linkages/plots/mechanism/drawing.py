"""A labelled drawing of a mechanism in one position."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.system import System
from linkages.plots.mechanism.annotations import (
    Labels,
    centre_lines,
    draw_centres,
    frame_lines,
    frame_words,
    length_words,
)
from linkages.plots.mechanism.efforts import draw_drives, draw_forces, load_words
from linkages.plots.mechanism.gears import draw_cams, draw_gears, draw_racks, gear_notes
from linkages.plots.mechanism.guide_symbols import RAIL, draw_blocks, draw_guides, draw_rods, pin_of
from linkages.plots.mechanism.inked_shapes import LIGHT, MEANINGS, Inked, points_per_unit
from linkages.plots.mechanism.links import (
    anchored_outlines,
    draw_bearings,
    draw_clearances,
    draw_links,
    draw_masses,
    draw_pins,
    draw_welds,
)
from linkages.plots.mechanism.load_symbols import (
    draw_guide_springs,
    draw_linings,
    draw_shoes,
    draw_springs,
    draw_stops,
    draw_torsional,
)
from linkages.plots.mechanism.placing import Cover, placed
from linkages.plots.mechanism.plane_view import ROOM, Box, Positions, frame, picture, room_in
from linkages.plots.mechanism.pose import Pose, Poses, pose_at
from linkages.plots.mechanism.roles import body_role, clearance_ends
from linkages.plots.mechanism.shapes import (
    BLOCK,
    CLEARANCE_RING,
    PIN,
    Anchor,
    Look,
    Pair,
    Shape,
    Word,
)
from linkages.plots.style import styled

if TYPE_CHECKING:
    import xarray as xr

GUIDED = RAIL + 2.0
"""Points from the joint of a slider to the name of its room."""


def words_of(pose: Pose) -> list[Word]:
    """Names of joints, sliders, clearances and bodies, and sizes of loads, most important first."""
    mechanism, shown = pose.mechanism, pose.positions
    hidden = {*clearance_ends(mechanism), *mechanism.feet}
    found = [
        _beside(joint, joint, PIN + 2.0, "ink", strong=True)
        for joint in shown
        if joint not in hidden and "." not in joint  # which no definition can name
    ]
    for body in mechanism.bodies.values():
        joints = list(pose.shown(body.name))
        if joints and body.guide is not None and body.kind != "offset":
            gap, role = BLOCK[1] + 2.0, body_role(mechanism, body.name)
            found.append(_beside(body.name, joints[0], gap, role))
    found += [
        _beside(term.name, term.joint, CLEARANCE_RING + 2.0, "clearance")
        for term in mechanism.displacements
        if term.joint in shown
    ]
    found += [
        Word(play.name, (pin_of(pose, play.slider),), Look("clearance"), GUIDED, name=play.name)
        for play in mechanism.plays
        if pose.axis(play.slider) is not None
    ]
    for body, corners, direction in anchored_outlines(pose):
        if body.rotates:
            look = Look(body_role(mechanism, body.name))
            found.append(Word(body.name, corners, look, direction=direction, name=body.name))
    return [*found, *load_words(pose)]


def _beside(text: str, joint: str, gap: float, role: str, *, strong: bool = False) -> Word:
    anchor = Anchor(((joint, 1.0),))
    return Word(text, (anchor,), Look(role), gap, name=text, strong=strong)


Array = NDArray[np.float64]

INCHES = 5.0
"""How wide a mechanism is in a picture, roughly."""

LOOKS = 24
"""Positions from which the size of a picture is told, besides the places of all joints."""


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


def rough_scale(pose: Pose) -> float:
    """Points per metre of a picture, roughly: for shapes whose paper is not known yet."""
    return 72.0 * INCHES / pose.extent


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

    Parameters
    ----------
    pose
        A position in metres; the shapes are right for all others, too.
    scale
        Points per metre of the picture: how many coils and strokes of hatching symbols have.
        Default: as if it were five inches wide.
    """
    scale = rough_scale(pose) if scale is None else scale
    return [*under(pose, scale), *over(pose, scale), *words_of(pose)]


def under(pose: Pose, scale: float) -> list[Shape]:
    """Guides, wheels, bodies, springs between joints, blocks, bearings and pins."""
    return [
        *draw_guides(pose, scale),
        *draw_rods(pose, scale),
        *draw_gears(pose),
        *draw_racks(pose),
        *draw_cams(pose),
        *draw_clearances(pose),
        *draw_links(pose),
        *draw_bearings(pose),
        *draw_springs(pose, scale),
        *draw_guide_springs(pose, scale),
        *draw_blocks(pose, scale),
        *draw_linings(pose, scale),
        *draw_stops(pose),
        *draw_welds(pose),
        *draw_masses(pose),
        *draw_pins(pose),
        *draw_torsional(pose),
        *draw_shoes(pose),
    ]


def over(pose: Pose, scale: float) -> list[Shape]:
    """Arrows of drives and loads."""
    return [*draw_drives(pose, scale), *draw_forces(pose, scale)]


def draw(
    ax: Axes,
    mechanism: Mechanism,
    positions: Positions,
    angles: Mapping[str, float] | None = None,
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
    Inked(ax, shapes, shown).avoided(labels)
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


def note_gears(ax: Axes, pose: Pose) -> None:
    """Write down the gears whose axes are not known."""
    notes = gear_notes(pose)
    if notes:
        ax.text(0.01, 0.012, "\n".join(notes), transform=ax.transAxes, fontsize=8,
                color=LIGHT["bar"], gid="note")  # fmt: skip


def colour_legend(ax: Axes, shapes: Sequence[Shape]) -> None:
    """Say under the axes what those colours mean that occur."""
    roles = {shape.look.role for shape in shapes}
    words: dict[str, list[str]] = {}  # of roles that have one colour
    for role, meaning in MEANINGS.items():
        if role in roles:
            words.setdefault(LIGHT[role], []).append(meaning)
    if not words:
        return
    handles = [Line2D([], [], color=colour, linewidth=2.4) for colour in words]
    below = -0.3 / (ax.bbox.height / ax.figure.dpi)
    ax.legend(
        handles, [", ".join(own) for own in words.values()], loc="upper left", ncols=len(words),
        bbox_to_anchor=(0.0, below), borderaxespad=0.0, borderpad=0.0, handlelength=1.1,
        handletextpad=0.5, columnspacing=1.2, fontsize=8.0,
    )  # fmt: skip
    ax.set_xlabel(ax.get_xlabel(), loc="right")
