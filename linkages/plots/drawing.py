"""A labelled drawing of a mechanism in one position."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from linkages.components.mechanism import Mechanism
from linkages.components.terms import Body
from linkages.plots import symbols
from linkages.plots.bodies import body_colour, clearance_ends, draw_bodies, outlines
from linkages.plots.labels import Labels
from linkages.plots.style import BLACK, CLEARANCE, DRIVEN, GREY, styled
from linkages.plots.view import Box, Positions, frame, picture

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]


@styled
def figure(data: xr.Dataset, mechanism: Mechanism) -> Figure | None:
    """The mechanism at the first sample; None for data without joint positions."""
    positions = positions_at(data, 0)
    if not positions:
        return None
    result, ax = picture(Box.around(list(positions.values())))
    draw(ax, mechanism, positions)
    return result


def positions_at(data: xr.Dataset, index: int) -> dict[str, tuple[float, float]]:
    """Where joints are at one sample, in metres; empty if the data do not say."""
    if "joint_position" not in data or data.sizes["time"] == 0:
        return {}
    array = data["joint_position"].transpose("time", "joint", "axis")[index]
    places = np.asarray(array, dtype=float)
    names = [str(name) for name in array["joint"].values]
    return {
        name: (float(x), float(y))
        for name, (x, y) in zip(names, places, strict=True)
        if np.isfinite((x, y)).all()
    }


def draw(ax: Axes, mechanism: Mechanism, positions: Positions) -> Axes:
    """Draw a mechanism with its bodies, joints, guides, drives and clearances labelled.

    Parameters
    ----------
    ax
        Where to draw; its limits are set.
    mechanism
        What to draw.
    positions
        Joint → (x, y) in metres. Bodies without known joints are left out.
    """
    scale = frame(ax, Box.around(list(positions.values())), mechanism)
    shown = {name: (x * scale.factor, y * scale.factor) for name, (x, y) in positions.items()}
    labels = Labels(ax)
    draw_bodies(ax, mechanism, shown)
    for _, corners in outlines(mechanism, shown):
        labels.avoid_line(np.vstack((corners, corners[:1])))
    for body in mechanism.bodies.values():
        if body.guide is not None:
            _slider(ax, body, shown, labels)
    _joints(ax, mechanism, shown, labels)
    for name in mechanism.prescribed:
        _drive(ax, mechanism, mechanism.bodies[name], shown, labels)
    _write(mechanism, shown, labels)
    return ax


def _slider(ax: Axes, body: Body, shown: Positions, labels: Labels) -> None:
    """A block and the line that it is guided on."""
    place = next((shown[joint] for joint in body.points if joint in shown), None)
    if place is None or body.guide is None:
        return
    angle = body.guide.angle.value
    direction = (place[0] + np.cos(angle), place[1] + np.sin(angle))
    ax.axline(place, direction, color=GREY, linewidth=0.7, linestyle=(0, (9, 2, 1.5, 2)), zorder=1)
    labels.avoid(symbols.slider_block(ax, place, angle))


def _joints(ax: Axes, mechanism: Mechanism, shown: Positions, labels: Labels) -> None:
    """Pins, bearings on the ground, clearances, and free ends."""
    ends = clearance_ends(mechanism)
    meeting = [joint for body in mechanism.bodies.values() for joint in body.points]
    for joint, place in shown.items():
        if joint in ends:
            continue
        if joint in mechanism.ground:
            labels.avoid(symbols.ground_pin(ax, place, _ground_direction(mechanism, joint, shown)))
        if joint in ends.values():
            labels.avoid(symbols.clearance(ax, place))
        free_end = joint not in mechanism.ground and meeting.count(joint) < 2
        radius, fill = (symbols.FREE_END, BLACK) if free_end else (symbols.PIN, "white")
        labels.avoid(symbols.pin(ax, place, radius=radius, fill=fill))


def _ground_direction(mechanism: Mechanism, joint: str, shown: Positions) -> float:
    """Where the ground lies at a pin: below it, unless bars go that way."""
    bars = [
        np.arctan2(shown[other][1] - shown[joint][1], shown[other][0] - shown[joint][0])
        for body in mechanism.bodies.values()
        if joint in body.points
        for other in body.points
        if other != joint and other in shown
    ]
    sides = np.array([-0.5, 0.5, 1.0, 0.0]) * np.pi
    nearness = [max((np.cos(side - bar) for bar in bars), default=-1.0) for side in sides]
    best = int(np.argmin(nearness))
    return float(sides[0] if nearness[0] < 0.5 else sides[best])


def _drive(ax: Axes, mechanism: Mechanism, body: Body, shown: Positions, labels: Labels) -> None:
    """The sense in which a drive turns its body; nothing for one that stands still."""
    speed = mechanism.prescribed[body.name].speed.value
    joints = sorted((j for j in body.points if j in shown), key=lambda j: j not in mechanism.ground)
    if speed != 0.0 and len(joints) > 1:
        pivot, tip = shown[joints[0]], shown[joints[1]]
        labels.avoid(symbols.rotation_arrow(ax, pivot, tip, speed, DRIVEN))


def _write(mechanism: Mechanism, shown: Positions, labels: Labels) -> None:
    """Names of joints and clearances, then of sliders, then of bars and plates."""
    ends = clearance_ends(mechanism)
    for joint, place in shown.items():
        if joint not in ends:
            labels.beside_point(joint, place, symbols.PIN + 2, color=BLACK, weight="bold")
    for body in mechanism.bodies.values():
        places = [shown[joint] for joint in body.points if joint in shown]
        if places and body.kind == "clearance":
            labels.beside_point(body.name, places[0], symbols.CLEARANCE_RING + 2, color=CLEARANCE)
        elif places and body.guide is not None:
            colour = body_colour(mechanism, body.name)
            labels.beside_point(body.name, places[0], symbols.BLOCK[1] + 2, color=colour)
    for body, corners in outlines(mechanism, shown):
        colour = body_colour(mechanism, body.name)
        sides = np.roll(corners, -1, axis=0) - corners
        longest = int(np.argmax(np.hypot(*sides.T)))
        start = corners[longest]
        labels.beside_segment(body.name, start, start + sides[longest], color=colour)
