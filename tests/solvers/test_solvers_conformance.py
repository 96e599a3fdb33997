"""What every method of integration has to do."""

import math
import signal
import threading

import numpy as np
import pytest
from solver_kernels import (
    coupled,
    coupled_motion,
    driven,
    driven_motion,
    explosion_rates,
    flow,
    free_rates,
    limited_clock,
    limited_rates,
    nothing_rates,
    passing_rates,
    pendulum,
    rotation,
    swing,
)

from linkages.solvers import METHODS, Event, Outcome, integrate, integration
from linkages.solvers.integration import request
from linkages.solvers.loops.memory import PAUSED

# Fixed steps at which the global error of each method is about 1e-9 on the motions below.
STEPS = {
    "rk4": 1 / 256,
    "gauss8": 1 / 16,
    "dop853": None,
    "tsit5": None,
    "vern9": None,
    "radau": None,
}
TOLERANCE = 1e-8


@pytest.fixture(params=sorted(METHODS))
def method(request):
    assert request.param in STEPS, "a new method joins this suite by its entry in STEPS"
    return {"method": request.param, "step": STEPS[request.param]}


def test_pendulum_follows_elliptic_functions(method):
    times = np.linspace(0, 20, 333)
    result = integrate(pendulum(), [2.0, 0.0], times, **method)
    angle, speed = swing(2.0, times)
    assert result.outcome is Outcome.DONE
    assert result.state[:, 0] == pytest.approx(angle, abs=TOLERANCE)
    assert result.state[:, 1] == pytest.approx(speed, abs=TOLERANCE)
    assert result.acceleration[:, 0] == pytest.approx(-np.sin(angle), abs=TOLERANCE)


@pytest.mark.parametrize("events", [[], [Event(weights=[1, 0], level=0.5)]], ids=["", "event"])
def test_a_loop_goes_on_where_it_was_left(method, events):
    """In all bits: a short motion runs in the thread that asks, and another one takes over."""
    given = pendulum(), [2.0, 0.0], np.linspace(0, 100, 33)
    whole = integrate(*given, events=events, **method)
    asked = request(*given, events=events, **method)
    loop, left = asked.method.prepare(asked.job), 0
    while (outcome := loop(rounds=1)) == PAUSED:
        left += 1
    parts = asked.trajectory(Outcome(outcome))
    assert left > 0
    assert parts.outcome is Outcome.DONE
    assert (parts.steps, parts.evaluations) == (whole.steps, whole.evaluations)
    assert np.array_equal(parts.state, whole.state)
    assert np.array_equal(parts.final_state, whole.final_state)


@pytest.mark.parametrize(("quick", "threads"), [(np.inf, 0), (0.0, 1)])
def test_only_motions_that_are_not_quick_have_a_thread(monkeypatch, quick, threads):
    started = []
    monkeypatch.setattr(integration, "QUICK", quick)
    start = threading.Thread.start
    monkeypatch.setattr(threading.Thread, "start", lambda own: (started.append(own), start(own)))
    integrate(pendulum(), [2.0, 0.0], [0.0, 1e4])
    assert len(started) == threads


@pytest.mark.slow_except("[!r]*", "rk4")
def test_driven_oscillator_follows_closed_form(method):
    times = np.linspace(0, 10, 101)
    result = integrate(driven(), [0.0, 0.0], times, **method)
    exact = driven_motion(times)
    assert result.state[:, 0] == pytest.approx(exact, abs=TOLERANCE)
    assert result.acceleration[:, 0] == pytest.approx(
        -4.0 * exact + 1.5 * np.cos(3.0 * times), abs=5 * TOLERANCE
    )


@pytest.mark.slow_except("[!r]*", "rk4")
def test_coupled_oscillators_follow_their_modes(method):
    times = np.linspace(0, 10, 57)
    result = integrate(coupled(), [1.0, 0.0, 0.0, 0.0], times, **method)
    assert result.state[:, :2] == pytest.approx(coupled_motion(times), abs=TOLERANCE)


@pytest.mark.slow_except("[!r]*", "rk4")
def test_turns_are_counted_apart(method):
    times = np.linspace(0, 50, 401)
    result = integrate(pendulum(), [0.0, 3.0], times, **method)
    exact = rotation(3.0, times)
    # Errors grow with time: a speed that is off moves the angle ever further.
    assert result.unwrapped[:, 0] == pytest.approx(exact, abs=10 * TOLERANCE)
    assert np.abs(result.state[:, 0]).max() <= math.pi
    assert result.turns[-1, 0] == round(exact[-1] / (2 * math.pi)) > 10
    assert (result.final_turns == result.turns[-1]).all()


def test_initial_angle_is_wrapped(method):
    result = integrate(pendulum(), [2.0 - 6 * math.pi, 0.0], [0.0, 1.0], **method)
    assert result.turns[:, 0].tolist() == [-3, -3]
    assert result.state[0, 0] == pytest.approx(2.0, abs=1e-14)


@pytest.mark.slow_except("[!r]*", "rk4")
def test_backward_in_time_returns(method):
    start = [2.0, 0.5]
    there = integrate(pendulum(), start, [0.0, 10.0], **method)
    back = integrate(pendulum(), there.final_state, [10.0, 0.0], **method)
    assert back.outcome is Outcome.DONE
    assert back.stop_time == 0.0
    assert back.final_state == pytest.approx(np.array(start), abs=2 * TOLERANCE)


@pytest.mark.slow_except("[!r]*", "rk4")
def test_samples_do_not_change_the_motion(method):
    grids = [[0.0, 7.0], np.linspace(0, 7, 29), np.linspace(0, 7, 1000)]
    ends = [integrate(driven(), [1.0, 0.0], grid, **method) for grid in grids]
    for end in ends[1:]:
        assert end.final_state.tobytes() == ends[0].final_state.tobytes()
        assert end.steps == ends[0].steps


@pytest.mark.slow_except("[!r]*", "rk4")
def test_equal_input_gives_equal_bits(method):
    times = np.linspace(0, 7, 100)
    first, second = (integrate(pendulum(), [3.0, 0.1], times, **method) for _ in range(2))
    assert first.state.tobytes() == second.state.tobytes()


@pytest.mark.slow_except("[!r]*", "rk4")
def test_start_may_lie_before_the_first_sample(method):
    whole = integrate(pendulum(), [1.0, 0.0], [0.0, 1.0, 2.0], **method)
    part = integrate(pendulum(), [1.0, 0.0], [1.0, 2.0], start=0.0, **method)
    assert part.state.tobytes() == whole.state[1:].tobytes()


def test_no_time_at_all(method):
    result = integrate(pendulum(), [1.0, 0.0], [3.0], **method)
    assert result.outcome is Outcome.DONE
    assert result.state.tolist() == [[1.0, 0.0]]
    assert result.acceleration[0, 0] == pytest.approx(-math.sin(1.0), abs=1e-15)
    assert result.steps == 0


def test_no_coordinates_at_all(method):
    result = integrate(flow(nothing_rates, rotates=[]), [], [0.0, 1.0, 2.0], **method)
    assert result.outcome is Outcome.DONE
    assert result.state.shape == (3, 0)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_aligned_links_are_located(method, direction):
    times = direction * np.linspace(0, 3, 31)
    passing = flow(passing_rates, [0.0], blocks=1)
    result = integrate(passing, [0.05, direction], times, **method)
    assert result.outcome is Outcome.SINGULAR
    assert result.block == 0
    assert result.stop_time == pytest.approx(0.95 * direction, abs=1e-6)
    assert result.final_state[0] == pytest.approx(1.0, abs=1e-6)
    assert len(result.time) == 10


def test_links_that_pass_beside_alignment_are_let_through(method):
    result = integrate(flow(passing_rates, [1e-3], blocks=1), [0.05, 1.0], [0.0, 3.0], **method)
    assert result.outcome is Outcome.DONE
    assert result.final_state[0] == pytest.approx(3.05, abs=1e-12)


def test_links_aligned_at_the_start(method):
    result = integrate(flow(passing_rates, [0.0], blocks=1), [1.0, 1.0], [0.0, 1.0], **method)
    assert result.outcome is Outcome.SINGULAR
    assert (result.stop_time, result.steps) == (0.0, 0)


@pytest.mark.parametrize("far", [0.0, 1000.0])
def test_end_of_reach_is_located(method, far):
    times = far + np.linspace(0, 3, 31)
    result = integrate(flow(limited_rates, [1.2345]), [0.0, 1.0], times, **method)
    assert result.outcome is Outcome.UNREACHABLE
    assert result.block == 1
    # The adaptive method stops once its step is below 16 ε·t.
    smallest = 16 * np.finfo(float).eps * (far + 1.2345)
    assert result.stop_time == pytest.approx(far + 1.2345, abs=max(1e-12, smallest))
    assert len(result.time) == 13
    assert result.final_state[0] == pytest.approx(1.2345, abs=max(1e-12, smallest))


@pytest.mark.parametrize("name", ["dop853", "tsit5", "vern9"])
def test_trials_beyond_the_end_of_reach_are_counted(name):
    """Each is a quarter of the last, from a length like 1 down to 16 ε·t: 26 of them or so."""
    result = integrate(flow(limited_rates, [1.2345]), [0.0, 1.0], [0.0, 3.0], method=name)
    assert 15 < result.rejected < 60
    assert result.evaluations > 5 * (result.steps + result.rejected)


def test_end_of_reach_of_a_drive_is_located(method):
    limited = flow(free_rates, [1.2345], clock=limited_clock)
    result = integrate(limited, [0.0, 1.0], [0.0, 1.0, 2.0], **method)
    assert (result.outcome, result.block) == (Outcome.UNREACHABLE, 0)
    assert result.stop_time == pytest.approx(1.2345, abs=1e-12)
    assert len(result.time) == 2


def test_out_of_reach_at_the_start(method):
    result = integrate(flow(limited_rates, [1.0]), [2.0, 1.0], [0.0, 1.0], **method)
    assert (result.outcome, result.block) == (Outcome.UNREACHABLE, 1)
    assert len(result.time) == 0
    assert result.final_state.tolist() == [2.0, 1.0]


@pytest.mark.slow_except("[!r]*", "rk4")
def test_explosion_is_no_motion(method):
    result = integrate(flow(explosion_rates), [0.0, 1.0], np.linspace(0, 2, 201), **method)
    ends = (Outcome.NOT_FINITE, Outcome.STEP_TOO_SMALL, Outcome.NOT_CONVERGED)
    assert result.outcome in ends
    assert np.isfinite(result.state).all()
    # A fixed step leaps over the pole at t = 1 and takes a few steps to overflow.
    assert result.stop_time == pytest.approx(1.0, abs=20 * (method["step"] or 1e-9))


def test_budget_of_steps(method):
    result = integrate(pendulum(), [1.0, 0.0], np.linspace(0, 1e3, 101), max_steps=40, **method)
    assert result.outcome is Outcome.STEP_BUDGET
    assert result.steps + result.rejected == 40
    assert 0 < result.stop_time < 1e3
    again = integrate(pendulum(), [1.0, 0.0], [0.0, result.stop_time], **method)
    assert again.final_state == pytest.approx(result.final_state, abs=TOLERANCE)


def test_control_c_keeps_what_was_computed(method):
    def press(fraction):
        if fraction > 1e-9:  # beyond the second sample
            signal.raise_signal(signal.SIGINT)

    times = np.concatenate([[0.0, 1.0], [1e9]])
    result = integrate(pendulum(), [2.0, 0.0], times, watch=press, **method)
    assert result.outcome is Outcome.INTERRUPTED
    assert result.time.tolist() == [0.0, 1.0]
    assert 1.0 < result.stop_time < 1e9
    assert result.state[1, 0] == pytest.approx(swing(2.0, 1.0)[0], abs=TOLERANCE)


def test_control_c_at_the_end_is_heard(method):
    def press(fraction):
        if fraction == 1.0:
            signal.raise_signal(signal.SIGINT)

    result = integrate(pendulum(), [2.0, 0.0], [0.0, 1.0], watch=press, **method)
    assert result.outcome is Outcome.INTERRUPTED
    assert result.time.tolist() == [0.0, 1.0]
    assert result.state[1, 0] == pytest.approx(swing(2.0, 1.0)[0], abs=TOLERANCE)


@pytest.mark.slow_except("[!r]*", "rk4")
def test_watch_sees_progress_and_the_end(method):
    seen = []
    # low order asks for many steps
    end = 1e3 if method["method"] == "radau" else 2e4
    integrate(pendulum(), [2.0, 0.0], [0.0, end], watch=seen.append, **method)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


def test_failing_watch_stops_the_run(method):
    def fail(_fraction):
        raise RuntimeError("no display")

    with pytest.raises(RuntimeError, match="no display"):
        integrate(pendulum(), [2.0, 0.0], [0.0, 1e9], watch=fail, **method)
