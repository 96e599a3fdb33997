"""A labelled drawing of a mechanism in one position."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from linkages.components.contributed.terms import Body
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.system import System
from linkages.plots.mechanism import symbols
from linkages.plots.mechanism.arrows import rotation_arrow
from linkages.plots.mechanism.bodies import (
    body_colour,
    clearance_ends,
    draw_bodies,
    ground_direction,
    outlines,
    slots_of,
)
from linkages.plots.mechanism.gears import (
    draw_cams,
    draw_gears,
    draw_racks,
    draw_welds,
    note_gears,
    reach_of_gears,
    welded,
)
from linkages.plots.mechanism.labels import Labels
from linkages.plots.mechanism.loads import (
    draw_forces,
    draw_masses,
    draw_springs,
    draw_torsional,
    load_texts,
)
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.samples import pose_at
from linkages.plots.mechanism.senses import drive_sense
from linkages.plots.mechanism.sliders import (
    block_place,
    draw_axial,
    draw_guide_springs,
    draw_sliders,
)
from linkages.plots.mechanism.view import Box, Positions, frame, picture
from linkages.plots.style import BLACK, CLEARANCE, DRIVEN, LOAD, styled

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]


@styled
def figure(data: xr.Dataset, mechanism: Mechanism) -> Figure | None:
    """The mechanism at the first sample; None for data without joint positions."""
    pose = pose_at(data, mechanism, 0)
    return posed(pose) if pose.positions else None


@styled
def start_figure(system: System) -> Figure:
    """A mechanism at t = 0, without a motion."""
    places = system.places()
    positions = {name: tuple(places[name].tolist()) for name in system.topology.joints}
    variables = [name for name, body in system.mechanism.bodies.items() if body.rotates]
    nodes = [system.model.positions.angle(name) for name in variables]
    angles = dict(zip(variables, system.evaluate(nodes)[:, 0].tolist(), strict=True))
    return posed(Pose(system.mechanism, positions, angles))


def posed(pose: Pose) -> Figure:
    """The figure of a mechanism in a position, given in metres."""
    result, ax = picture(reach(pose))
    draw_pose(ax, pose)
    return result


def reach(pose: Pose) -> Box:
    """The part of the plane that a drawing shows: joints, slots and pitch circles."""
    slots = [ends for name in pose.mechanism.bodies for ends in slots_of(pose, name)]
    joints = np.array(list(pose.positions.values()), dtype=float).reshape(-1, 2)
    return Box.around(np.vstack([joints, *slots, reach_of_gears(pose)]))


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


def draw_pose(ax: Axes, pose: Pose) -> Axes:
    """Draw a mechanism in a position, given in metres; the limits of the axes are set."""
    scale = frame(ax, reach(pose), pose.mechanism)
    shown = pose.scaled(scale.factor)
    labels = Labels(ax)
    draw_symbols(ax, shown, labels)
    _write(shown, labels)
    return ax


def draw_symbols(ax: Axes, shown: Pose, labels: Labels) -> None:
    """Everything but names, in the units of the axes."""
    draw_bodies(ax, shown)
    for _, corners in outlines(shown):
        labels.avoid_line(np.vstack((corners, corners[:1])))
    draw_gears(ax, shown, labels)
    draw_racks(ax, shown, labels)
    draw_cams(ax, shown, labels)
    note_gears(ax, shown)
    draw_springs(ax, shown, labels)
    draw_sliders(ax, shown, labels)
    draw_welds(ax, shown, labels)
    draw_masses(ax, shown, labels)
    draw_bearings(ax, shown, labels)
    draw_joints(ax, shown, labels)
    draw_torsional(ax, shown, labels)
    for name in shown.mechanism.prescribed:
        _drive(ax, shown, name, labels)
    draw_axial(ax, shown, labels)
    draw_guide_springs(ax, shown, labels)
    draw_forces(ax, shown, labels)


def draw_bearings(ax: Axes, pose: Pose, labels: Labels) -> None:
    """Hatched ground under the joints that it holds."""
    for joint, place in pose.positions.items():
        if joint in pose.mechanism.ground and not _fixed(pose, joint):
            labels.avoid(symbols.ground_pin(ax, place, ground_direction(pose, joint)))


def draw_joints(ax: Axes, pose: Pose, labels: Labels) -> None:
    """Pins, clearances, and free ends."""
    mechanism, shown = pose.mechanism, pose.positions
    ends, feet = clearance_ends(mechanism), mechanism.feet
    meeting = [joint for body in mechanism.bodies.values() for joint in body.points]
    # free ends first: what turns on a pin at the same place is drawn over them
    for joint, place in sorted(shown.items(), key=lambda item: meeting.count(item[0]) > 1):
        if joint in ends or joint in feet or _fixed(pose, joint):
            continue
        if joint in ends.values():
            labels.avoid(symbols.clearance(ax, place))
        free_end = joint not in mechanism.ground and meeting.count(joint) < 2
        radius, fill = (symbols.FREE_END, BLACK) if free_end else (symbols.PIN, "white")
        labels.avoid(symbols.pin(ax, place, radius=radius, fill=fill))


def _fixed(pose: Pose, joint: str) -> bool:
    """Whether a weld holds the only two bodies at a joint together: no pin is there."""
    mechanism = pose.mechanism
    if joint not in welded(pose) or joint in clearance_ends(mechanism).values():
        return False
    meeting = [name for body in mechanism.bodies.values() for name in body.points]
    return meeting.count(joint) + (joint in mechanism.ground) == 2


def _drive(ax: Axes, pose: Pose, name: str, labels: Labels) -> None:
    """The sense in which a drive turns its body; nothing for one that stands still."""
    ground, shown = pose.mechanism.ground, pose.shown(name)
    joints = sorted(shown, key=lambda joint: joint not in ground)
    sense = drive_sense(pose.mechanism, name) if pose.mechanism.bodies[name].rotates else 0
    if sense and len(joints) > 1:
        pivot, tip = shown[joints[0]], shown[joints[1]]
        labels.avoid(rotation_arrow(ax, pivot, tip, sense, DRIVEN))


def _write(pose: Pose, labels: Labels) -> None:
    """Names of joints and clearances, then of sliders, then of bars and plates, then loads."""
    mechanism = pose.mechanism
    ends = {*clearance_ends(mechanism), *mechanism.feet}
    for joint, place in pose.positions.items():
        if joint not in ends:
            labels.beside_point(joint, place, symbols.PIN + 2, color=BLACK, weight="bold")
    for body in mechanism.bodies.values():
        places = list(pose.shown(body.name).values())
        if places and body.guide is not None and body.kind != "offset":
            place = block_place(pose, body.name) or places[0]
            colour = body_colour(mechanism, body.name)
            labels.beside_point(body.name, place, symbols.BLOCK[1] + 2, color=colour)
    for term in mechanism.displacements:
        if term.joint in pose.positions:
            place = pose.positions[term.joint]
            labels.beside_point(term.name, place, symbols.CLEARANCE_RING + 2, color=CLEARANCE)
    for body, corners in outlines(pose):
        if body.rotates:
            _write_body(pose, body, corners, labels)
    for text, place, gap in load_texts(labels.ax, pose):
        labels.beside_point(text, place, gap, color=LOAD, fontsize=8)


def _write_body(pose: Pose, body: Body, corners: Array, labels: Labels) -> None:
    colour = body_colour(pose.mechanism, body.name)
    if len(corners) > 2:
        labels.in_polygon(body.name, corners, color=colour)
    else:
        labels.beside_segment(body.name, *corners, color=colour)
