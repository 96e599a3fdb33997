"""Numbers that are allowed but hardly meant are noted."""

from pathlib import Path

import pytest

import linkages
from linkages.solution.remarks import doubts

ROOT = Path(__file__).parents[2]
DATA = ROOT / "tests/data/linkages"


def test_a_clearance_in_metres_instead_of_millimetres():
    (note,) = doubts(linkages.load("ninebar", set={"clearances.r1.size": 0.2}))
    assert note.startswith("clearance r1 of 0.2 m is large beside link3 of 0.96")
    assert note.endswith("numbers without a unit are metres")


def test_simulations_tell():
    mechanism = linkages.load("ninebar", set={"clearances.r1.size": 0.1})
    solution = linkages.simulate(mechanism, end=0.01, samples=2)
    assert list(solution.notes) == doubts(mechanism) != []


def doubted(name, **values):
    return doubts(linkages.load(name, set={k.replace("__", "."): v for k, v in values.items()}))


FILES = sorted([*(ROOT / "mechanisms").glob("*.yaml"), *DATA.glob("*.yaml")])


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_nothing_is_doubted_in_any_shipped_file_or_one_of_other_tests(file):
    assert doubts(linkages.load(file)) == []


ANGLE = "; did you mean {} deg? Numbers without a unit are radians"


@pytest.mark.parametrize(
    ("name", "path"),
    [
        ("slider-crank", "sliders.piston.angle"),
        ("four-bar", "drives.crank.angle"),
        ("pendulum", "free.rod.angle"),
        ("ninebar", "clearances.r1.angle"),
    ],
)
def test_degrees_without_their_unit(name, path):
    (note,) = doubts(linkages.load(name, set={path: "-90"}))
    assert note == f"{path} is -90 rad{ANGLE.format(-90)}"
    for meant in ("-90 deg", "-pi/2", "-6.28", "-5*pi", -1.5):
        assert doubts(linkages.load(name, set={path: meant})) == []


def test_revolutions_per_minute_without_their_unit():
    (note,) = doubted("four-bar", drives__crank__speed="1000")
    assert note.startswith("drives.crank.speed is 1000 rad/s (9549 rpm); did you mean 1000 rpm?")
    for speed in ("1000 rpm", "314.16", "250", "104.7"):  # no round numbers, or slow
        assert doubted("four-bar", drives__crank__speed=speed) == []
    assert doubted("four-bar", drives__crank__speed="-4711.5") != []


def test_millimetres_without_their_unit():
    (note,) = doubted("slider-crank", bars__rod__length="140")
    beside = "where the median length is 0.04 m; did you mean 140 mm? Numbers without a unit are"
    assert note == f"bars.rod.length is 140 m, {beside} metres"
    assert doubted("slider-crank", bars__rod__length="140 m") == []
    plate = "{points: {A: [0, 0], B: [40 mm, 0], P: [70, 12]}}"
    (note,) = doubted("four-bar", bars__coupler=plate)
    assert note.startswith("bars.coupler.points.P[0] is 70 m, where the median length is ")
    (note,) = doubted("four-bar", bars__crank__length="1e-4")
    assert note.endswith("; numbers without a unit are metres")


def test_a_stroke_longer_than_the_machine():
    """A barrel and its rod that is pushed out by 1.4 m, or so it was meant."""
    text = (
        "joints: {O: [0, 0], D: [0.5, 0]}\nbars:\n"
        "  barrel: {joints: [O, E], length: 0.3}\n  boom: {joints: [D, T], length: 0.4, mass: 1}\n"
        "sliders: {rod: {joint: T, on: barrel}}\nassembly: {T: [0.5, 0.4]}\n"
        "drives: {rod: {law: {rise: cycloidal, from: 640 mm, to: 700, duration: 1}}}\n"
    )
    (note,) = doubts(linkages.loads(text))
    assert note == (
        "drives.rod.law.to is 700 m, longer than the whole machine (1.2 m); did you mean 700 mm? "
        "Numbers without a unit are metres"
    )
    assert doubts(linkages.loads(text.replace("700,", "700 mm,"))) == []


def test_who_writes_python_knows_that_it_is_si():
    spring = linkages.load("pendulum").with_state({"rod": (37.7, 0.0)})  # after six turns
    assert doubts(spring) == []


def test_a_joint_that_differs_by_capitals():
    """The mobility may still be right: the coupler hangs from the crank alone."""
    text = (
        "joints: {O: [0, 0], D: [1, 0]}\nbars:\n  a: {joints: [O, A], length: 1, mass: 1}\n"
        "  b: {joints: [A, B], length: 1, mass: 1}\n  c: {joints: [D, b], length: 1, mass: 1}\n"
        "free:\n" + "".join(f"  {name}: {{angle: 1, speed: 0}}\n" for name in "abc")
    )
    mechanism = linkages.loads(text)
    assert doubts(mechanism) == ["joint b is on one body only, c; did you mean 'B'?"]
