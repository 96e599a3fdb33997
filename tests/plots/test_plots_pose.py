"""Orientation of bodies and axes from places of joints, against known rotations."""

import numpy as np
import pytest

import linkages
from linkages.components.contributed.load_measures import Turn
from linkages.plots.mechanism.pose import Pose, along_carrier
from linkages.plots.mechanism.roles import (
    BOTH,
    at_joints,
    drive_sense,
    force_direction,
    load_sense,
    measured,
)

BASE = "joints: {O: [0, 0], D: [1, 0]}\n"
PLATE = (
    BASE
    + """
bars: {plate: {points: {O: [0.1, 0.2], K: [0.4, 0.6]}}, crank: {joints: [D, A], length: 0.3}}
sliders: {pin: {joint: A, on: plate, through: [0.2, 0.1], angle: 30 deg}}
"""
)
ARM = (
    BASE
    + """
bars: {arm: {joints: [O, B], length: 0.5}, crank: {joints: [D, A], length: 0.3}}
sliders: {block: {joint: A, on: arm}}
"""
)
YOKE = (
    BASE
    + """
bars: {crank: {joints: [O, A], length: 0.1}}
sliders:
  yoke: {joint: Y, through: O, angle: 20 deg}
  pin: {joint: A, on: yoke, through: Y, angle: 90 deg}
"""
)


def turned(vector, angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ vector


def plate_pose(angle, reach, unit=1.0, **others):
    """The plate turned about O, with its pin so far along the axis."""
    axis = np.array([0.2, 0.1]) + reach * turned([1, 0], np.pi / 6)
    places = {
        "O": (0.0, 0.0),
        "D": (1.0, 0.0),
        "K": tuple(turned([0.3, 0.4], angle)),
        "A": tuple(turned(axis - [0.1, 0.2], angle)),
    }
    return Pose(linkages.loads(PLATE), places, **others).scaled(unit)


@pytest.mark.parametrize("angle", [0.0, 1.0, -2.5, 3.1])
@pytest.mark.parametrize("unit", [1.0, 1e3])
def test_axis_on_a_plate_that_turns(angle, unit):
    pose = plate_pose(angle, 0.25, unit)
    axis = pose.axis("pin")
    # a few roundings of numbers of order 1
    assert np.exp(1j * axis.angle) == pytest.approx(np.exp(1j * (angle + np.pi / 6)), abs=1e-14)
    assert axis.reach == pytest.approx(0.25 * unit, rel=1e-13)
    np.testing.assert_allclose(axis.at(axis.reach), pose.positions["A"], atol=1e-13 * unit)


def test_slot_spans_the_travel_and_more():
    pose = plate_pose(0.7, 0.25, travel={"pin": (0.1, 0.6)})
    axis, ends = pose.axis("pin"), pose.slot("pin")
    along = (ends - axis.origin) @ (np.cos(axis.angle), np.sin(axis.angle))
    assert along[0] < 0.1 < 0.6 < along[1]
    assert along_carrier(pose, "pin") is None
    without = plate_pose(0.7, 0.25).slot("pin")
    middle = without.mean(axis=0)
    np.testing.assert_allclose(middle, pose.positions["A"], atol=1e-12)


def test_a_single_joint_takes_the_angle_of_the_data():
    places = {"O": (0.0, 0.0), "A": (0.3, 0.1)}
    assert Pose(linkages.loads(PLATE), places).axis("pin") is None
    pose = Pose(linkages.loads(PLATE), places, {"plate": 0.4})
    assert pose.axis("pin").angle == pytest.approx(0.4 + np.pi / 6, rel=1e-15)


@pytest.mark.parametrize("reach", [0.2, 0.7, -0.1])
def test_an_axis_along_a_bar_has_its_ends(reach):
    way = turned([1, 0], 0.8)
    places = {"O": (0.0, 0.0), "B": tuple(0.5 * way), "A": tuple(reach * way)}
    pose = Pose(linkages.loads(ARM), places)
    assert along_carrier(pose, "block") == pytest.approx((0.0, 0.5))


def test_slider_on_a_slider():
    y = 0.3 * turned([1, 0], np.radians(20))
    a = y + 0.1 * turned([0, 1], np.radians(20))
    pose = Pose(linkages.loads(YOKE), {"O": (0.0, 0.0), "Y": tuple(y), "A": tuple(a)})
    assert pose.axis("yoke").reach == pytest.approx(0.3)
    axis = pose.axis("pin")
    assert axis.reach == pytest.approx(0.1)
    assert np.degrees(axis.angle) == pytest.approx(110.0)
    assert along_carrier(pose, "pin") is None


@pytest.mark.parametrize(
    ("law", "sense"),
    [
        ("{angle: 1, speed: 60 rpm}", 1),
        ("{angle: 1, speed: -2}", -1),
        ("{angle: 1, speed: 0}", 0),
        ("{law: sin(9*t)}", BOTH),
        ("{law: {rise: cycloidal, to: -1, duration: 0.5}}", -1),
        ("{law: {table: {times: [0, 1, 2], values: [0, 1, 0], periodic: true}}}", BOTH),
    ],
)
def test_sense_of_a_drive_over_the_run(law, sense):
    found = linkages.loads(f"{ARM}drives: {{crank: {law}}}\nsimulate: {{end: 2}}\n")
    assert drive_sense(found, "crank") == sense


def test_sense_of_loads():
    found = linkages.loads(
        f"{ARM}loads:\n  - {{bar: crank, torque: -3}}\n  - {{bar: arm, torque: cos(8*t)}}\n"
        "  - {joint: B, force: [0, 2*t - 4]}\n  - {joint: B, force: [0, 0]}\n"
    )
    (_, constant), (_, swinging) = measured(found.loads, Turn)
    assert load_sense(constant, found) == -1
    assert load_sense(swinging, found) == BOTH
    force, none = at_joints(found.loads).values()
    angle, sense = force_direction(force, found)
    assert (angle, sense) == (pytest.approx(-np.pi / 2), 1)
    assert force_direction(none, found)[1] == 0
