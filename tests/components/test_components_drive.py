import math

from component_reading import assert_frozen_and_keyword_only, complaints, component

from linkages.components.drive import Drive

CRANK = "joints: {O: [0, 0]}\nbars: {crank: {joints: [O, A], length: 0.3}}\ndrives:\n"
MOTOR = Drive(name="crank", angle=0.5, speed=-math.pi)


def test_same_from_yaml_and_python():
    assert component(CRANK + "  crank: {angle: 0.5, speed: -pi}\n", "drives", "crank") == MOTOR


def test_units():
    motor = component(CRANK + "  crank: {angle: 180 deg, speed: 30 rpm}\n", "drives", "crank")
    # one rounding for the unit
    assert math.isclose(motor.angle, math.pi, rel_tol=2e-16)
    assert math.isclose(motor.speed, math.pi, rel_tol=4e-16)


def test_frozen_and_keyword_only():
    assert_frozen_and_keyword_only(MOTOR)


def test_terms():
    (term,) = MOTOR.terms()
    assert (term.body, term.start.value, term.speed.value) == ("crank", 0.5, -math.pi)
    assert (term.start.path, term.speed.path) == (
        ("drives", "crank", "angle"),
        ("drives", "crank", "speed"),
    )
    # a drive that happens to start at 0 or to stand still needs no kernel of its own
    assert not term.start.structural
    assert not term.speed.structural


def test_drives_turn_bars_and_plates():
    assert MOTOR.references().bodies == ((("drives", "crank"), "crank", ("bar", "plate")),)
    (problem,) = complaints(CRANK + "  crank2: {angle: 0, speed: 1}\n")
    assert problem == "line 4, column 3, drives.crank2: unknown bar 'crank2'; did you mean 'crank'?"


def test_both_numbers_must_be_given():
    (problem,) = complaints(CRANK + "  crank: {angle: 0}\n")
    assert problem.startswith("line 4, column 3, drives.crank: missing key 'speed'")
