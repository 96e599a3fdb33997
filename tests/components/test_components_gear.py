import math

import pytest
from component_reading import complaints, component, mechanism

from linkages.components.contributed.terms import Parameter, Relation
from linkages.components.transmissions import Gear

WHEELS = """joints: {O: [0, 0], C: [1, 0]}
bars:
  sun: {joints: [O, P], length: 0.1}
  planet: {joints: [A, Q], length: 0.1}
  arm: {joints: [O, A], length: 0.3}
gears:
"""
FULL = Gear(index=0, bars=("sun", "planet"), ratio=-2, carrier="arm", angle=math.pi)


def test_same_from_yaml_and_python():
    entry = "{bars: [sun, planet], ratio: -4/2, carrier: arm, angle: 180 deg}"
    assert component(WHEELS + f"- {entry}\n", "gears", 0) == FULL


def relation(**keys):
    (term,) = Gear(index=0, ratio=-2, **keys).terms()
    return term


def test_terms():
    ratio = Parameter(("gears", 0, "ratio"), -2.0)
    angle = Parameter(("gears", 0, "angle"), 0.0, structural=True)
    found = relation(bars=("sun", "planet"))
    assert found == Relation("planet", (("sun", ratio),), angle, ("gears", 0))


def test_seen_from_the_carrier():
    """θ_b − θ_c = ratio·(θ_a − θ_c) + angle, whatever the angles."""
    angles = {"sun": 0.3, "arm": -1.1}
    found = FULL.terms()[0]
    planet = found.offset.value + sum(p.value * angles[name] for name, p in found.parts)
    assert planet + 1.1 == pytest.approx(-2 * (0.3 + 1.1) + math.pi, rel=1e-15)


def test_wheel_that_stands_still():
    found = relation(bars=("ground", "planet"), carrier="arm")
    assert [(name, share.value) for name, share in found.parts] == [("arm", 3.0)]


def test_ground_as_carrier_is_no_carrier():
    assert relation(bars=("sun", "planet"), carrier="ground") == relation(bars=("sun", "planet"))
    assert mechanism(WHEELS + "- {bars: [sun, arm], ratio: 2, carrier: ground}\n").relations


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("{bars: [sun, planed], ratio: 2}", "gears[0].bars[1]: unknown bar 'planed'; did you"),
        ("{bars: [sun, planet], ratio: 2, carrier: amr}", "gears[0].carrier: unknown bar 'amr'"),
        ("{bars: [sun, planet], ratio: 0}", "gears[0].ratio: expected a ratio other than 0"),
        ("{bars: [sun, sun], ratio: 2}", "expected two different bodies, found 'sun' twice"),
        (
            "{bars: [sun, arm], ratio: 2, carrier: arm}",
            "gears[0].carrier: expected a third body, found 'arm' again",
        ),
        ("{bars: [ground, arm], ratio: 2}", "gears[0]: missing key 'carrier': a wheel that"),
        ("{bars: [arm, ground], ratio: 2}", "the ground can stand first only"),
        ("{bars: [sun, planet]}", "gears[0]: missing key 'ratio': expected a number"),
    ],
)
def test_wrong_entries(entry, found):
    assert any(found in problem for problem in complaints(WHEELS + f"- {entry}\n"))
