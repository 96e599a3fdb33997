"""Redundant constraints: what holds by itself is solved by least squares, the rest is refused."""

import re

import numpy as np
import pytest
from kernel_motion import call, carried_along, difference
from linkage_models import refusal, system_of, values

import linkages
from linkages.components.mechanisms.definition import from_document
from linkages.kernel.code.program import bind_kernel, write_program
from linkages.reading.document import parse

TWO_COUPLERS = """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [1, 0.2]}
bars:
  crank: {points: {O: [0, 0], A: [0.4, 0], P: [0.3, 0.1]}, mass: 1, center: [0.2, 0], inertia: 0.1}
  rocker: {points: {C: [0, 0], B: [0.4, 0], Q: [0.3, 0.1]}, mass: 1, center: [0.2, 0], inertia: 0.1}
  coupler: {points: {A: [0, 0], B: [1, 0.2]}, mass: 2, center: [0.5, 0.1], inertia: 0.3}
  second: {points: {P: [0, 0], Q: [1, 0.2]}, mass: 0.5, center: [0.5, 0.1], inertia: 0.1}
drives: {crank: {angle: 0.5, speed: 3}}
assembly: {B: [1.4, 0.4], Q: [1.3, 0.4]}
"""
THREE_CRANKS = """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [1, 0.2], D: [0.4, -0.3]}
bars:
  crank: {joints: [O, A], length: 0.4, mass: 1}
  second: {joints: [C, B], length: 0.4, mass: 1}
  third: {joints: [D, E], length: 0.4, mass: 1}
  coupler: {points: {A: [0, 0], B: [1, 0.2], E: [0.4, -0.3]}, mass: 2, center: [0.5, 0],
    inertia: 0.3}
drives: {crank: {angle: 0.5, speed: 3}}
assembly: {B: [1.4, 0.4], E: [0.75, -0.1]}
"""
PARALLELOGRAMS = {"two couplers": TWO_COUPLERS, "three cranks": THREE_CRANKS}
MODEL = pytest.mark.parametrize("text", PARALLELOGRAMS.values(), ids=PARALLELOGRAMS)
TURN = np.linspace(0, 0.85, 91)
"""Three cranks turn from 0.5 to 3.05 rad; crank and coupler are in line at 0.2 and 3.34 rad."""


def free(text):
    return text.replace("drives: {crank: {angle: 0.5", "free: {crank: {angle: 0.5")


@MODEL
def test_parallelograms_close(text):
    of = system_of(text)
    assert of.topology.mobility == 0  # by Grübler's formula; in truth it is 1
    assert of.topology.redundant
    assert sum(block.surplus for block in of.topology.solved_blocks) == 1
    states = carried_along(of, TURN)
    residual = values(of, "closure_residual", TURN, states)
    assert np.abs(residual).max() < 1e-13
    angles = values(of, "bar_angle", TURN, states)
    cranks = [n for n in ("crank", "rocker", "second", "third") if n in of.mechanism.bodies]
    order = [name for name in of.mechanism.bodies if of.mechanism.bodies[name].rotates]
    for name in order:
        turned = angles[order.index(name)]
        moves = name in cranks and (name, text) != ("second", TWO_COUPLERS)
        expected = 0.5 + 3 * TURN if moves else 0 * TURN
        # least squares squares the condition number, about 10
        assert np.exp(1j * turned) == pytest.approx(np.exp(1j * expected), abs=1e-12)


@MODEL
def test_velocities_and_accelerations(text):
    """Cranks turn alike; couplers move on circles."""
    of = system_of(text)
    states = carried_along(of, TURN)
    names = ("bar_speed", "bar_acceleration")
    speed, acceleration = (values(of, name, TURN, states) for name in names)
    assert np.abs(acceleration).max() < 1e-10
    rounded = np.round(speed, 10)
    assert {*rounded.ravel()} <= {0.0, -0.0, 3.0}
    joints = of.topology.joints
    places = values(of, "joint_position", TURN, states).reshape(len(joints), 2, -1)
    second = values(of, "joint_acceleration", TURN, states).reshape(len(joints), 2, -1)
    b, foot = joints.index("B"), np.array([[1.0], [0.2]])
    assert second[b] == pytest.approx(-9 * (places[b] - foot), abs=1e-10)


@MODEL
def test_a_free_parallelogram_is_a_pendulum(text):
    """All masses of couplers on circles of the same radius: (ΣJ + m r²) θ̈ = torque of gravity."""
    of = system_of(free(text).replace("speed: 3", "speed: 1.5"))
    accelerations = of.model.integrated_accelerations(of.model.changes)
    found = of.evaluate(accelerations)[:, 0]
    if text == THREE_CRANKS:
        crank, coupler, arm = 3 * 0.4**2 / 3, 2.0 * 0.4**2, 3 * 0.2 + 2 * 0.4
        torque = -9.81 * arm * np.cos(0.5)
    else:
        crank, coupler = 2 * (0.1 + 0.2**2), 2 * 0.4**2 + 0.5 * (0.3**2 + 0.1**2)
        height = 2 * 0.2 * np.cos(0.5) + 2 * 0.4 * np.cos(0.5)
        height += 0.5 * (0.3 * np.cos(0.5) - 0.1 * np.sin(0.5))
        torque = -9.81 * height
    assert found[0] == pytest.approx(torque / (crank + coupler), rel=1e-12)
    program = write_program(of.model, accelerations)
    kernel = bind_kernel(program, of.parameters)
    clock, rates, out = call(kernel, 0.0, of.state, len(found))
    assert (clock, rates) == (0, 0)
    assert out == pytest.approx(found, rel=1e-11, abs=1e-10)


@MODEL
def test_margins_change_at_their_rates(text):
    of = system_of(text)
    rate = of.evaluate(of.model.margin_rates, 0.1)[:, 0]
    slope = difference(lambda h: of.evaluate(of.model.margins, 0.1 + h)[:, 0], 2e-3)
    scale = of.evaluate(of.model.margin_scales)[:, 0]
    assert rate == pytest.approx(slope, abs=1e-10 * scale.max())


WRONG = [
    (TWO_COUPLERS, "P: [0, 0], Q: [1, 0.2]", "P: [0, 0], Q: [1.05, 0.2]"),
    (TWO_COUPLERS, "Q: [0.3, 0.1]", "Q: [0.31, 0.1]"),
    (THREE_CRANKS, "D: [0.4, -0.3]", "D: [0.4, -0.2]"),
    (THREE_CRANKS, "third: {joints: [D, E], length: 0.4", "third: {joints: [D, E], length: 0.401"),
]


@pytest.mark.parametrize(("text", "old", "new"), WRONG)
def test_wrong_dimensions(text, old, new):
    """It fits nowhere, or in single positions only, where it would be stuck."""
    changed = text.replace(old, new)
    assert changed != text
    message = refusal(changed)
    found = re.search(r"constraints at (\w) contradict each other", message)
    found = found or re.search(r"coordinates at (\w): they would not let crank move", message)
    assert found is not None, message
    assert found[1] in ("A", "B", "P", "Q", "E")


def test_dimensions_that_fit_in_one_position():
    """A second coupler of the length that it needs at the start holds the crank."""
    of = system_of(TWO_COUPLERS.split("  second")[0] + "drives:" + TWO_COUPLERS.split("drives:")[1]
        .replace(", Q: [1.3, 0.4]", "")).places()  # fmt: skip
    p = of["O"] + 0.3 * np.array([np.cos(0.5), np.sin(0.5)])
    p += 0.1 * np.array([-np.sin(0.5), np.cos(0.5)])
    q = of["C"] + 0.25 * np.array([np.cos(0.5), np.sin(0.5)])
    x, y = q - p
    text = TWO_COUPLERS.replace("Q: [0.3, 0.1]", "Q: [0.25, 0]")
    text = text.replace("P: [0, 0], Q: [1, 0.2]", f"P: [0, 0], Q: [{float(x)!r}, {float(y)!r}]")
    text = text.replace("Q: [1.3, 0.4]", f"Q: [{float(q[0])}, {float(q[1])}]")
    message = refusal(text)
    assert "they would not let crank move" in message
    assert "dimensions with which the redundant constraints hold in all positions" in message


def test_a_frame_between_two_ground_joints():
    """A bar that stands still carries a crank; without a drive of its own it has one position."""
    frame = "joints: {O: [0, 0], C: [1, 0]}\nbars:\n  frame: {points: {O: [0, 0], C: [LENGTH, 0], "
    frame += "P: [0.5, 0.5]}}\n  crank: {joints: [P, Q], length: 0.2}\n"
    frame += "drives: {crank: {angle: 0, speed: 1}}\n"
    of = system_of(frame.replace("LENGTH", "1"))
    assert of.places()["Q"] == pytest.approx([0.7, 0.5], abs=1e-15)
    assert values(of, "bar_speed", 0.3)[:, 0] == pytest.approx([0, 1], abs=1e-15)
    message = refusal(frame.replace("LENGTH", "1.1"))
    assert "the constraints at C contradict each other" in message


def test_a_welded_frame_between_two_ground_joints():
    """Nothing is left to be solved: its second joint must be where the ground has it."""
    text = """
joints: {O: [0, 0], C: [1, 0]}
bars:
  frame: {points: {O: [0, 0], C: [LENGTH, 0], P: [0.5, 0.5]}}
  crank: {joints: [P, Q], length: 0.2}
welds: {O: {bars: [ground, frame], angle: 0}}
drives: {crank: {angle: 0, speed: 1}}
"""
    of = system_of(text.replace("LENGTH", "1"))
    assert of.places()["Q"] == pytest.approx([0.7, 0.5], abs=1e-15)
    message = refusal(text.replace("LENGTH", "1.1"))
    assert "nothing is left to be moved so that frame meets C" in message
    assert "more constraints than coordinates at C" in message


def test_two_bars_that_are_welded_twice_turn_as_one():
    """A driven triangle of three bars, two of them welded: its third corner closes by itself."""
    text = """
joints: {O: [0, 0]}
bars:
  one: {joints: [O, A], length: 3}
  two: {joints: [A, B], length: 4}
  three: {joints: [O, B], length: FIVE}
welds:
  A: {bars: [one, two], angle: 90 deg}
  O: {bars: [one, three], angle: ANGLE}
drives: {one: {angle: 0.3, speed: 2}}
"""
    angle = float(np.arctan2(4, 3))
    of = system_of(text.replace("FIVE", "5").replace("ANGLE", repr(angle)))
    place = 5 * np.exp(1j * (0.3 + angle))
    assert of.places()["B"] == pytest.approx([place.real, place.imag], abs=1e-14)
    message = refusal(text.replace("FIVE", "5.1").replace("ANGLE", repr(angle)))
    assert "contradict each other" in message


PUSHED = """\
joints: {O: [0, 0], C: [0.4, 0], D: [0.7, 0.1], H: [0.9, 0]}
bars:
  crank: {joints: [O, A], length: 0.08}
  rod: {joints: [A, P], length: 0.55}
  one: {joints: [C, F], length: 0.3}
  two: {joints: [D, G], length: 0.3}
THREE  plate: {points: {F: [0, 0], G: [0.3, 0.1], P: [-0.1, 0.2], K: [0.5, 0]}}
drives: {crank: {angle: 0.5, speed: 3}}
assembly: {F: [0.5, 0.28], G: [0.8, 0.38], P: [0.4, 0.48]}
MORE"""


@pytest.mark.slow_except("a gear*")
@pytest.mark.parametrize(
    ("three", "more"),
    [
        ("  three: {joints: [H, K], length: 0.3}\n", ""),
        ("", "gears: [{bars: [one, two], ratio: 1}]\n"),
    ],
    ids=["a third leg", "a gear between equal legs"],
)
def test_redundancy_that_shows_in_numbers_only(three, more):
    """The structure alone takes plate and legs for rigid, and the rod for redundant."""
    text = PUSHED.replace("THREE", three).replace("MORE", more)
    data = linkages.simulate(from_document(parse(text, "pushed.yaml")), end=2.0).data
    one, two, plate = (data.bar_angle.sel(bar=name) for name in ("one", "two", "plate"))
    assert np.abs(one - two).max() < 1e-13
    assert np.abs(plate).max() < 1e-13
    assert float(data.closure_residual.max()) < 1e-13
