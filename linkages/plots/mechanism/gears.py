"""Gears, racks and cams of a drawing."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.functions import evaluated, polynomials
from linkages.components.contributed.load_measures import GROUND
from linkages.components.transmissions import Cam, Gear, Rack
from linkages.plots.mechanism.placing import Frame, body_direction, joints
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.roles import body_role
from linkages.plots.mechanism.shapes import Anchor, Disc, Look, Shape, Strokes

Array = NDArray[np.float64]

PITCH = (7.0, 2.0, 1.5, 2.0)
BELT = 0.28  # of the distance of the axes: the sum of the radii of pulleys


class Wheels(NamedTuple):
    """Joints at which two wheels turn, their pitch radii, and whether a belt connects them."""

    joints: tuple[str, str]
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
    found: list[Shape] = []
    for gear in gears(pose):
        pair = wheels(pose, gear)
        if pair is None:
            continue
        for name, joint, radius in zip(gear.bars, pair.joints, pair.radii, strict=True):
            found.append(_circle(pose, name, joint, radius))
        if pair.belt:
            found.append(_belt(pose, pair))
    return found


def _circle(pose: Pose, name: str, joint: str, radius: float) -> Disc:
    role = "bar" if name == GROUND else body_role(pose.mechanism, name)
    look = Look(role, 1.0, dashes=PITCH)
    return Disc(Anchor(((joint, 1.0),)), look, metres=radius / pose.unit, name=name)


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
    found: list[Shape] = []
    for rack in racks(pose):
        joint, angle = _centre(pose, rack), pose.angle(rack.slider)
        block = next(iter(pose.shown(rack.slider)), None)
        if joint is None or angle is None or block is None:
            continue
        rolls = joint == block  # the wheel goes with the slider, its rack stands still
        radius = rack.radius * pose.unit
        found.append(_circle(pose, rack.bar, joint, abs(radius)))
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
        found.append(frame.line(line, Look(role, 1.6), rack.slider))
    return found


def draw_cams(pose: Pose) -> list[Shape]:
    """The outline of each cam whose size is known, around its pin, through its roller's centre."""
    found: list[Shape] = []
    for cam, outline in cam_outlines(pose):
        frame = Frame(pose, body_direction(pose, cam.bar))
        anchors = [frame.fixed(place, cam.bar) for place in outline]
        look = Look(body_role(pose.mechanism, cam.bar), 1.0, dashes=PITCH)
        found.append(frame.line(anchors, look, cam.bar))
        if cam.roller_radius:
            roller = Anchor(((next(iter(pose.mechanism.bodies[cam.slider].points)), 1.0),))
            edge = Look(body_role(pose.mechanism, cam.slider), 0.9)
            found.append(Disc(roller, edge, metres=cam.roller_radius, name=cam.slider))
    return found


def cam_outlines(pose: Pose) -> Iterator[tuple[Cam, Array]]:
    """Cams whose size and place are known, with their pitch curves, shape (n, 2)."""
    for cam in (part for part in pose.mechanism.components if isinstance(part, Cam)):
        joint, axis = _axis(pose, cam.bar, None), pose.angle(cam.slider)
        turned = pose.angle(cam.bar)
        if cam.base_radius is None or joint is None or axis is None or turned is None:
            continue
        angles = np.linspace(0.0, 2.0 * np.pi, 361)
        knots = polynomials(cam.table)
        lift = evaluated(knots.x, knots.c, cam.table.periodic, angles)[0]
        aside, reach = cam.eccentricity, cam.base_radius + cam.roller_radius
        height = np.sqrt(reach**2 - aside**2) + lift
        way = axis + turned - angles
        out = height * np.array([np.cos(way), np.sin(way)])
        beside = aside * np.array([np.sin(way), -np.cos(way)])
        yield cam, np.asarray(pose.positions[joint]) + pose.unit * (out + beside).T


def _centre(pose: Pose, rack: Rack) -> str | None:
    """Where a pinion turns: on its carrier, or on the slider itself as a wheel that rolls."""
    joint = _axis(pose, rack.bar, rack.carrier)
    own, slid = pose.shown(rack.bar), pose.shown(rack.slider)
    return next((name for name in own if name in slid), None) if joint is None else joint


def racks(pose: Pose) -> list[Rack]:
    """All racks of a mechanism with their pinions."""
    return [part for part in pose.mechanism.components if isinstance(part, Rack)]


def gear_notes(pose: Pose) -> list[str]:
    """Words about the gears whose axes are not known."""
    return [gear_text(gear) for gear in gears(pose) if wheels(pose, gear) is None]


def gear_text(gear: Gear) -> str:
    """A gear in words."""
    first, second = gear.bars
    on = "" if gear.carrier in (None, GROUND) else f" on {gear.carrier}"
    return f"gear{on}: {second} turns {gear.ratio:.4g} times as fast as {first}"
