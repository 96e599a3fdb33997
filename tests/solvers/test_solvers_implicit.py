"""Implicit methods: Gauss for long motions, Radau for stiff ones."""

import dataclasses
import math

import numpy as np
import pytest
from solver_kernels import (
    damped_rates,
    damped_slopes,
    flow,
    no_clock,
    pendulum,
    rotation,
    swing,
    uniform_rates,
)

from linkages.solvers import Event, Kernel, Outcome, integrate
from linkages.solvers.tableau import Collocation


@pytest.mark.parametrize("stages", [1, 2, 3, 4, 5])
def test_collocation_has_twice_the_order_of_its_stages(stages):
    method = Collocation(stages=stages)
    assert method.A.sum(axis=1) == pytest.approx(method.c, abs=1e-15)
    assert method.b.sum() == pytest.approx(1.0, abs=1e-15)


def test_starting_values_continue_a_polynomial():
    method = Collocation(stages=3)
    nodes = np.append(method.c, 1.0)
    assert method.ahead @ nodes**3 == pytest.approx((1.0 + method.c) ** 3, abs=1e-12)


def energy(state):
    return state[..., 1] ** 2 / 2 - np.cos(state[..., 0])


def test_energy_does_not_drift():
    times = np.linspace(0, 1e4, 101)
    result = integrate(pendulum(), [2.0, 0.0], times, method="gauss8", step=0.25)
    errors = energy(result.state) - energy(result.state[0])
    # The error of a symmetric method swings with the motion and stays; here 40 000 steps.
    assert np.abs(errors).max() < 1e-9
    assert abs(np.polyfit(times, errors, 1)[0]) * 1e4 < 1e-10


def test_round_off_grows_like_a_random_walk():
    result = integrate(pendulum(), [2.0, 0.0], [0.0, 2000.0], method="gauss8", step=0.05)
    # Sixty times less than ε for each of 40 000 steps.
    assert abs(energy(result.final_state) - energy(np.array([2.0, 0.0]))) < 2e-13


@pytest.mark.parametrize("acceleration", [0.0, 0.1])
def test_sums_of_many_steps_are_right_to_the_last_digit(acceleration):
    """2¹⁷ sums, each of which rounds by up to half a unit in the last place.

    Plain sums leave 2.5e-12 of the place where the speed is constant, and as much of the speed
    where the acceleration is.
    """
    end, steps = 64.0, 2**17
    uniform = flow(uniform_rates, [acceleration])
    given = {"method": "gauss8", "step": end / steps}
    result = integrate(uniform, [1.0, 0.1], [0.0, end], **given)
    assert result.steps == steps
    expected = [1.0 + 0.1 * end + acceleration * end**2 / 2, 0.1 + acceleration * end]
    # weights of the method add up to 1 but for some units in the last place
    assert result.final_state == pytest.approx(expected, rel=1e-15, abs=0)


def test_samples_within_steps_have_the_order_of_the_steps():
    times = np.linspace(0, 5, 333)
    steps, errors = np.array([1 / 3, 1 / 4, 1 / 5]), []
    for step in steps:
        result = integrate(pendulum(), [2.0, 0.0], times, method="gauss8", step=step)
        errors.append(np.abs(result.state[:, 0] - swing(2.0, times)[0]).max())
    slope, _ = np.polyfit(np.log(steps), np.log(errors), 1)
    assert slope > 7.5


@pytest.mark.parametrize("step", [5.0, 100.0])
def test_step_beyond_convergence_is_no_motion(step):
    result = integrate(pendulum(), [2.0, 0.0], [0.0, 1000.0], method="gauss8", step=step)
    assert result.outcome is Outcome.NOT_CONVERGED
    assert "smaller step" in str(result.outcome)
    assert result.stop_time < 1000.0


def damped(rate, linearise):
    """A stiff flow whose exact derivatives count their calls in the second parameter."""
    parameters = np.array([rate, 0.0])
    linear = Kernel(
        clock=no_clock.address, rates=damped_slopes.address, parameters=parameters, timed_size=0
    )
    plain = flow(damped_rates, [rate], rotates=[True])
    return dataclasses.replace(plain, linearise=lambda: linear) if linearise else plain, parameters


@pytest.mark.parametrize("linearise", [False, True])
def test_stiff_motion_takes_few_steps(linearise):
    rate = 1e8
    stiff, parameters = damped(rate, linearise)
    times = np.linspace(0, 5, 11)
    result = integrate(stiff, [2.0, 0.0], times, method="radau", rtol=1e-8)
    assert result.outcome is Outcome.DONE
    assert result.steps < 500  # an explicit method is bound to some 1e8
    assert (parameters[1] > 0) == linearise
    # q' = -sin q up to 1/rate.
    exact = 2 * np.arctan(math.tan(1.0) * np.exp(-times))
    assert result.state[:, 0] == pytest.approx(exact, abs=1e-6)


def test_error_estimate_is_that_of_hairer_and_wanner():
    """Solving ODEs II, IV.8: γ = 3 + 3^(2/3) - 3^(1/3), weights (-13 ∓ 7√6)/3 and -1/3."""
    root = math.sqrt(6.0)
    expected = [(-13 - 7 * root) / 3, (-13 + 7 * root) / 3, -1 / 3]
    gamma = 3 + 3 ** (2 / 3) - 3 ** (1 / 3)
    assert Collocation(stages=3, ends=True).error == pytest.approx([*expected, gamma], rel=1e-12)


@pytest.mark.parametrize("stages", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("ends", [False, True])
def test_polynomials_of_stages_integrate_powers(stages, ends):
    method, theta = Collocation(stages=stages, ends=ends), 0.3
    powers = theta ** np.arange(1, stages + 1)
    for power in range(stages):
        once, twice = method.c**power @ (method.integrals @ powers).T
        assert once == pytest.approx(theta ** (power + 1) / (power + 1), abs=1e-12)
        assert theta * twice == pytest.approx(
            theta ** (power + 2) / ((power + 1) * (power + 2)), abs=1e-12
        )


def test_equal_steps_of_radau_have_its_order():
    steps, errors = np.array([1 / 10, 1 / 20, 1 / 40]), []
    for step in steps:
        result = integrate(pendulum(), [2.0, 0.0], [0.0, 5.0], method="radau", step=step)
        assert result.steps == round(5 / step)
        errors.append(abs(result.final_state[0] - swing(2.0, 5.0)[0]))
    slope, _ = np.polyfit(np.log(steps), np.log(errors), 1)
    assert slope == pytest.approx(5.0, abs=0.3)


def test_stiff_events_are_located_to_round_off():
    """A level of a motion whose right-hand side is steeper than the steps are short."""
    stiff, _ = damped(1e8, True)
    event = Event(weights=[1, 0], level=1.0)
    result = integrate(stiff, [2.0, 0.0], [0.0, 5.0], method="radau", rtol=1e-8, events=[event])
    (crossing,) = result.crossings
    assert crossing.count == 1
    assert crossing.state[0, 0] == pytest.approx(1.0, abs=1e-14)
    assert crossing.time[0] == pytest.approx(math.log(math.tan(1.0) / math.tan(0.5)), abs=1e-6)


@pytest.mark.slow_except("1e-06")
@pytest.mark.parametrize("tolerance", [1e-6, 1e-7, 1e-8])
def test_stiff_method_predicts_across_a_turn(tolerance):
    """Where an angle is wrapped the next step starts from no prediction, not from one 2π away.

    Newton's iteration ends within its tolerance of where it started: from 2π away the motion would
    err twenty times as much as one whose angle is not wrapped.
    """
    errors = [
        abs(
            integrate(
                dataclasses.replace(pendulum(), rotates=np.array([rotates])),
                [0.0, 3.0],
                [0.0, 20.0],
                method="radau",
                rtol=1e-13,
                atol=tolerance,
            ).unwrapped[-1, 0]
            - rotation(3.0, 20.0)
        )
        for rotates in (True, False)
    ]
    assert errors[0] < 3 * errors[1]
