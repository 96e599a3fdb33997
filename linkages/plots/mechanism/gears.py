"""Gears and welds in a drawing."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from numpy.typing import NDArray

from linkages.components.cam import Cam
from linkages.components.contributed.interpolation import evaluated, polynomials
from linkages.components.contributed.revolute import GROUND
from linkages.components.gear import Gear
from linkages.components.rack import Rack
from linkages.components.weld import Weld
from linkages.plots.mechanism import symbols
from linkages.plots.mechanism.bodies import body_colour
from linkages.plots.mechanism.labels import Labels
from linkages.plots.mechanism.pose import Place, Pose
from linkages.plots.style import GREY, PASSIVE

Array = NDArray[np.float64]

PITCH = (0, (7, 2, 1.5, 2))
BELT = 0.28  # of the distance of the axes: the sum of the radii of pulleys


class Wheels(NamedTuple):
    """Axes and pitch radii of two wheels, and whether a belt connects them."""

    places: tuple[Place, Place]
    radii: tuple[float, float]
    belt: bool


def gears(pose: Pose) -> list[Gear]:
    """All gears of a mechanism."""
    return [part for part in pose.mechanism.components if isinstance(part, Gear)]


def wheels(pose: Pose, gear: Gear) -> Wheels | None:
    """Pitch circles of a gear, in the units of the pose; None if its axes are not known.

    Wheels on the ground that turn the same way are joined by a belt; one that turns with the same
    sense against a moving carrier meshes inside the other.
    """
    axes = [_axis(pose, bar, gear.carrier) for bar in gear.bars]
    first, second = axes
    if first is None or second is None:
        return None
    distance, ratio = float(np.hypot(*np.subtract(second, first))), gear.ratio
    if distance <= 1e-9 * pose.extent:
        return None
    carried = gear.carrier not in (None, GROUND)
    belt = ratio > 0 and (not carried or ratio == 1.0)
    whole = BELT * distance / (1.0 + ratio) if belt else distance / abs(1.0 - ratio)
    return Wheels((first, second), (whole * abs(ratio), whole), belt)


def _axis(pose: Pose, wheel: str, carrier: str | None) -> Place | None:
    """The joint at which a wheel turns on its carrier."""
    ground = set(pose.mechanism.ground)
    fixed = ground if carrier in (None, GROUND) else set(pose.shown(str(carrier)))
    own = ground if wheel == GROUND else set(pose.shown(wheel))
    shared = sorted(fixed & own & set(pose.positions))
    return pose.positions[shared[0]] if len(shared) == 1 else None


def reach_of_gears(pose: Pose) -> Array:
    """Corners of all pitch circles and outlines of cams, shape (n, 2)."""
    found = [wheels(pose, gear) for gear in gears(pose)]
    circles = [c for p in found if p is not None for c in zip(p.places, p.radii, strict=True)]
    pinions = ((_centre(pose, rack), abs(rack.radius) * pose.unit) for rack in racks(pose))
    circles += [(place, radius) for place, radius in pinions if place is not None]
    square = np.array([[-1.0, -1.0], [1.0, 1.0]])
    corners = [np.asarray(place) + radius * square for place, radius in circles]
    corners += [outline for _, outline in cam_outlines(pose)]
    return np.vstack(corners) if corners else np.empty((0, 2))


def draw_gears(ax: Axes, pose: Pose, labels: Labels) -> None:
    """Pitch circles and belts of gears whose axes are known."""
    for gear in gears(pose):
        pair = wheels(pose, gear)
        if pair is None:
            continue
        names = zip(gear.bars, pair.places, pair.radii, strict=True)
        for name, place, radius in names:
            colour = PASSIVE if name == GROUND else body_colour(pose.mechanism, name)
            style = {"edgecolor": colour, "linestyle": PITCH, "linewidth": 1.0}
            ax.add_patch(Circle(place, radius, fill=False, zorder=1.8, **style))
            turn = np.linspace(0.0, 2 * np.pi, 181)
            ring = np.column_stack((np.cos(turn), np.sin(turn)))
            labels.avoid_line(np.asarray(place) + radius * ring)
        if pair.belt:
            _belt(ax, pair, labels)


def draw_racks(ax: Axes, pose: Pose, labels: Labels) -> None:
    """The pitch circle of each pinion, and the line that it rolls on."""
    for rack in racks(pose):
        place, angle = _centre(pose, rack), pose.angle(rack.slider)
        block = next(iter(pose.shown(rack.slider).values()), None)
        if place is None or angle is None or block is None:
            continue
        rolls = place == block  # the wheel goes with the slider, its rack stands still
        colour = body_colour(pose.mechanism, rack.bar)
        style = {"edgecolor": colour, "linestyle": PITCH, "linewidth": 1.0}
        radius = rack.radius * pose.unit
        ax.add_patch(Circle(place, abs(radius), fill=False, zorder=1.8, **style))
        along = np.array([np.cos(angle), np.sin(angle)])
        out = np.array([along[1], -along[0]]) * (-radius if rolls else radius)
        meshing = np.asarray(place) + out
        reach = float((np.asarray(block) - meshing) @ along)
        first, last = min(reach, -2.0 * abs(radius)), max(reach, 2.0 * abs(radius))
        line = np.array([meshing + first * along, meshing + last * along])
        colour = PASSIVE if rolls else body_colour(pose.mechanism, rack.slider)
        ax.plot(*line.T, color=colour, linewidth=1.6, zorder=1.9)
        labels.avoid_line(line)


def draw_cams(ax: Axes, pose: Pose, labels: Labels) -> None:
    """The outline of each cam whose size is known, around its pin, through its roller's centre."""
    for cam, outline in cam_outlines(pose):
        colour = body_colour(pose.mechanism, cam.bar)
        ax.plot(*outline.T, color=colour, linestyle=PITCH, linewidth=1.0, zorder=1.8)
        labels.avoid_line(outline)


def cam_outlines(pose: Pose) -> Iterator[tuple[Cam, Array]]:
    """Cams whose size and place are known, with their pitch curves, shape (n, 2)."""
    for cam in (part for part in pose.mechanism.components if isinstance(part, Cam)):
        place, axis = _axis(pose, cam.bar, None), pose.angle(cam.slider)
        turned = pose.angle(cam.bar)
        if cam.base_radius is None or place is None or axis is None or turned is None:
            continue
        angles = np.linspace(0.0, 2.0 * np.pi, 361)
        knots = polynomials(cam.table)
        lift = evaluated(knots.x, knots.c, cam.table.periodic, angles)[0]
        aside, reach = cam.eccentricity, cam.base_radius + cam.roller_radius
        height = np.sqrt(reach**2 - aside**2) + lift
        way = axis + turned - angles
        out = height * np.array([np.cos(way), np.sin(way)])
        beside = aside * np.array([np.sin(way), -np.cos(way)])
        yield cam, np.asarray(place) + pose.unit * (out + beside).T


def _centre(pose: Pose, rack: Rack) -> Place | None:
    """Where a pinion turns: on its carrier, or on the slider itself as a wheel that rolls."""
    place = _axis(pose, rack.bar, rack.carrier)
    own, slid = pose.shown(rack.bar), pose.shown(rack.slider)
    return next((own[j] for j in own if j in slid), None) if place is None else place


def racks(pose: Pose) -> list[Rack]:
    """All racks of a mechanism with their pinions."""
    return [part for part in pose.mechanism.components if isinstance(part, Rack)]


def note_gears(ax: Axes, pose: Pose) -> None:
    """Write down the gears whose axes are not known."""
    notes = [gear_text(gear) for gear in gears(pose) if wheels(pose, gear) is None]
    if notes:
        ax.text(0.01, 0.012, "\n".join(notes), transform=ax.transAxes, fontsize=8, color=PASSIVE,
                gid="note")  # fmt: skip


def gear_text(gear: Gear) -> str:
    """A gear in words."""
    first, second = gear.bars
    on = "" if gear.carrier in (None, GROUND) else f" on {gear.carrier}"
    return f"gear{on}: {second} turns {gear.ratio:.4g} times as fast as {first}"


def _belt(ax: Axes, pair: Wheels, labels: Labels) -> None:
    """The two outer tangents of both circles."""
    places, radii = np.asarray(pair.places), np.asarray(pair.radii)
    way = places[1] - places[0]
    distance = float(np.hypot(*way))
    along = way / distance
    across = np.array([-along[1], along[0]])
    sine = (radii[0] - radii[1]) / distance
    for side in (1.0, -1.0):
        normal = sine * along + side * np.sqrt(1.0 - sine**2) * across
        line = places + radii[:, None] * normal
        ax.plot(*line.T, color=GREY, linewidth=1.0, zorder=1.8)
        labels.avoid_line(line)


def welded(pose: Pose) -> dict[str, Weld]:
    """Joints whose place is known, with the weld there."""
    welds = (part for part in pose.mechanism.components if isinstance(part, Weld))
    return {weld.name: weld for weld in welds if weld.name in pose.positions}


def draw_welds(ax: Axes, pose: Pose, labels: Labels) -> None:
    """A filled corner between two bodies welded together, or the ground under one."""
    for joint, weld in welded(pose).items():
        place = pose.positions[joint]
        ways = [_way(pose, bar, place) for bar in weld.bars]
        first, second = ways
        colour = body_colour(pose.mechanism, weld.bars[1])
        if weld.bars[0] == GROUND:
            if second is not None:
                labels.avoid(symbols.fixed_end(ax, place, second + np.pi))
        elif first is not None and second is not None:
            labels.avoid(symbols.wedge(ax, place, first, second, colour))


def _way(pose: Pose, bar: str, place: Place) -> float | None:
    """From a joint to the middle of a body's other joints."""
    others = [] if bar == GROUND else [p for p in pose.shown(bar).values() if p != place]
    if not others:
        return None
    way = np.mean(others, axis=0) - place
    return float(np.arctan2(way[1], way[0]))
