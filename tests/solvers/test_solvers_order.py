"""Order, tolerance and cost of each method."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from solver_kernels import (
    ORBIT,
    PERIOD,
    arenstorf,
    decay_rates,
    driven,
    driven_motion,
    flow,
    harmonic,
    logging_clock,
    pendulum,
    swing,
)

from linkages.solvers import METHODS, Outcome, integrate

# Chosen so that the smallest error stays two digits above round-off.
STEPS = {
    "rk4": [1 / 40, 1 / 60, 1 / 80, 1 / 120],
    "tsit5": [1 / 20, 1 / 28, 1 / 40, 1 / 56],
    "dop853": [1 / 5, 1 / 6, 1 / 8, 1 / 10],
    "vern9": [1 / 2, 1 / 3, 1 / 4, 1 / 5],
    "gauss8": [1 / 4, 1 / 6, 1 / 8, 1 / 10],
}
# On pendulums and stiff springs the second term of the error of tsit5 and vern9, whose first one
# is made small, is as large as the first at any step above round-off. A soft spring shows it.
SOFT = {"stiffness": 0.01, "force": 1.5, "frequency": 3.0}
SPRINGS = {"tsit5": SOFT, "vern9": SOFT}


@pytest.mark.parametrize("name", sorted(STEPS))
def test_observed_order_matches_declared(name):
    spring, errors = SPRINGS.get(name, {}), []
    for step in STEPS[name]:
        result = integrate(driven(**spring), [0.0, 0.0], [0.0, 2.0], method=name, step=step)
        errors.append(abs(result.final_state[0] - driven_motion(2.0, **spring)))
    slope, _ = np.polyfit(np.log(STEPS[name]), np.log(errors), 1)
    assert slope == pytest.approx(METHODS[name].order, abs=0.1)


@pytest.mark.parametrize("steps", [160, 161])
def test_rk4_evaluates_clock_twice_and_rates_four_times_a_step(steps):
    flow = driven()
    result = integrate(flow, [0.0, 0.0], [0.0, 1.0], method="rk4", step=1 / steps)
    assert result.steps == steps
    assert flow.parameters[3] == 2 * steps + 1
    assert result.evaluations == 4 * steps + 1


def test_dop853_takes_twelve_evaluations_a_step():
    result = integrate(driven(), [0.0, 0.0], [0.0, 10.0])
    # Two more: the start, and the trial step that finds the first step.
    assert result.evaluations == 12 * (result.steps + result.rejected) + 2


def test_steps_end_on_the_last_time():
    result = integrate(pendulum(), [1.0, 0.0], [0.0, 1.0], method="rk4", step=0.3)
    assert (result.steps, result.stop_time) == (4, 1.0)


def test_samples_at_step_ends_are_not_interpolated():
    times = np.arange(11) * 0.1
    sampled = integrate(pendulum(), [1.0, 0.0], times, method="rk4", step=0.1)
    alone = integrate(pendulum(), [1.0, 0.0], [0.0, 0.1], method="rk4", step=0.1)
    assert sampled.state[1] == pytest.approx(alone.final_state, abs=1e-16)
    assert sampled.evaluations == 41


@pytest.mark.parametrize("name", ["rk4", "gauss8"])
def test_sample_times_off_by_round_off_are_step_ends(name):
    """Times that are added up, as a user may give them; each costs no evaluation of its own."""
    steps = 100
    times = np.concatenate([[0.0], np.cumsum(np.full(steps, 0.1))])
    times[-1] = 10.0
    assert (times != 0.1 * np.arange(steps + 1)).sum() > steps / 2
    sampled = integrate(pendulum(), [1.0, 0.0], times, method=name, step=0.1)
    alone = integrate(pendulum(), [1.0, 0.0], [0.0, 10.0], method=name, step=0.1)
    assert sampled.evaluations == alone.evaluations
    exact = integrate(pendulum(), [1.0, 0.0], np.linspace(0, 10, 101), method=name, step=0.1)
    assert (sampled.state == exact.state).all()


def test_samples_of_fixed_steps_are_of_order_four():
    errors = []
    steps = np.array([0.1, 0.05, 0.025])
    times = np.linspace(0, 5, 997)
    for step in steps:
        result = integrate(pendulum(), [1.0, 0.0], times, method="rk4", step=step)
        errors.append(np.abs(result.state[:, 0] - swing(1.0, times)[0]).max())
    slope, _ = np.polyfit(np.log(steps), np.log(errors), 1)
    assert slope == pytest.approx(4, abs=0.1)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8, 1e-10, 1e-12])
def test_error_follows_tolerance(rtol):
    times = np.linspace(0, 20, 777)
    result = integrate(pendulum(), [2.0, 0.0], times, rtol=rtol)
    error = np.abs(result.state[:, 0] - swing(2.0, times)[0]).max()
    # Errors of single steps add up, and those of the energy change the period: over three swings
    # SciPy errs by up to 20 times the tolerance, we, with a sixth fewer evaluations, by 150 times.
    assert error < 200 * rtol


@pytest.mark.parametrize("rtol", [1e-8, 1e-10])
def test_dop853_agrees_with_scipy(rtol):
    def derivative(_t, y):
        return [y[1], -math.sin(y[0])]

    options = {"method": "DOP853", "rtol": rtol, "atol": rtol}
    times = np.linspace(0, 20, 100)
    theirs = solve_ivp(derivative, (0, 20), [2.0, 0.0], t_eval=times, **options)
    ours = integrate(pendulum(), [2.0, 0.0], times, rtol=rtol)
    assert ours.state == pytest.approx(theirs.y.T, abs=30 * rtol)
    alone = integrate(pendulum(), [2.0, 0.0], [0.0, 20.0], rtol=rtol)
    plain = solve_ivp(derivative, (0, 20), [2.0, 0.0], **options)
    assert alone.evaluations < plain.nfev


def test_tolerance_may_differ_between_coordinates():
    loose = integrate(pendulum(), [2.0, 0.0], [0.0, 20.0], rtol=1e-12, atol=[1e-3, 1e-3])
    tight = integrate(pendulum(), [2.0, 0.0], [0.0, 20.0], rtol=1e-12, atol=[1e-3, 1e-12])
    assert loose.steps < tight.steps


def test_fixed_step_beyond_stability_is_reported():
    # RK4 is stable on this up to step·rate = 2.785; at 10 the speed grows 291-fold a step.
    result = integrate(
        flow(decay_rates, [1000.0]), [0.0, 1.0], np.linspace(0, 10, 11), method="rk4", step=0.01
    )
    assert result.outcome is Outcome.NOT_FINITE
    assert result.stop_time < 1.0
    assert "smaller step" in str(result.outcome)
    assert len(result.time) == 1


def test_long_time_does_not_drift():
    # A hundred thousand steps of 0.1 s that are added up miss the end by 1e-8 s.
    result = integrate(pendulum(), [0.1, 0.0], [0.0, 1e4], method="rk4", step=0.1)
    assert (result.steps, result.stop_time) == (100_000, 1e4)


def test_time_of_adaptive_steps_does_not_drift():
    """Far from t = 0 every sum of time is rounded by up to 6e-8 s, ever the same way."""
    far, end = 1e9, 50.0
    near = integrate(harmonic(), [1.0, 0.0], [0.0, end], method="tsit5", rtol=1e-11)
    assert near.steps > 2000
    late = integrate(harmonic(), [1.0, 0.0], [far, far + end], method="tsit5", rtol=1e-11)
    # The last digit of the time is worth 1.2e-7 s, and speeds are 2 at most.
    assert late.final_state == pytest.approx(near.final_state, abs=5e-7)


def test_step_after_a_rejected_one_does_not_grow():
    """Where steps have just been too long they are made no longer at once (Hairer I, II.4)."""
    lengths, accepted = attempts("tsit5", rtol=1e-4)
    after = [k for k in range(1, len(lengths) - 1) if accepted[k] and not accepted[k - 1]]
    assert len(after) > 3
    following = np.array([lengths[k + 1] / lengths[k] for k in after])
    assert following.max() <= 1.0 + 1e-9  # lengths are differences of times


def attempts(name, **settings):
    """Lengths of all steps that were tried around the orbit, and which were accepted."""
    table = METHODS[name].tableau
    calls = np.count_nonzero(np.diff(np.append(table.c[: table.stages], 1.0)) != 0)
    orbit = arenstorf()
    logged = dataclasses.replace(
        orbit, clock=logging_clock.address, parameters=np.append(orbit.parameters, np.zeros(9999))
    )
    result = integrate(logged, ORBIT, [0.0, PERIOD], method=name, **settings)
    count = int(logged.parameters[1])
    # the start, and the trial that finds the first step
    ends = logged.parameters[2 : 2 + count][2:].reshape(-1, calls)[:, -1]
    assert len(ends) == result.steps + result.rejected
    accepted = np.append(ends[1:] > ends[:-1], True)
    starts = np.concatenate([[0.0], np.maximum.accumulate(np.where(accepted, ends, 0.0))[:-1]])
    return ends - starts, accepted
