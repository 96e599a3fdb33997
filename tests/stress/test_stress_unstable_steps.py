"""Steps too long for the swing of the clearance are reported, whatever they make of the motion.

The nine-bar's clearance swings at up to 650 rad/s. On an oscillation of angular frequency ω the
classical RK4 is stable for ωh < 2.83, steps below 4.3 ms; the iteration for the stages of gauss8
contracts for steps of that order, too.
"""

import numpy as np
import pytest
from stress_mechanisms import HELD

import linkages
from linkages.kernel.system import System
from linkages.solution.plan import build_flow
from linkages.solvers import Outcome, integrate

UNSTABLE = [0.5, 0.1, 0.05, 0.02, 0.01, 0.005]
FASTEST = 400.0  # rad/s; the reference stays below 290


@pytest.mark.parametrize("step", UNSTABLE)
@pytest.mark.parametrize("method", ["rk4", "gauss8"])
def test_too_long_a_step_is_reported(method, step):
    """Never as a motion to its end; the message says when it ended and what to do."""
    solution = linkages.simulate(
        linkages.load("ninebar"), method=method, step=step, samples=21, throw=False
    )
    assert not solution.completed
    assert solution.motion.stop_time < 0.1
    assert "Take a smaller step" in solution.motion.failure
    assert all(np.isfinite(solution.data[name]).all() for name in solution.data)


@pytest.mark.parametrize("step", [5e-3, 3e-3, 1e-3, 1e-4])
def test_result_is_right_or_reported_or_damped_visibly(step):
    """What the program says of an RK4 run: it diverged, or the comparison run shows no digits."""
    solution = linkages.simulate(
        linkages.load("ninebar"), method="rk4", step=step, samples=201, throw=False
    )
    if not solution.completed:
        assert "diverged" in solution.motion.failure
        return
    reference = linkages.simulate(linkages.load("ninebar"), samples=201, method="vern9")
    error = np.abs(solution.data.clearance_angle - reference.data.clearance_angle).max()
    horizon = solution.horizon
    assert horizon is not None
    if float(error) > 0.3:
        assert not horizon.whole
        assert horizon.time < 0.5


@pytest.mark.parametrize("method", ["rk4", "gauss8"])
def test_divergence_is_not_hidden_by_a_damped_motion(method):
    """The drives held still: without divergence the energy could only fall."""
    swings = linkages.load("ninebar", set=HELD)
    solution = linkages.simulate(swings, method=method, step=0.02, samples=11, throw=False)
    assert not solution.completed
    assert "at t = " in solution.motion.failure


@pytest.mark.parametrize("method", ["rk4", "gauss8"])
def test_final_state_of_a_diverged_run_is_the_last_good_one(method):
    system = System(linkages.load("ninebar"))
    found = integrate(build_flow(system), system.state, [0.0, 2.0], method=method, step=0.1)
    assert found.outcome in (Outcome.NOT_FINITE, Outcome.NOT_CONVERGED)
    assert np.isfinite(found.final_state).all()
    assert found.stop_time == 0.0
    assert np.array_equal(found.final_state, system.state)


@pytest.mark.parametrize("method", ["dop853", "tsit5", "vern9"])
def test_adaptive_methods_keep_to_the_swing_at_a_loose_tolerance(method):
    """Three digits are asked for; steps are short enough for the swing all the same."""
    solution = linkages.simulate(
        linkages.load("ninebar"), method=method, rtol=1e-3, samples=21, throw=False
    )
    assert solution.completed
    assert float(np.abs(solution.data.clearance_speed).max()) < FASTEST


@pytest.mark.parametrize("method", ["dop853", "tsit5", "vern9"])
def test_hardly_any_tolerance_ends_with_a_reason_or_at_the_end(method):
    """An error of a tenth per step is no motion of the press, but it is no hang either."""
    solution = linkages.simulate(
        linkages.load("ninebar"), method=method, rtol=0.1, atol=0.1, samples=21, throw=False
    )
    assert solution.motion.cost["steps"] < 100_000
    assert solution.completed or "at t = " in solution.motion.failure
    assert all(np.isfinite(solution.data[name]).all() for name in solution.data)
