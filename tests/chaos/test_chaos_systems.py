"""Own systems do what the protocol says."""

import math

import numpy as np
import pytest
from chaos_systems import henon, henon_heiles, logistic, lorenz, sprott_pendulum
from make.verdicts.own_systems import Map, Ode

from linkages.errors import ComputationError


def oscillator(**more):
    return Ode(lambda _, y: (y[1], -y[0]), lambda *_: ((0, 1), (-1, 0)), [1.0, 0.0], **more)


def test_linear_tangents_against_the_closed_form():
    """For x'' = -x both are a rotation; 1e-9 is the tolerance of a step, ten steps add up."""
    system = oscillator()
    system.tangents = np.eye(2)
    for _ in range(7):
        system.advance(0.3)
    c, s = math.cos(2.1), math.sin(2.1)
    np.testing.assert_allclose(system.state, [c, -s], atol=1e-8)
    np.testing.assert_allclose(system.tangents, [[c, s], [-s, c]], atol=1e-8)
    assert system.time == pytest.approx(2.1, abs=1e-12)


@pytest.mark.parametrize(
    "system", [lorenz(1e-10), sprott_pendulum(1e-10), henon_heiles(0.1, 0.1), henon()]
)
def test_tangents_against_differences_of_motions(system):
    """Central differences of 1e-5 err by 1e-10 times third derivatives, and by 1e-10/1e-5."""
    start, time = system.state, system.time
    system.tangents = np.eye(len(start))
    system.advance(1)
    tangents = system.tangents
    columns = []
    for direction in np.eye(len(start)):
        ends = []
        for sign in (1, -1):
            system.restart(start + sign * 1e-5 * direction, np.empty((len(start), 0)), time)
            system.advance(1)
            ends.append(system.state)
        columns.append((ends[0] - ends[1]) / 2e-5)
    np.testing.assert_allclose(tangents, np.transpose(columns), rtol=1e-4, atol=1e-4)


def test_advance_commutes_with_rescaling_tangents():
    ends = []
    for scale in (1.0, 1e-12, 1e12):
        system = lorenz(1e-9)
        system.tangents = scale * np.eye(3)
        system.advance(1.0)
        ends.append(system.tangents / scale)
    np.testing.assert_allclose(ends[1:], [ends[0]] * 2, rtol=1e-9)


def test_there_and_back():
    system = henon_heiles(0.1, 0.1, rtol=1e-11)
    start = system.state
    system.tangents = np.eye(4)
    system.advance(5.0)
    system.advance(-5.0)
    np.testing.assert_allclose(system.state, start, atol=1e-9)
    np.testing.assert_allclose(system.tangents, np.eye(4), atol=1e-8)


def test_angles_stay_within_one_turn():
    turning = Ode(
        lambda _, y: (2.0, y[0] * 0 + 1), lambda *_: np.zeros((2, 2)), [3.0, 3.0], angles=[1, 0]
    )
    turning.advance(10.0)
    assert turning.state == pytest.approx([23.0 - 8 * math.pi, 13.0], abs=1e-12)
    circle = Map(lambda x: x + 1.0, lambda _: [[1.0]], [0.0], angles=[True])
    circle.advance(4)
    assert circle.state == pytest.approx([4.0 - 2 * math.pi])


def test_restart_keeps_what_is_not_given():
    system = oscillator(time=3.0)
    system.restart(tangents=np.eye(2)[:, :1])
    system.restart(state=[0.0, 1.0])
    assert system.time == 3.0
    assert system.tangents.shape == (2, 1)
    system.restart(time=0.0)
    assert system.state.tolist() == [0.0, 1.0]


def test_copies_are_copies():
    system = oscillator()
    system.tangents = np.eye(2)
    system.state[0], system.tangents[0, 0] = 9.0, 9.0
    assert system.state[0] == 1.0
    assert system.tangents[0, 0] == 1.0


def test_failures_say_when():
    explosive = Ode(lambda _, y: y**2, lambda _, y: np.diag(2 * y), [1.0])
    with pytest.raises(ComputationError, match="cannot be continued at time") as caught:
        explosive.advance(2.0)
    assert caught.value.time == pytest.approx(1.0, abs=1e-3)
    with np.errstate(over="ignore", invalid="ignore"), pytest.raises(ComputationError, match="div"):
        logistic(5.0).advance(100)


def test_wrong_arguments():
    with pytest.raises(ValueError, match="whole number of steps"):
        henon().advance(0.5)
    with pytest.raises(ValueError, match=r"shape \(2, k\)"):
        henon().tangents = np.eye(3)
    with pytest.raises(ValueError, match="2 finite numbers"):
        henon().restart(state=[1.0])
    with pytest.raises(ValueError, match="angles must be"):
        oscillator(angles=[True])
