"""Springs in guides, cylinders, motors and forces that turn with a body are in drawings."""

import numpy as np
import pytest
from drawn_shapes import SCALE, arrows, corners, discs, shapes, words

import linkages
from linkages.plots.mechanism.load_symbols import STUB
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.shapes import AMPLITUDE, CUP, Strokes

CART = """
joints: {O: [0, 0]}
sliders: {cart: {joint: C, through: O, mass: 2}}
bars: {arm: {joints: [C, P], length: 0.4, mass: 1}}
free: {cart: {position: 0.3, speed: 0}, arm: {angle: 0.5, speed: 0}}
"""


def posed(text, angle=0.5):
    tip = (0.3 + 0.4 * np.cos(angle), 0.4 * np.sin(angle))
    return Pose(linkages.loads(CART + text), {"O": (0, 0), "C": (0.3, 0), "P": tip})


def symbols_of(pose):
    """Symbols of springs, dampers and cylinders; walls have a name."""
    found = [*shapes(pose, Strokes, role="spring"), *shapes(pose, Strokes, role="cylinder")]
    return [shape for shape in found if not shape.name]


@pytest.mark.parametrize(
    ("text", "symbols"),
    [
        ("springs: [{slider: cart, stiffness: 3}]", 1),
        ("springs: [{slider: cart, stiffness: 3, damping: 1}]", 2),
        ("springs: [{slider: cart, stiffness: 0}]", 0),
        ("springs: [{between: [O, P], force: 3}]", 1),
        ("springs: [{between: [O, P], force: 3, damping: 1}]", 2),
        ("springs: [{between: [O, P], force: 0}]", 0),
        ("maxwell: [{between: [O, P], stiffness: 3, damping: 1}]", 1),
        ("maxwell: [{slider: cart, stiffness: 3, damping: 1}]", 1),
        ("loads: [{between: [O, P], force: 3}]", 1),
        ("cylinders: {c: {between: [O, P], bore: 0.1, pressure: 1e5}}", 1),
        ("cylinders: {c: {between: [O, P], bore: 0.1, pressure: 1e5, damping: 3}}", 1),
        ("cylinders: {c: {between: [O, P], bore: 0.1, pressure: 0}}", 0),
    ],
)
def test_each_has_its_symbol(text, symbols):
    assert len(symbols_of(posed(text))) == symbols


def test_spring_and_damper_of_a_maxwell_element_lie_in_line():
    pose = posed("maxwell: [{between: [O, P], stiffness: 3, damping: 1}]")
    (element,) = symbols_of(pose)
    way = np.array(pose.positions["P"])
    length = np.linalg.norm(way)
    places = corners(pose, element)
    along, across = places @ way / length, places @ (-way[1], way[0]) / length
    assert (along.min(), along.max()) == pytest.approx((0.0, length))
    assert np.abs(across).max() * SCALE <= max(AMPLITUDE, CUP[1]) + 1e-9


def test_spring_and_damper_of_a_block_stand_beside_each_other():
    pose = posed("springs: [{slider: cart, stiffness: 3, damping: 1}]")
    heights = [corners(pose, shape)[2, 1] * SCALE for shape in symbols_of(pose)]
    assert sorted(heights) == pytest.approx([-5.0, 5.0])


def test_a_wall_stands_still_while_the_spring_of_a_block_gives_way():
    first = posed("springs: [{slider: cart, stiffness: 3}]")
    later = Pose(first.mechanism, {"O": (0, 0), "C": (0.4, 0), "P": (0.8, 0.1)})
    spring, wall = shapes(first, Strokes, role="spring")
    np.testing.assert_array_equal(corners(first, wall), corners(later, wall))
    drawn_out = np.ptp(corners(later, spring), axis=0) - np.ptp(corners(first, spring), axis=0)
    assert drawn_out == pytest.approx([0.1, 0.0], abs=1e-12)


def test_coils_part_as_a_spring_is_drawn_out():
    first = posed("springs: [{between: [O, P], stiffness: 3, length: 0.1}]")
    (spring,) = symbols_of(first)
    later = Pose(
        first.mechanism, {name: (3 * x, 3 * y) for name, (x, y) in first.positions.items()}
    )
    gaps = []
    for pose in (first, later):
        teeth = corners(pose, spring)[7:-1]  # after both stubs and the beginning of the coils
        gaps.append(np.hypot(*(teeth[2:] - teeth[:-2]).T))
    lengths = [np.hypot(*pose.positions["P"]) - 2 * STUB / SCALE for pose in (first, later)]
    assert gaps[1] / gaps[0] == pytest.approx(lengths[1] / lengths[0])


RACK = """
joints: {O: [0, 0]}
bars: {wheel: {joints: [O, P], length: 0.05}}
sliders: {rack: {joint: R, through: [0, 0.1], angle: 90 deg}}
drives: {wheel: {angle: 0.3, speed: 1}}
"""


def rack_pose(text, angle=0.3):
    tip = (0.05 * np.cos(angle), 0.05 * np.sin(angle))
    return Pose(linkages.loads(text), {"O": (0, 0), "P": tip, "R": (0.0, 0.2)})


@pytest.mark.parametrize(("radius", "side"), [(0.05, 1.0), (-0.05, -1.0)])
def test_a_rack_touches_the_pitch_circle_of_its_pinion(radius, side):
    pose = rack_pose(RACK + f"racks: [{{slider: rack, bar: wheel, radius: {radius}}}]\n")
    assert 0.05 in [radius for _, radius in discs(pose, width=1.0)]
    # it goes up where a wheel that turns counter-clockwise has its right side
    (line,) = shapes(pose, Strokes, width=1.6)
    assert corners(pose, line)[:, 0] == pytest.approx(side * 0.05, abs=1e-15)


def test_a_cam_is_drawn_through_its_roller():
    more = """
cams:
  - {slider: rack, bar: wheel, angles: [0, 120 deg, 240 deg, 360 deg], lifts: [0, 0.02, 0.05, 0],
     base_radius: 0.04, roller_radius: 0.01, eccentricity: 0.01}
"""
    pose = rack_pose(RACK + more, angle=np.deg2rad(120))
    cams = shapes(pose, Strokes, role="driven", width=1.0)
    (outline,) = (found for found in (corners(pose, cam) for cam in cams) if len(found) == 361)
    place = np.array([0.01, np.sqrt(0.05**2 - 0.01**2) + 0.02])
    assert np.hypot(*(outline - place).T).min() < 1e-3  # a point every degree
    assert 0.01 in [radius for _, radius in discs(pose)]  # the roller


def test_a_motor_is_an_arrow_both_ways():
    pose = posed("motors: {m: {bar: arm, stall_torque: 1, no_load_speed: 9}}")
    ((_, _, heads),) = arrows(pose, "load")
    assert heads == 2
    assert "M(v)" in words(pose)


@pytest.mark.parametrize("angle", [0.5, 2.0])
def test_a_force_that_turns_is_drawn_in_the_frame_of_its_body(angle):
    pose = posed("loads: [{joint: C, on: arm, force: [0, 3]}]", angle)
    ((start, tip, _),) = arrows(pose, "load")
    way = tip - start
    assert way / np.hypot(*way) == pytest.approx((-np.sin(angle), np.cos(angle)), abs=1e-12)
