import math

import pytest
from component_reading import complaints, component
from law_values import parameters, value

from linkages.components.actuators import Drive, SliderDrive
from linkages.components.contributed.functions import linear
from linkages.components.contributed.terms import Parameter, Prescribed

CRANK = "joints: {O: [0, 0]}\nbars: {crank: {joints: [O, A], length: 0.3}}\ndrives:\n"
MOTOR = Drive(name="crank", angle=0.5, speed=-math.pi)


def test_same_from_yaml_and_python():
    assert component(CRANK + "  crank: {angle: 0.5, speed: -pi}\n", "drives", "crank") == MOTOR


def test_units():
    motor = component(CRANK + "  crank: {angle: 180 deg, speed: 30 rpm}\n", "drives", "crank")
    # one rounding for the unit
    assert math.isclose(motor.angle, math.pi, rel_tol=2e-16)
    assert math.isclose(motor.speed, math.pi, rel_tol=4e-16)


def test_terms():
    (term,) = MOTOR.terms()
    angle = Parameter(("drives", "crank", "angle"), 0.5)
    speed = Parameter(("drives", "crank", "speed"), -math.pi)
    # a drive that happens to start at 0 or to stand still needs no kernel of its own
    assert term == Prescribed("crank", linear(angle, speed), ("drives", "crank"))


def test_drives_turn_bars_and_plates():
    assert MOTOR.references().bodies == ((("drives", "crank"), "crank", ("bar", "plate")),)
    (problem,) = complaints(CRANK + "  crank2: {angle: 0, speed: 1}\n")
    assert problem == "line 4, column 3, drives.crank2: unknown bar 'crank2'; did you mean 'crank'?"


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("{angle: 0}", "missing key 'speed': expected either 'angle' and 'speed', or 'law'"),
        ("{speed: 0}", "missing key 'angle': expected either 'angle' and 'speed', or 'law'"),
        ("{}", "missing keys: expected either 'angle' and 'speed', or 'law'"),
        (
            "{law: t, speed: 1}",
            "'law' and 'speed' are both given; expected either 'angle' and 'speed', or 'law'",
        ),
    ],
)
def test_one_law(entry, found):
    assert complaints(CRANK + f"  crank: {entry}\n") == [f"line 4, column 3, drives.crank: {found}"]


def test_law_of_time():
    drive = component(CRANK + "  crank: {law: 0.5 + 0.2*sin(2*t)}\n", "drives", "crank")
    assert drive == Drive(name="crank", law="0.5 + 0.2*sin(2*t)")
    (term,) = drive.terms()
    assert value(term.law, 0.7) == pytest.approx(0.5 + 0.2 * math.sin(1.4), rel=1e-15)
    assert [p.path for p in parameters(term.law)] == [
        ("drives", "crank", "law", place) for place in range(3)
    ]


def test_named_law_in_degrees():
    entry = "{law: {harmonic: {amplitude: 20 deg, frequency: 2}}}"
    (term,) = component(CRANK + f"  crank: {entry}\n", "drives", "crank").terms()
    # a quarter of a period
    assert value(term.law, 0.125) == pytest.approx(math.radians(20), rel=1e-15)


SLIDER = """joints: {O: [0, 0]}
bars: {rod: {joints: [A, B], length: 1}}
sliders: {ram: {joint: A, through: O}}
drives:
"""
RAM = SliderDrive(name="ram", position=0.1, speed=-0.2)


def test_sliders_are_driven_along_their_axis():
    assert component(SLIDER + "  ram: {position: 10 cm, speed: -0.2}\n", "drives", "ram") == RAM
    (term,) = RAM.terms()
    position = Parameter(("drives", "ram", "position"), 0.1)
    speed = Parameter(("drives", "ram", "speed"), -0.2)
    assert term == Prescribed("ram", linear(position, speed), ("drives", "ram"))


def test_law_of_a_slider_is_a_length():
    made = component(SLIDER + "  ram: {law: 20 mm}\n", "drives", "ram")
    assert made == SliderDrive(name="ram", law=0.02)
    (problem,) = complaints(SLIDER + "  ram: {law: 20 deg}\n")
    assert problem.endswith("found '20 deg': deg is an angle, not a length")
    (problem,) = complaints(CRANK + "  crank: {law: 20 mm}\n")
    assert problem.endswith("found '20 mm': mm is a length, not an angle")


def test_angles_are_of_bars_and_positions_of_sliders():
    (problem,) = complaints(SLIDER + "  ram: {angle: 0, speed: 1}\n")
    assert "drives.ram.angle: unknown key 'angle'; expected one of: position, speed" in problem
    (problem,) = complaints(CRANK + "  crank: {position: 0, speed: 1}\n")
    assert "drives.crank: unknown slider 'crank'" in problem
