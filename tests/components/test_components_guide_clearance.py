"""Clearances of sliders in their guides: what they contribute, and what is wrong with them."""

import math

import numpy as np
import pytest

import linkages
from linkages import InputError
from linkages.topology.topology import build_topology

CRANK = """
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.1}
  rod: {joints: [A, B], length: 0.3}
sliders: {piston: {joint: B, through: O, mass: 0.5, inertia: 1e-3, points: {Q: [0.05, 0.01]}}}
clearances:
  play: {slider: piston, size: 1 mm, length: 60 mm, height: 40 mm, contact: hertz, stiffness: 1e9,
         offset: 0.2 mm, rate: 3 mm/s, angle: 0.5 deg, speed: 2}
drives: {crank: {angle: 0.3, speed: 5}}
assembly: {B: [0.39, 0]}
"""


@pytest.fixture(scope="module")
def mechanism():
    return linkages.loads(CRANK)


def test_block_takes_over_what_the_slider_has(mechanism):
    slider, block = (mechanism.bodies[name] for name in ("piston", "play.block"))
    assert list(slider.points) == ["B.play"]
    assert slider.mass.absent
    assert slider.inertia.absent
    assert list(block.points) == ["B", "Q"]
    assert (block.mass.value, block.inertia.value) == (0.5, 1e-3)
    assert {name: (own.position, own.speed) for name, own in mechanism.initial.items()} == {
        "play.offset": (pytest.approx(2e-4), pytest.approx(3e-3)),
        "play.tilt": (pytest.approx(math.radians(0.5)), 2.0),
    }
    corners = [(c.name, c.geometry.along, c.geometry.across) for c in mechanism.contacts]
    assert corners == [("play.corner1", -1, 1), ("play.corner2", 1, 1),
                       ("play.corner3", -1, -1), ("play.corner4", 1, -1)]  # fmt: skip


def test_two_coordinates_more_than_the_ideal_mechanism(mechanism):
    play, ideal = build_topology(mechanism), build_topology(mechanism.ideal())
    assert play.mobility == ideal.mobility + 2
    assert play.loops == ideal.loops
    assert ideal.mechanism.bodies["piston"].mass.value == 0.5


def test_joint_and_further_points_turn_with_the_block(mechanism):
    """B is beside the axis by the offset, Q at its place in the turned frame."""
    data = linkages.simulate(mechanism, times=[0.0, 1e-6], outputs=["joint_position"]).data
    place = {j: data.joint_position.sel(joint=j)[0].to_numpy() for j in ("B", "B.play", "Q")}
    np.testing.assert_allclose(place["B"] - place["B.play"], [0, 2e-4], atol=1e-16)
    c, s = math.cos(math.radians(0.5)), math.sin(math.radians(0.5))
    expected = [0.05 * c - 0.01 * s, 0.05 * s + 0.01 * c]
    np.testing.assert_allclose(place["Q"] - place["B"], expected, atol=1e-15)


def test_definition_and_states_come_back(mechanism):
    assert linkages.loads(mechanism.to_yaml()) == mechanism
    moved = mechanism.with_state({"play.tilt": (0.01, -1.0)})
    assert moved.initial["play.tilt"].position == 0.01
    assert moved.initial["play.offset"] == mechanism.initial["play.offset"]


CHANGES = {
    "no such slider": ({"slider": "pistn"}, "unknown slider 'pistn'; did you mean 'piston'?"),
    "a bar": ({"slider": "rod"}, "unknown slider 'rod'; expected one of: piston"),
    "no length": ({"length": None}, "play.length: expected a length > 0"),
    "no height": ({"height": None}, "play.height: expected a length > 0"),
    "a joint as well": ({"joint": "B"}, "unknown key 'joint'"),
    "no stiffness": ({"stiffness": None}, "missing key 'stiffness', which hertz needs"),
    "too much play": ({"size": "17 mm"}, "the block could turn over: its diagonal is 0.07"),
    "outside": ({"offset": "2.5 mm"}, "a corner starts"),
    "turned into the walls": ({"angle": "5 deg"}, "a corner starts"),
    "across": ({"angle": "95 deg"}, "expected a block less than 90 deg from its guide, found 95"),
    "friction without slip": ({"friction": 0.1}, "missing key 'slip'"),
    "oil": ({"contact": "lubricated", "stiffness": None}, "a law of journals in bearings"),
}  # fmt: skip


@pytest.mark.parametrize(("keys", "said"), CHANGES.values(), ids=CHANGES)
def test_what_is_wrong_is_said_at_its_key(mechanism, keys, said):
    with pytest.raises(InputError) as caught:
        mechanism.with_values({f"clearances.play.{key}": value for key, value in keys.items()})
    assert said in str(caught.value)
    assert "clearances.play" in str(caught.value)


def test_contact_needs_a_joint_or_a_slider(mechanism):
    values = {"clearances.play": {"size": "1 mm", "contact": "hertz", "stiffness": 1e9}}
    with pytest.raises(InputError, match="missing key 'joint'"):
        mechanism.with_values(values)


def test_block_without_inertia_is_refused(mechanism):
    with pytest.raises(InputError, match=r"piston.*inertia"):
        mechanism.with_values({"sliders.piston.inertia": 0.0, "sliders.piston.points": {}})


def test_name_of_the_clearance_is_its_own(mechanism):
    taken = {"clearances.rod": mechanism.definition.content["clearances"]["play"]}
    with pytest.raises(InputError, match="the name 'rod' is taken already"):
        mechanism.with_values(taken)


def test_one_clearance_for_each_slider(mechanism):
    again = {"clearances.more": mechanism.definition.content["clearances"]["play"]}
    with pytest.raises(InputError, match="'play' gives slider 'piston' room already"):
        mechanism.with_values(again)
