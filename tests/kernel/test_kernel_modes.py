"""Assembly modes: how many there are, that they close, and which of them hints choose."""

import numpy as np
import pytest
from kernel_motion import places_at
from linkage_models import refusal, system, system_of

from linkages.kernel.assembly_branches import Assembly, assembled
from linkages.kernel.differentiation import Evaluator
from linkages.kernel.outputs import VARIABLES

FOUR_BAR = """
joints: {O: [0, 0], C: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.3}
  coupler: {joints: [A, B], length: 0.9}
  rocker: {joints: [C, B], length: 0.7}
drives: {crank: {angle: 1, speed: 1}}
"""
# C. Innocenti & V. Parenti-Castelli (1992): feet (0, 0), (15.91, 0), (0, 10), a plate of sides
# 17.04, 20.84 and 16.54 on legs of 14.98, 15.38 and 12 has six real assembly modes.
SIX = """
joints: {O: [-0.05, 0], C: [0.1591, 0], D: [0, 0.1]}
bars:
  crank: {joints: [O, A], length: 0.05}
  leg1: {joints: [A, E], length: 0.1498}
  leg2: {joints: [C, F], length: 0.1538}
  leg3: {joints: [D, G], length: 0.12}
  plate: {points: {E: [0, 0], F: [0.1704, 0], G: [0.132364, 0.160967]}}
drives: {crank: {angle: 0, speed: 1}}
"""


def closure(of, mode):
    """Largest residual of the closure equations in an assembly mode."""
    nodes = VARIABLES["closure_residual"].evaluated(of.model)
    state = of.state.copy()
    for name, value in mode.values.items():
        state[of.topology.coordinates.index(name)] = value
    parameters = assembled(of.model.inputs, of.numbers, mode)
    values = Evaluator(nodes)(t=np.array([of.time]), y=state, p=parameters)
    return max((abs(float(np.squeeze(value))) for value in values), default=0.0)


def test_a_four_bar_has_two():
    of = system_of(FOUR_BAR + "assembly: {B: left}")
    left, right = of.modes()
    assert (left.sides, right.sides) == ({0: 1}, {0: -1})
    assert of.in_mode(left)["B"] == pytest.approx(of.places()["B"], abs=0)
    mirrored = system_of(FOUR_BAR + "assembly: {B: right}").places()["B"]
    assert of.in_mode(right)["B"] == pytest.approx(mirrored, abs=0)


@pytest.mark.parametrize(
    ("name", "count"),
    [("pendulum", 1), ("trammel", 1), ("slidercrank", 2), ("fivebar", 2), ("ninebar", 8)],
)
def test_two_for_every_dyad(name, count):
    of = system(name)
    modes = of.modes()
    assert len(modes) == count
    assert len({tuple(mode.sides.items()) for mode in modes}) == count
    assert all(closure(of, mode) < 1e-14 for mode in modes)


def test_modes_that_cannot_be_reached_are_missing():
    """The second dyad of a six-bar can be assembled on one side of the first one only."""
    text = """
joints: {O: [0, 0], C: [1, 0], D: [0.5, 1]}
bars:
  crank: {joints: [O, A], length: 0.3}
  coupler: {joints: [A, B], length: 0.9}
  rocker: {joints: [C, B], length: 0.7}
  tie: {joints: [B, G], length: 0.5}
  arm: {joints: [D, G], length: 0.4}
drives: {crank: {angle: 1, speed: 1}}
assembly: {B: left, G: left}
"""
    of = system_of(text)
    distances = [np.linalg.norm(of.in_mode(m)["B"] - [0.5, 1]) for m in of.modes()]
    assert [m.sides for m in of.modes()] == [{0: 1, 1: 1}, {0: 1, 1: -1}]
    assert max(distances) <= 0.9 < np.linalg.norm([0.5680 - 0.5, -0.5508 - 1])


def test_the_famous_plate_on_three_legs_has_six():
    of = system_of(SIX + "assembly: {E: [0.05, 0.14], F: [0.21, 0.14], G: [-0.1, 0.1]}")
    modes = of.modes()
    assert len(modes) == 6
    assert all(closure(of, mode) < 1e-14 for mode in modes)  # lengths of 0.2 m
    angles = np.array([mode.values["plate"] for mode in modes])
    apart = np.abs(np.exp(1j * angles)[:, None] - np.exp(1j * angles)) + np.eye(6)
    assert apart.min() > 0.1
    assert of.modes() == modes  # and in the same order


@pytest.mark.slow_except("0")
@pytest.mark.parametrize("wanted", range(6))
def test_hints_choose_the_nearest(wanted):
    """Hints a little off the places of one mode, with and without all joints."""
    start = system_of(SIX + "assembly: {E: [0.05, 0.14], F: [0.21, 0.14], G: [-0.1, 0.1]}")
    mode = start.modes()[wanted]
    places = start.in_mode(mode)
    for joints in ("EFG", "F"):
        hints = ", ".join(
            f"{j}: [{places[j][0] + 0.004:.6f}, {places[j][1] - 0.003:.6f}]" for j in joints
        )
        of = system_of(SIX + f"assembly: {{{hints}}}")
        assert of.assembly.values == pytest.approx(mode.values, abs=1e-9)
        assert places_at(of, 0.0)["G"] == pytest.approx(places["G"], abs=1e-12)
        assert of.assembly.assumed == ()


def test_without_hints_all_places_are_listed():
    message = refusal(SIX)
    assert "can be assembled in 6 ways" in message
    assert message.count("[0.") + message.count("[-0.") >= 6


def test_all_modes_start_where_a_motion_can():
    """Whatever mode is chosen, its settled coordinates are those of the mode."""
    of = system_of(SIX + "assembly: {E: [0.05, 0.14], F: [0.21, 0.14], G: [-0.1, 0.1]}")
    for name, value in of.assembly.values.items():
        index = of.topology.coordinates.index(name)
        assert of.state[index] == pytest.approx(value, abs=1e-6)
    found = of.evaluate(of.model.settled)[:, 0]
    assert found == pytest.approx(of.state, abs=1e-14)


def test_modes_times_modes():
    """A group of two modes and a dyad behind it make four."""
    text = SIX.replace("0.1498", "0.2").replace(
        "drives:",
        "  tie: {joints: [E, X], length: 0.5}\n  arm: {joints: [D, X], length: 0.5}\ndrives:",
    )
    message_free = system_of(SIX + "assembly: {G: [-0.1, 0.1]}")
    of = system_of(text + "assembly: {X: left, E: [0.1, 0.17], F: [0.2, 0.1], G: [0.1, 0.1]}")
    group = {tuple(mode.values.values()) for mode in of.modes()}
    assert len(of.modes()) == 2 * len(group)
    assert len(message_free.modes()) == 6


def test_choices_add_up():
    of = system("ninebar")
    one, two, _ = of.topology.solved_blocks
    assembly = Assembly().with_choice(one, 1).with_choice(two, -1)
    assert assembly.sides == {0: 1, 1: -1}
    assert assembly.values == {}


def test_parameters_of_an_assembly():
    """The sides are the only parameters that differ between modes of dyads."""
    of = system("ninebar")
    paths = list(of.model.inputs.parameters)
    one, other = of.modes()[0], of.modes()[-1]
    first, second = (
        assembled(of.model.inputs, of.numbers, one),
        assembled(of.model.inputs, of.numbers, other),
    )
    changed = {paths[i] for i in np.flatnonzero(first != second)}
    assert changed == {("side", 0), ("side", 1), ("side", 2)}
    assert np.array_equal(np.abs(first), np.abs(second))
