import math

import numpy as np
import pytest
from component_reading import complaints, component, mechanism

from linkages.components.contributed.load_measures import Actuation, Distance, Slide, Turn
from linkages.components.point_drives import (
    Actuator,
    HeightDrive,
    JointActuator,
    LinearActuator,
    PathDrive,
    PointDrive,
    SliderActuator,
)
from linkages.kernel.inputs import law_values

ARM = """joints: {O: [0, 0]}
bars:
  upper: {joints: [O, A], length: 0.4}
  fore: {joints: [A, P], length: 0.3}
sliders: {cart: {joint: P, through: O}}
drives:
"""


@pytest.mark.parametrize(
    ("entry", "expected"),
    [
        ("{x: 0.5, y: 0.1*t}", PointDrive(name="P", x=0.5, y="0.1*t")),
        ("{x: 500 mm}", PointDrive(name="P", x=0.5)),
        ("{y: 0.1*t}", HeightDrive(name="P", y="0.1*t")),
        (
            "{waypoints: [[0.5, 0], [0.4, 0.1]], progress: t}",
            PathDrive(name="P", waypoints=((0.5, 0.0), (0.4, 0.1)), progress="t"),
        ),
    ],
)
def test_same_from_yaml_and_python(entry, expected):
    found = component(f"{ARM}  P: {entry}\n", "drives", "P")
    assert found == expected


@pytest.mark.parametrize(
    ("entry", "expected", "measure"),
    [
        ("{bar: upper}", Actuator(name="m", bar="upper"), Turn("upper", None)),
        (
            "{bars: [upper, fore]}",
            JointActuator(name="m", bars=("upper", "fore")),
            Turn("fore", "upper"),
        ),
        ("{bars: [ground, fore]}", JointActuator(name="m", bars=("ground", "fore")),
         Turn("fore", None)),
        ("{slider: cart}", SliderActuator(name="m", slider="cart"), Slide("cart")),
        ("{between: [O, P]}", LinearActuator(name="m", between=("O", "P")), Distance("O", "P")),
    ],
)  # fmt: skip
def test_actuators_act_along_measures(entry, expected, measure):
    found = component(f"{ARM}  P: {{x: 0.5}}\nactuators: {{m: {entry}}}\n", "actuators", "m")
    assert found == expected
    assert found.terms() == (Actuation("m", measure, ("actuators", "m")),)


def curve(points, **more):
    """x and y of a drive over its progress, which is time here."""
    made = PathDrive(name="P", waypoints=points, progress="t", **more)
    laws = [term.law for term in made.terms()[2:]]
    return lambda t: np.array([law_values(law, np.array([t]))[0] for law in laws])


def test_two_points_are_a_straight_line():
    along = curve(((0.5, 0.1), (0.2, 0.5)))
    for part in (0.0, 0.3, 1.0):
        # three roundings of numbers below one
        assert along(part) == pytest.approx([0.5 - 0.3 * part, 0.1 + 0.4 * part], abs=3e-16)


def test_the_curve_passes_its_points_at_its_ends_and_rests_beyond():
    points = ((0.5, 0.1), (0.3, 0.2), (0.2, 0.5))
    along = curve(points)
    assert along(0.0) == pytest.approx(points[0], abs=1e-16)
    assert along(1.0) == pytest.approx(points[-1], abs=1e-16)
    assert along(1.5) == pytest.approx(points[-1], abs=1e-16)


def test_progress_is_a_part_of_the_length():
    """Twelve points of a circle: the curve is one up to 1e-3 of the radius, at constant speed."""
    turns = 2 * np.pi * np.arange(12) / 12
    points = tuple((0.5 + 0.1 * math.cos(a), 0.1 * math.sin(a)) for a in turns)
    along = curve(points, closed=True)
    for part in np.linspace(0.0, 2.0, 25):  # it goes on from where it began
        angle = 2 * np.pi * part
        expected = [0.5 + 0.1 * math.cos(angle), 0.1 * math.sin(angle)]
        # a cubic spline over arcs of h = 30° errs by h⁴/384 = 2e-4 of the radius
        assert along(part) == pytest.approx(expected, abs=3e-5)
    step = 1e-5
    speeds = [np.hypot(*(along(t + step) - along(t - step))) / (2 * step) for t in
              np.linspace(0.01, 0.99, 200)]  # fmt: skip
    # the speed of a spline over its length: h³ times a number below one tenth
    assert np.ptp(speeds) < 0.015 * np.mean(speeds)


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("P: {waypoints: [[0.5, 0]], progress: t}", "expected at least two points, found 1"),
        (
            "P: {waypoints: [[0.5, 0], [0.5, 0]], progress: t}",
            "expected points that differ, found number 2 at the one before",
        ),
        (
            "P: {waypoints: [[0.5, 0], [0.4, 0]], progress: t, closed: true}",
            "expected at least three points of a closed curve, found two",
        ),
        (
            "P: {waypoints: [[0.5, 0], [0.4, 0], [0.3, 0.1], [0.5, 0]], progress: t, closed: true}",
            "a closed curve returns by itself; expected its first point once",
        ),
        ("P: {x: 0.1*upper.angle, y: 0}", "'upper.angle' is refused"),
        ("O: {x: 0, y: 0}", "joint 'O' is fixed to the ground; expected another"),
        ("Q: {x: 0, y: 0}", "unknown joint 'Q'; expected one of: A, O, P"),
        ("P: {x: 3 kg}", "expected a length"),
    ],
)
def test_bad_drives_of_points(entry, found):
    arm = ARM.replace("sliders: {cart: {joint: P, through: O}}\n", "")
    (problem,) = complaints(f"{arm}  {entry}\n")
    assert problem.startswith("line 6, ")
    assert found in problem


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("{m: {bar: uper}}", "actuators.m.bar: unknown bar 'uper'; did you mean 'upper'?"),
        ("{upper: {bar: upper}}", "actuators.upper: the name 'upper' is taken already"),
        ("{m: {bars: [fore, fore]}}", "expected two different bodies"),
        ("{m: {between: [P, P]}}", "expected two different joints"),
        ("{m: {}}", "missing key 'bar'"),
    ],
)
def test_bad_actuators(entry, found):
    problems = complaints(f"{ARM}  P: {{x: 0.5}}\nactuators: {entry}\n")
    assert found in problems[0]


def test_saved_and_read_again():
    text = f"{ARM}  P: {{waypoints: [[0.5, 0], [0.4, 0.1]], progress: t}}\n"
    made = mechanism(f"{text}actuators: {{a: {{bar: upper}}, b: {{bars: [upper, fore]}}}}\n")
    assert mechanism(made.to_yaml()).components == made.components
