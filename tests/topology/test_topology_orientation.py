"""What orientations follow from: bodies of their own, guides, welds and gears."""

import numpy as np
import pytest
from linkage_files import FOUR_BAR, linkage, mechanism

from linkages.topology.decomposition import (
    Orientation,
    followers_of,
    orientations,
    turned_bodies,
)
from linkages.topology.topology import build_topology, turning_gradients

ARMS = """
joints: {O: [0, 0], C: [1, 0], D: [2, 0]}
bars:
  one: {joints: [O, A], length: 1}
  two: {joints: [A, B], length: 1}
  wheel: {joints: [C, P], length: 1}
  other: {joints: [D, Q], length: 1}
sliders:
  ram: {joint: X, on: two, through: A}
  tail: {points: {Y: [0.1, 0.1]}, joint: Z, on: ram}
  block: {joint: W, through: O}
welds: {A: {bars: [one, two], angle: 0.3}}
gears:
  - {bars: [two, wheel], ratio: -2}
  - {bars: [wheel, other], carrier: one, ratio: 0.3}
SPRINGS
drives: {one: {angle: 0, speed: 1}, ram: {position: 1, speed: 0}, tail: {position: 1, speed: 0},
  block: {position: 1, speed: 0}}
"""


def arms(springs=""):
    text = ARMS.replace("SPRINGS", springs)
    bars = "  k: {joints: [X, X2], length: 1}\n  l: {joints: [Z, Z2], length: 1}\n"
    bars += "  m: {joints: [W, W2], length: 1}\n"
    text = text.replace("sliders:", bars + "sliders:")
    free = "free: {k: {angle: 0}, l: {angle: 0}, m: {angle: 0}}\n"
    return mechanism(text + free)


def test_everything_follows_from_its_masters():
    """Rigid is what keeps a constant angle against one master."""
    of = arms()
    found = orientations(of, followers_of(of))
    one = ("one",)
    assert found["one"] == found["two"] == Orientation(one, rigid=True, moved=one)
    for name in ("ram", "tail"):
        assert found[name] == Orientation(one, rigid=True, moved=(name,))
    assert found["wheel"] == found["other"] == Orientation(one, rigid=False, moved=one)
    assert found["block"] == Orientation((), rigid=True, moved=("block",))
    assert found["k"] == Orientation(("k",), rigid=True, moved=("k",))


def test_gradients_of_a_train():
    """θ_two = θ_one + 0.3, θ_wheel = −2 θ_two, θ_other = 0.3 θ_wheel + 0.7 θ_one."""
    gradients = turning_gradients(build_topology(arms()))
    assert gradients["two"] == gradients["ram"] == gradients["tail"] == {"one": 1.0}
    assert gradients["wheel"] == {"one": -2.0}
    assert gradients["other"] == pytest.approx({"one": 0.3 * -2 + 0.7})
    assert gradients["block"] == {}
    assert gradients["l"] == {"l": 1.0}


def test_whole_turns_count_where_gears_and_springs_see_them():
    assert turned_bodies(arms()) == {"two", "wheel", "other", "one"}
    sprung = arms("springs: [{bar: k, stiffness: 2}, {between_bars: [l, m], stiffness: 1}]")
    assert turned_bodies(sprung) == {"two", "wheel", "other", "one", "k", "l", "m"}
    damped = arms("springs: [{bar: k, stiffness: 0, damping: 2}]")
    assert "k" not in turned_bodies(damped)
    assert turned_bodies(linkage("ninebar")) == set()


def test_mobility_loses_one_for_each_relation():
    topology = build_topology(arms())
    assert topology.mobility == 7
    assert {*topology.followers} == {"two", "wheel", "other"}
    assert topology.carried == ()  # all masters are driven or free


def test_dependent_angles_that_are_seen_turn_by_turn_are_carried_along():
    drives = "drives: {crank: {angle: 1, speed: 1}}\n"
    for spring, carried in (
        ("bar: crank", ()),
        ("bar: coupler", ("coupler",)),
        ("between_bars: [coupler, rocker]", ("coupler", "rocker")),
        ("between: [O, B], length: 1", ()),
    ):
        springs = f"springs: [{{{spring}, stiffness: 2}}]\n"
        topology = build_topology(mechanism(FOUR_BAR + drives + springs))
        assert topology.carried == carried
        assert all(topology.unwrapped(name) for name in carried)
        assert topology.iterated == ()
        assert topology.coordinates == (*topology.free, *carried)


def test_gradients_of_geared_wheels_by_differences():
    """Angles as the kernel computes them, along the crank."""
    from linkages.kernel.system import System

    of = System(arms())
    angles = [of.model.positions.angle(name) for name in ("one", "two", "wheel", "other")]
    step = 0.25
    slope = (of.evaluate(angles, step) - of.evaluate(angles, -step))[:, 0] / (2 * step)
    gradients = turning_gradients(of.topology)
    expected = [gradients[name]["one"] for name in ("one", "two", "wheel", "other")]
    assert slope == pytest.approx(np.array(expected), abs=1e-14)  # linear: differences are exact
