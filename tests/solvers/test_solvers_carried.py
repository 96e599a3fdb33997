"""Coordinates that are carried along, and integrations that stop early at small margins."""

# Kernels share two signatures.
# ruff: noqa: ARG001

import math
from dataclasses import replace

import numpy as np
import pytest
from solver_kernels import flow, free_rates, no_clock, passing_rates, pendulum, rates, sin, swing

from linkages.solvers import Flow, Outcome, integrate

METHODS = [("dop853", None), ("tsit5", None), ("vern9", None), ("rk4", 0.02), ("gauss8", 0.1)]
METHOD = pytest.mark.parametrize(("method", "step"), METHODS)
ANY_METHOD = pytest.mark.parametrize(("method", "step"), [*METHODS, ("radau", None)])
"""With radau, whose error control looks after what is carried along."""


@rates
def following_rates(y, p, timed, out):
    """A pendulum q0 and a coordinate q1 = 2 q0 + p1 that follows from it.

    Its acceleration is off by p0, so that without being settled it would run away.
    """
    out[0] = -sin(y[0])
    out[1] = 2.0 * out[0] + p[0]
    out[2] = 2.0 * y[0] + p[1]
    out[3] = 2.0 * y[2]


@rates
def leading_rates(y, p, timed, out):
    """The same, the coordinate that follows being the first."""
    out[0] = -2.0 * sin(y[1]) + p[0]
    out[1] = -sin(y[1])
    out[2] = 2.0 * y[1] + p[1]
    out[3] = 2.0 * y[3]


def carrying(kernel, first, off=0.0, start=0.0):
    return Flow(
        clock=no_clock.address,
        rates=kernel.address,
        parameters=np.array([off, start]),
        timed_size=0,
        coordinates=2,
        rotates=np.array([False, False]),
        margin_scale=np.ones(0),
        first_carried=first,
        carried=1,
        keepalive=(no_clock, kernel),
    )


TIMES = np.linspace(0, 10, 41)


@METHOD
def test_what_is_carried_along_is_settled_after_every_step(method, step):
    """A wrong rate does not add up, and what is integrated is not touched."""
    flow_ = carrying(following_rates, 1, off=1e-3, start=0.5)
    found = integrate(flow_, [1.0, 2.5, 0.0, 0.0], TIMES, method=method, step=step, rtol=1e-9)
    assert found.outcome is Outcome.DONE
    angle, speed = swing(1.0, TIMES)
    assert found.state[:, 0] == pytest.approx(angle, abs=1e-6)
    assert found.state[:, 2] == pytest.approx(speed, abs=1e-6)
    # off by 1e-3·h²/2 within a step at most; without settling it would be 0.05
    assert found.state[:, 1] == pytest.approx(2 * found.state[:, 0] + 0.5, abs=2e-3)
    final = found.final_state
    assert final[1] == pytest.approx(2 * final[0] + 0.5, abs=2e-3)


@METHOD
def test_the_end_of_a_step_is_settled_exactly(method, step):
    found = integrate(
        carrying(following_rates, 1, off=1e-3),
        [1.0, 2.0, 0.0, 0.0],
        [0.0, 3.0],
        method=method,
        step=step,
    )
    final = found.final_state
    assert final[1] == 2.0 * final[0]
    assert final[3] == 2.0 * final[2]


@pytest.mark.slow_except("[!r]*", "rk4*")
@ANY_METHOD
def test_the_place_of_what_is_carried_along(method, step):
    found = integrate(
        carrying(leading_rates, 0, start=-1.0),
        [1.0, 1.0, 0.0, 0.0],
        TIMES,
        method=method,
        step=step,
        rtol=1e-10,
    )
    angle, speed = swing(1.0, TIMES)
    tolerance = 1e-7  # of fourth order with a step of 0.02
    assert found.state[:, 1] == pytest.approx(angle, abs=tolerance)
    assert found.state[:, 0] == pytest.approx(2 * angle - 1, abs=3 * tolerance)
    assert found.state[:, 2] == pytest.approx(2 * speed, abs=3 * tolerance)


@ANY_METHOD
def test_a_flow_without_such_coordinates_is_what_it_was(method, step):
    times = np.linspace(0, 3, 7)
    plain = integrate(pendulum(), [1.0, 0.0], times, method=method, step=step)
    with_zero = integrate(
        replace(pendulum(), first_carried=1, carried=0), [1.0, 0.0], times, method=method, step=step
    )
    assert np.array_equal(plain.state, with_zero.state)


# --- least margins ------------------------------------------------------------------------------


def passing(least, closest=0.3):
    """Uniform motion past q = 1, with the margin √((q − 1)² + closest²)."""
    of = flow(passing_rates, [closest], blocks=1)
    return replace(of, least_margin=np.array([least]))


@ANY_METHOD
def test_it_stops_where_a_margin_falls_below_the_least(method, step):
    found = integrate(passing(0.5), [0.0, 1.0], [0.0, 2.0], method=method, step=step)
    assert found.outcome is Outcome.SINGULAR
    assert found.block == 0
    exact = 1.0 - math.sqrt(0.5**2 - 0.3**2)
    # the first margin that is too small is found within a few thousandths of a step
    assert found.stop_time <= exact + 1e-9
    assert found.stop_time == pytest.approx(exact, abs=0.02)


@ANY_METHOD
@pytest.mark.parametrize(("least", "start", "end"), [(0.25, 0.0, 2.0), (0.5, 1.01, 1.0)])
def test_it_goes_on_where_margins_stay_larger_or_grow(least, start, end, method, step):
    """In the second case from the closest place on, forward in time."""
    found = integrate(passing(least), [start, 1.0], [0.0, end], method=method, step=step)
    assert found.outcome is Outcome.DONE


@ANY_METHOD
def test_backward_in_time_falling_is_growing(method, step):
    found = integrate(passing(0.5), [2.0, 1.0], [0.0, -1.5], method=method, step=step)
    assert found.outcome is Outcome.SINGULAR
    assert found.stop_time == pytest.approx(-1.0 + 0.4, abs=0.02)


def test_the_default_is_the_smallest_that_is_sound():
    of = flow(free_rates, blocks=2)
    assert of.smallest_margins.tolist() == [1e-5, 1e-5]
    scaled = replace(of, margin_scale=np.array([2.0, 0.5]), least_margin=np.array([0.1, 0.2]))
    assert scaled.smallest_margins == pytest.approx([0.2, 0.1])
