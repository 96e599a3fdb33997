import math

import pytest
from component_reading import complaints, component, mechanism

from linkages.components.contributed.terms import ZERO, Guide, Parameter
from linkages.components.rigid_bodies import Slider

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


def test_ground_axis_goes_through_something():
    assert complaints(CRANK + "  piston: {joint: B}\n") == [
        "line 6, column 3, sliders.piston: missing key 'through': expected a ground joint or a "
        "point [x, y] that the axis goes through"
    ]


SCOTCH_YOKE = """joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.3}}
sliders:
  yoke: {joint: Y, through: O}
  pin: {joint: A, on: yoke, through: Y, angle: 90 deg}
"""


def test_axis_on_another_slider():
    bodies = mechanism(SCOTCH_YOKE).bodies
    angle = Parameter(("sliders", "pin", "angle"), math.pi / 2)
    assert bodies["pin"].guide == Guide((ZERO, ZERO), angle, "yoke")
    assert bodies["yoke"].guide.body is None
    assert mechanism(SCOTCH_YOKE).labels("pin") == ("pin.axis", "A")
    assert [*mechanism(SCOTCH_YOKE).attachments["yoke"]] == ["Y", "pin.axis"]


@pytest.mark.parametrize(
    ("through", "origin"),
    [
        ("", (0.0, 0.0)),
        ("through: A, ", (0.0, 0.0)),
        ("through: B, ", (0.8, 0.0)),
        ("through: [1 cm, -0.2], ", (0.01, -0.2)),
    ],
)
def test_axis_on_a_bar(through, origin):
    text = CRANK + f"  bead: {{joint: W, on: rod, {through}inertia: 2e-3}}\n"
    body = mechanism(text + "free: {bead: {position: 0.1}}\n").bodies["bead"]
    assert body.guide.body == "rod"
    assert tuple(p.value for p in body.guide.origin) == origin
    assert body.inertia == Parameter(("sliders", "bead", "inertia"), 2e-3, structural=True)


def test_through_a_joint_that_the_carrier_lacks():
    assert complaints(CRANK + "  bead: {joint: O, on: rod, through: O}\n") == [
        "line 6, column 29, sliders.bead.through: bar 'rod' has no joint 'O'; it has A, B"
    ]


def test_further_points():
    made = Slider(name="piston", joint="B", through="O", points={"Q": (0.1, "2 cm")})
    entry = "{joint: B, through: O, points: {Q: [0.1, 2 cm]}}"
    assert component(CRANK + f"  piston: {entry}\n", "sliders", "piston") == made
    (body,) = made.terms()
    assert [*body.points] == ["B", "Q"]
    path = ("sliders", "piston", "points", "Q")
    assert body.points["Q"] == (
        Parameter((*path, 0), 0.1, structural=True),
        Parameter((*path, 1), 0.02, structural=True),
    )


@pytest.mark.parametrize(
    ("points", "found"),
    [
        ("{B: [0.1, 0]}", "points.B: 'B' is the slider's joint, at [0, 0]"),
        ("{Q: [0, 0]}", "points.Q: 'Q' lies on 'B'; expected two places"),
        ("{Q: [0, 1], R: [0, 1]}", "points.R: 'R' lies on 'Q'; expected two places"),
    ],
)
def test_points_at_one_place(points, found):
    (problem,) = complaints(CRANK + f"  piston: {{joint: B, through: O, points: {points}}}\n")
    assert problem.endswith(found)


@pytest.mark.parametrize(
    ("entries", "found"),
    [
        (
            "  a: {joint: B, on: a}\n",
            "sliders.a.on: expected an axis carried by another body: a → a",
        ),
        (
            "  a: {joint: B, on: b}\n  b: {joint: A, on: a}\n",
            "sliders.a.on: expected an axis carried by another body: a → b → a",
        ),
        ("  a: {joint: B, on: rot}\n", "sliders.a.on: unknown bar 'rot'; did you mean 'rod'?"),
        (
            "  a: {joint: B, on: rod}\n",
            "sliders.a.joint: 'rod' has joint 'B' itself; expected a joint that slides on it",
        ),
    ],
)
def test_what_cannot_carry_an_axis(entries, found):
    (problem,) = complaints(CRANK + entries)
    assert problem.endswith(found)


@pytest.mark.parametrize(
    "rest",
    [
        "free: {block: {position: 0}}",
        "drives: {block: {law: t}}",
        "masses: {W: 1}",
        "springs: [{between: [O, W], stiffness: 1, length: 1}]",
        "loads: [{joint: W, force: [1, 0]}]",
    ],
)
def test_a_block_may_be_alone_if_something_tells_that_it_is_meant(rest):
    text = CRANK + "  block: {joint: W, through: O}\n"
    assert mechanism(text + rest + "\n").bodies["block"]
    assert len(complaints(text)) == len(complaints(text + "assembly: {W: [0, 1]}\n")) - 1 == 1
