"""Frames: what is fixed to what, and how fast bodies turn with each other."""

import numpy as np
import pytest
from linkage_models import system_of

from linkages.components.contributed.terms import Parameter
from linkages.kernel.differentiation import Evaluator
from linkages.kernel.scalars import Level

TEXT = """
joints: {O: [0, 0], C: [1, 0]}
bars:
  one: {joints: [O, A], length: 1}
  two: {points: {A: [0.1, 0.2], B: [1, 0.5]}}
  wheel: {joints: [C, P], length: 1}
  twin: {joints: [C, R], length: 1}
  post: {joints: [O, S], length: 1}
sliders:
  ram: {joint: X, on: two, through: [0.2, 0.3], angle: 40 deg, points: {Y: [0.1, -0.1]}}
  tail: {joint: Z, on: ram, through: Y, angle: 90 deg}
  block: {joint: W, through: O, angle: 180 deg}
welds: {A: {bars: [one, two], angle: 0.3}, O: {bars: [ground, post], angle: 0.2}}
gears:
  - {bars: [two, wheel], ratio: -2.5, angle: 0.1}
  - {bars: [wheel, twin], ratio: 1, angle: 0.7}
drives: {one: {angle: 0.4, speed: 1}, ram: {position: 0.3, speed: 0},
  tail: {position: 0.2, speed: 0}, block: {position: 0.5, speed: 0}}
"""
BARS = "".join(f"  link{j}: {{joints: [{j}, {j}2], length: 1}}\n" for j in "XZWY")
FREE = "free: {" + ", ".join(f"link{j}: {{angle: 0}}" for j in "XZWY") + "}\n"


@pytest.fixture(scope="module")
def of():
    return system_of(TEXT.replace("sliders:", BARS + "sliders:") + FREE)


@pytest.fixture
def frames(of):
    return of.model.positions.frames


def number(of, vector):
    """A vector as a complex number."""
    x, y = of.evaluate([vector.x, vector.y])[:, 0]
    return x + 1j * y


def test_what_turns_with_what(of, frames):
    """The body that is solved for, and the constant rotation against it (not of wheels)."""
    expected = {
        "one": ("one", 0.0),
        "two": ("one", 0.3),
        "ram": ("one", 0.3 + np.radians(40)),
        "tail": ("one", 0.3 + np.radians(130)),
        "wheel": ("wheel", 0.0),
        "twin": ("twin", 0.0),
        "post": (None, 0.2),
        "block": (None, np.pi),
    }
    for name, (master, turned) in expected.items():
        found, direction = frames.rotation(name)
        assert found == master, name
        assert number(of, direction) == pytest.approx(np.exp(1j * turned), abs=1e-15)


def test_angles_and_unit_vectors_agree(of):
    positions = of.model.positions
    angles = {
        "two": 0.7,
        "ram": 0.7 + np.radians(40),
        "tail": 0.7 + np.radians(130),
        "wheel": -2.5 * 0.7 + 0.1,
        "twin": -2.5 * 0.7 + 0.8,
        "post": 0.2,
        "block": np.pi,
    }
    for name, angle in angles.items():
        assert of.evaluate([positions.angle(name)])[0, 0] == pytest.approx(angle, abs=1e-14)
        unit = number(of, positions.unit(name))
        assert unit == pytest.approx(np.exp(1j * angle), abs=1e-15)


def test_vectors_within_bodies(of, frames):
    assert number(of, frames.fixed("two", "A", "B")) == pytest.approx(0.9 + 0.3j, abs=1e-16)
    assert number(of, frames.fixed("two", "A", "ram.axis")) == pytest.approx(0.1 + 0.1j, abs=1e-16)
    # on the slider itself its axis point moves; when it has not, it is at the pin
    assert number(of, frames.fixed("ram", "ram.axis", "Y")) == 0.1 - 0.1j
    positions = of.model.positions
    assert number(of, positions.in_frame("ram", "ram.axis", "Y")) == pytest.approx(0.4 - 0.1j)
    assert number(of, positions.in_frame("ram", "Y", "ram.axis")) == pytest.approx(-0.4 + 0.1j)


def test_places_of_a_slider_on_a_slider(of):
    """By complex numbers, from the ground outwards."""
    two = np.exp(0.7j)
    ram = two * np.exp(1j * np.radians(40))
    origin = np.exp(0.4j) + two * (0.2 + 0.3j - 0.1 - 0.2j)
    x = origin + 0.3 * ram
    y = x + (0.1 - 0.1j) * ram
    z = y + 0.2 * ram * 1j
    places = of.places()
    for joint, expected in (("ram.axis", origin), ("X", x), ("Y", y), ("tail.axis", y), ("Z", z)):
        assert complex(*places[joint]) == pytest.approx(expected, abs=1e-15)
    assert complex(*places["W"]) == pytest.approx(-0.5, abs=1e-16)


def test_a_way_along_the_displacement_has_a_sign(frames):
    assert frames.sliding("ram", "ram.axis", "X") == 1
    assert frames.sliding("ram", "Y", "ram.axis") == -1
    assert frames.sliding("ram", "X", "Y") == 0
    assert frames.sliding("two", "A", "ram.axis") == 0


def test_ratios(of, frames):
    def ratios(name):
        found = frames.ratios(name)
        return dict(zip(found, of.evaluate([*found.values()])[:, 0], strict=True))

    assert ratios("two") == ratios("ram") == ratios("tail") == {"one": 1.0}
    assert ratios("wheel") == ratios("twin") == {"one": -2.5}
    assert frames.ratios("block") == {}
    assert frames.ratios("post") == {}


PLANETARY = """
joints: {O: [0, 0], C2: [2, 0]}
bars:
  arm: {joints: [O, A], length: 1}
  sun: {joints: [O, B], length: 1}
  ring: {joints: [O, C], length: 1}
  shaft: {joints: [C2, D], length: 1}
gears: [{bars: [sun, ring], ratio: -0.4, carrier: arm}, {bars: [ring, shaft], ratio: 3}]
drives: {sun: {angle: 0, speed: 2}, arm: {angle: 0, speed: 3}}
"""


def test_ratios_of_a_planetary_gear():
    """Willis: ω_ring − ω_arm = −0.4 (ω_sun − ω_arm); the shaft turns with what the ring does."""
    of = system_of(PLANETARY)
    found = of.model.positions.frames.ratios("shaft")
    ratios = dict(zip(found, of.evaluate([*found.values()])[:, 0], strict=True))
    assert ratios == pytest.approx({"sun": -1.2, "arm": 4.2}, rel=1e-15)
    (speed,) = of.evaluate([of.model.velocities.turning("shaft")])[:, 0]
    assert speed == pytest.approx(2 * -1.2 + 3 * 4.2, rel=1e-15)


def test_turning_follows_the_ratios(of):
    velocities = of.model.velocities
    speeds = [velocities.turning(name) for name in ("two", "tail", "wheel", "twin", "post")]
    assert of.evaluate(speeds)[:, 0].tolist() == [1.0, 1.0, -2.5, -2.5, 0.0]


@pytest.mark.parametrize("quarters", [-2, -1, 0, 1, 2, 3, 5])
def test_right_angles_are_structure(of, frames, quarters):
    """They cost nothing: exact zeros and ones."""
    angle = Parameter(("x",), quarters * np.pi / 2)
    direction = frames.direction(angle)
    found = complex(direction.x.constant, direction.y.constant)
    assert found == 1j**quarters
    assert ("x",) not in of.model.inputs.parameters


def test_other_angles_are_parameters(of, frames):
    path, *others = of.model.inputs.parameters
    direction = frames.direction(Parameter(path, 0.4))
    assert direction.x.level == direction.y.level == Level.PARAMETERS
    x, y = Evaluator([direction.x, direction.y])(p=np.array([0.4, *map(float, range(len(others)))]))
    assert complex(x, y) == pytest.approx(np.exp(0.4j), abs=1e-16)
