import math

import pytest
from component_reading import assert_frozen_and_keyword_only, complaints, component

from linkages.components.slider import Slider
from linkages.components.terms import ZERO

CRANK = """joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.3}
  rod: {joints: [A, B], length: 0.8}
sliders:
"""
BARE = Slider(name="piston", joint="B", through="O")


@pytest.mark.parametrize(
    ("entry", "slider"),
    [
        ("{joint: B, through: O}", BARE),
        (
            "{joint: B, through: [1 cm, -0.2], angle: 30 deg, mass: 3}",
            Slider(name="piston", joint="B", through=(0.01, -0.2), angle=math.radians(30), mass=3),
        ),
    ],
)
def test_same_from_yaml_and_python(entry, slider):
    assert component(CRANK + f"  piston: {entry}\n", "sliders", "piston") == slider


def test_frozen_and_keyword_only():
    assert_frozen_and_keyword_only(BARE)


def test_defaults():
    assert (BARE.angle, BARE.mass) == (0.0, 0.0)


def test_terms():
    (body,) = Slider(name="piston", joint="B", through=(0.0, -0.2), angle=0.5, mass=3).terms()
    assert (body.name, body.kind, body.path) == ("piston", "slider", ("sliders", "piston"))
    assert not body.rotates
    assert dict(body.points) == {"B": (ZERO, ZERO)}
    assert body.mass.value == 3
    assert [p.value for p in body.guide.origin] == [0.0, -0.2]
    assert [p.absent for p in body.guide.origin] == [True, False]
    assert body.guide.angle.value == 0.5
    assert not body.guide.angle.structural  # an axis along x is still an axis


def test_axis_through_a_ground_joint():
    assert BARE.terms()[0].guide.origin == "O"
    assert BARE.references().ground == ((("sliders", "piston", "through"), "O"),)


def test_axis_through_a_moving_joint():
    (problem,) = complaints(CRANK + "  piston: {joint: B, through: A}\n")
    assert problem == (
        "line 6, column 22, sliders.piston.through: unknown ground joint 'A'; expected one of: O"
    )


def test_neither_joint_nor_point():
    (problem,) = complaints(CRANK + "  piston: {joint: B, through: [1]}\n")
    assert problem.startswith("line 6, column 22, sliders.piston.through: expected ")
