"""Sliders: their axes, blocks, rods and slots, and what drives or brakes them along the axis."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from linkages.plots.mechanism import symbols
from linkages.plots.mechanism.arrows import STRAIGHT, straight_arrow
from linkages.plots.mechanism.bodies import THICKNESS, body_colour
from linkages.plots.mechanism.kinds import by_kind
from linkages.plots.mechanism.labels import Labels
from linkages.plots.mechanism.pose import Pose, SliderAxis, along_carrier
from linkages.plots.mechanism.senses import BOTH, drive_sense, load_sense
from linkages.plots.mechanism.springs import wall_dashpot, wall_zigzag
from linkages.plots.mechanism.view import pixels
from linkages.plots.style import DRIVEN, GREY, LOAD

Array = NDArray[np.float64]

FAINT = 40.0
"""Pixels between those of an axis that labels avoid: they may lie on it rather than far away."""

ABREAST = 10.0
"""Points between springs and dampers that push the same block."""

AXIS_LINE = (0, (9, 2, 1.5, 2))


def draw_sliders(ax: Axes, pose: Pose, labels: Labels, *, rails: bool = True) -> None:
    """Draw every slider whose axis is known, with the part of its guide where it is.

    Without `rails`, guides on the ground are left out.
    """
    loose = {play.slider for play in pose.mechanism.plays}
    for name, body in pose.mechanism.bodies.items():
        axis = pose.axis(name) if body.guide is not None else None
        if axis is None:
            continue
        if not _grounded(pose, name):
            _carried(ax, pose, name, axis, labels)
            continue
        place = axis.at(axis.reach)
        if rails:
            _guide(ax, pose, axis, np.array([place, place]), labels)
        draw = symbols.loose_block if name in loose else symbols.block
        labels.avoid(draw(ax, (float(place[0]), float(place[1])), axis.angle))


def draw_guides(ax: Axes, pose: Pose, labels: Labels) -> None:
    """Draw the guides of sliders on the ground along all of their travel."""
    for name, (low, high) in pose.travel.items():
        axis = pose.axis(name) if _grounded(pose, name) else None
        if axis is not None:
            ends = np.array([axis.at(pose.unit * low), axis.at(pose.unit * high)])
            _guide(ax, pose, axis, ends, labels)


def _guide(ax: Axes, pose: Pose, axis: SliderAxis, ends: Array, labels: Labels) -> None:
    """The line of an axis, and rails where the block goes."""
    further = axis.at(axis.reach + pose.extent), axis.at(axis.reach - pose.extent)
    ax.axline(*(tuple(place) for place in further), color=GREY, linewidth=0.7,
              linestyle=AXIS_LINE, zorder=1)  # fmt: skip
    start, end = pixels(ax, further)
    count = max(2, int(np.hypot(*(end - start)) / FAINT))
    labels.avoid(np.linspace(start, end, count))
    labels.avoid(symbols.rails(ax, ends, axis.angle))


def block_place(pose: Pose, name: str) -> symbols.Place | None:
    """Where the block of a slider is drawn: at its pin, or on its carrier where that ends before.

    A slider whose pin lies beyond the end of the bar that carries it is the rod of a cylinder.
    """
    axis = pose.axis(name)
    if axis is None:
        return None
    ends = along_carrier(pose, name)
    reach = axis.reach if ends is None else float(np.clip(axis.reach, *ends))
    x, y = axis.at(reach)
    return float(x), float(y)


def _carried(ax: Axes, pose: Pose, name: str, axis: SliderAxis, labels: Labels) -> None:
    """A block on a bar, or in a slot of what carries it."""
    place, pin = block_place(pose, name), axis.at(axis.reach)
    assert place is not None
    if along_carrier(pose, name) is None:
        _slot(ax, pose, name, labels)
    rod = np.array([place, pin])
    if np.hypot(*(rod[1] - rod[0])) > 1e-9 * pose.extent:
        colour = body_colour(pose.mechanism, name)
        ax.plot(*rod.T, color=colour, linewidth=0.6 * THICKNESS, zorder=2.9)
        labels.avoid_line(rod)
    labels.avoid(symbols.moving_block(ax, place, axis.angle))


def _slot(ax: Axes, pose: Pose, name: str, labels: Labels) -> None:
    """The slot of an axis in its carrier, and a line from a carrying block to it."""
    guide, ends = pose.mechanism.bodies[name].guide, pose.slot(name)
    assert guide is not None
    assert guide.body is not None
    if ends is None:
        return
    colour = body_colour(pose.mechanism, guide.body)
    if not pose.mechanism.bodies[guide.body].rotates:
        pin = np.array(next(iter(pose.shown(guide.body).values())))
        way = ends[1] - ends[0]
        share = float(np.clip((pin - ends[0]) @ way / (way @ way), 0.0, 1.0))
        stem = np.array([pin, ends[0] + share * way])
        ax.plot(*stem.T, color=colour, linewidth=THICKNESS, solid_capstyle="round", zorder=3)
        labels.avoid_line(stem)
    labels.avoid(symbols.slot(ax, ends, colour))


def draw_axial(ax: Axes, pose: Pose, labels: Labels) -> None:
    """Arrows of drives and forces beside the blocks."""
    mechanism = pose.mechanism
    for name in mechanism.prescribed:
        if not mechanism.bodies[name].rotates:
            _beside(ax, pose, name, drive_sense(mechanism, name), DRIVEN, labels)
    for slide, load in by_kind(mechanism.loads).slides:
        if load.pushes:
            _beside(ax, pose, slide.body, load_sense(load, mechanism), LOAD, labels)


def draw_guide_springs(ax: Axes, pose: Pose, labels: Labels, first: Pose | None = None) -> None:
    """Springs and dampers in guides, on the side that was free in a first position, if given."""
    first = first or pose
    of_slider: dict[str, list[bool]] = {}
    for slide, load in by_kind(pose.mechanism.loads).slides:
        found = of_slider.setdefault(slide.body, [])
        if load.pushes:
            continue
        found += [True] * load.elastic + [False] * load.dissipates
    for name, parts in of_slider.items():
        place, angle, before = block_place(pose, name), pose.angle(name), first.angle(name)
        if place is None or angle is None or before is None:
            continue
        start = symbols.BLOCK[0] if _grounded(pose, name) else symbols.SMALL_BLOCK[0]
        turned = angle + (0.0 if _damper_side(first, name) > 0 else np.pi)
        for index, elastic in enumerate(parts):
            across = ABREAST * (index - 0.5 * (len(parts) - 1))
            draw = wall_zigzag if elastic else wall_dashpot
            labels.avoid(draw(ax, place, turned, start, across))


def force_side(pose: Pose, name: str, sense: int) -> int:
    """On which side of a slider, along its axis, an arrow of a force stands: where no bars are.

    There it pulls at the block, or pushes it, as its sense wants. 0 for a force of both senses,
    whose arrow stands over the block.
    """
    if sense == BOTH:
        return 0
    angle, shown = pose.angle(name), pose.shown(name)
    along = np.array([np.cos(angle or 0.0), np.sin(angle or 0.0)])
    ways = [
        float(np.subtract(other, shown[joint]) @ along)
        for joint in shown
        for body in pose.mechanism.bodies
        if body != name and joint in pose.shown(body)
        for other in pose.shown(body).values()
    ]
    balance = sum(ways)
    if abs(balance) < 1e-6 * pose.extent:
        return sense
    return -1 if balance > 0.0 else 1


def _damper_side(pose: Pose, name: str) -> int:
    """Where a damper finds room: where no bars are, unless a force stands there."""
    slides = by_kind(pose.mechanism.loads).slides
    forces = [load for slide, load in slides if slide.body == name and load.pushes]
    side = force_side(pose, name, -1)
    stands = [force_side(pose, name, load_sense(load, pose.mechanism)) for load in forces]
    return -side if side in stands else side


def _beside(ax: Axes, pose: Pose, name: str, sense: int, colour: str, labels: Labels) -> None:
    """A drive's arrow stands over the block, a force's before or behind it."""
    place, angle = block_place(pose, name), pose.angle(name)
    if place is None or angle is None or sense == 0:
        return
    half, height = symbols.BLOCK if _grounded(pose, name) else symbols.SMALL_BLOCK
    side = force_side(pose, name, sense)
    start = (half + 2.0, 0.0) if side == sense else (-half - 2.0 - STRAIGHT, 0.0)
    if colour == DRIVEN or side == 0:
        start = (-half, height + 8.0)
    labels.avoid(straight_arrow(ax, place, angle, start, sense, colour))


def _grounded(pose: Pose, name: str) -> bool:
    guide = pose.mechanism.bodies[name].guide
    return guide is not None and guide.body is None
