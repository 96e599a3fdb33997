"""Symbols of friction and of room in guides: where they are, and that they are no dampers."""

import numpy as np
import pytest
from drawn_shapes import SCALE, corners, shapes, words

import linkages
from linkages.kernel.system import System
from linkages.plots.mechanism.drawing import start_pose
from linkages.plots.mechanism.guide_symbols import RAIL
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.shapes import BLOCK, Strokes

CRANK = """
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.1}, rod: {joints: [A, B], length: 0.3}}
sliders: {piston: {joint: B, through: O, mass: 1, inertia: 1e-3}}
drives: {crank: {angle: 0, speed: 1}}
"""
RUBBED = """
friction: [{joint: A, torque: 1}, {slider: piston, force: 2}]
"""
LOOSE = """
clearances:
  play: {slider: piston, size: 1 mm, length: 60 mm, height: 40 mm, contact: hertz, stiffness: 1e9}
"""
PLACES = {"O": (0.0, 0.0), "A": (0.1, 0.0), "B": (0.4, 0.0)}


def pose_of(more, **places):
    return Pose(linkages.loads(CRANK + more), {**PLACES, **places})


def test_friction_has_shoes_at_a_joint_and_linings_in_a_guide_and_is_no_damper():
    pose = pose_of(RUBBED)
    assert not shapes(pose, role="spring")
    linings, _, shoes, _ = shapes(pose, Strokes, role="friction")
    assert linings.closed
    assert shoes.closed
    out = SCALE * np.abs(corners(pose, linings) - PLACES["B"])
    assert out[:, 1].max() == pytest.approx(BLOCK[1])  # on both faces of the block
    assert out[:, 0].max() < BLOCK[0]
    apart = SCALE * (corners(pose, shoes) - PLACES["A"])
    assert np.hypot(*apart.T).min() > 2.9  # beside the pin
    assert np.abs(apart[:, 1]).min() > 1.7  # and beside the bars, which are along
    assert not shapes(pose_of(""), role="friction")


def test_room_in_a_guide_is_drawn_in_the_colour_of_clearances():
    pose = pose_of(LOOSE, **{"B.play": PLACES["B"]})
    (walls,) = shapes(pose, Strokes, role="clearance")
    heights = SCALE * np.unique(np.round(corners(pose, walls)[:, 1], 12))
    assert heights == pytest.approx([-RAIL, RAIL])
    (block,) = (s for s in shapes(pose, Strokes, fill="pale") if len(s.strokes[0]) == 4)
    assert SCALE * corners(pose, block)[:, 1].max() < RAIL - 3.0
    assert "play" in words(pose)
    tight = pose_of("")
    assert not shapes(tight, role="clearance")
    (block,) = (s for s in shapes(tight, Strokes, fill="pale") if len(s.strokes[0]) == 4)
    assert SCALE * corners(tight, block)[:, 1].max() > RAIL - 2.0


def test_a_block_with_room_is_where_its_joint_is():
    pose = pose_of(LOOSE, **{"B.play": PLACES["B"], "B": (0.4, 0.01)})
    (block,) = (s for s in shapes(pose, Strokes, fill="pale") if len(s.strokes[0]) == 4)
    assert corners(pose, block).mean(axis=0) == pytest.approx([0.4, 0.01])


def test_points_that_no_definition_can_name_have_no_label():
    pose = start_pose(System(linkages.load("beam-pump")))
    assert "weight.center" in pose.positions
    assert not [word for word in words(pose) if "weight." in word]
    assert {"weight", "A", "crank"} <= set(words(pose))


def test_a_torsional_spring_in_series_with_a_damper_is_one_symbol():
    text = "joints: {O: [0, 0]}\nbars: {arm: {joints: [O, A], length: 0.1, mass: 1}}\n"
    free = "\nfree: {arm: {angle: 0, speed: 1}}"
    places = {"O": (0.0, 0.0), "A": (0.1, 0.0)}
    series = "maxwell: [{bar: arm, stiffness: 5, damping: 0.4}]"
    beside = "springs: [{bar: arm, stiffness: 5, angle: 0, damping: 0.4}]"
    (one,) = shapes(Pose(linkages.loads(text + series + free), places), role="spring")
    ends = {tuple(np.round(anchor.points, 6)) for anchor in one.strokes[0][-1:]}
    assert ends == {tuple(np.round(one.strokes[1][0].points, 6))}  # tied to the spring
    assert len(shapes(Pose(linkages.loads(text + beside + free), places), role="spring")) == 2
