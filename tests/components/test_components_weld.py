import math

import pytest
from component_reading import complaints, component, mechanism

from linkages.components.contributed.terms import Parameter, Relation
from linkages.components.rigid_bodies import Weld

BARS = """joints: {O: [0, 0], C: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.3}
  rod: {joints: [A, B], length: 0.8}
  rocker: {joints: [C, B], length: 0.7}
welds:
"""
BENT = Weld(name="A", bars=("crank", "rod"), angle=math.pi / 2)


def test_same_from_yaml_and_python():
    assert component(BARS + "  A: {bars: [crank, rod], angle: 90 deg}\n", "welds", "A") == BENT


def test_terms():
    one = Parameter((), 1.0, structural=True)
    angle = Parameter(("welds", "A", "angle"), math.pi / 2, structural=True)
    assert BENT.terms() == (Relation("rod", (("crank", one),), angle, ("welds", "A")),)


def test_to_the_ground():
    (relation,) = mechanism(BARS + "  C: {bars: [ground, rocker], angle: 1}\n").relations
    assert (relation.body, relation.parts, relation.offset.value) == ("rocker", (), 1.0)


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        (
            "A: {bars: [crank, rocker], angle: 0}",
            "welds.A.bars[1]: 'rocker' does not turn at joint 'A'; found crank, rod",
        ),
        (
            "A: {bars: [ground, rod], angle: 0}",
            "welds.A.bars[0]: 'ground' does not turn at joint 'A'; found crank, rod",
        ),
        ("E: {bars: [crank, rod], angle: 0}", "welds.E: unknown joint 'E'"),
        ("A: {bars: [crank, rot], angle: 0}", "welds.A.bars[1]: unknown bar 'rot'"),
        ("A: {bars: [rod, rod], angle: 0}", "welds.A.bars: expected two different bodies"),
        ("C: {bars: [rocker, ground], angle: 0}", "the ground can stand first only"),
        ("A: {bars: [crank, rod]}", "welds.A: missing key 'angle'"),
    ],
)
def test_wrong_entries(entry, found):
    assert any(found in problem for problem in complaints(BARS + f"  {entry}\n"))
