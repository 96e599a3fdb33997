"""Crossings of levels are found, located to round-off, and change nothing."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.special import ellipk
from solver_kernels import (
    coupled,
    driven,
    flow,
    free_rates,
    limited_rates,
    line,
    pendulum,
    rotation,
    swing,
)

from linkages.solvers import METHODS, Event, Outcome, integrate

STEPS = {"rk4": 1 / 256, "gauss8": 1 / 16}
# Global error of every method on these motions; see the conformance tests.
TOLERANCE = 1e-8
QUARTER = float(ellipk(math.sin(1.0) ** 2))  # of the period of a swing of 2 rad


@pytest.fixture(params=sorted(METHODS))
def method(request):
    return {"method": request.param, "step": STEPS.get(request.param)}


def test_zeros_of_a_swing(method):
    events = [Event(weights=[1, 0]), Event(weights=[1, 0], direction=1)]
    result = integrate(pendulum(), [2.0, 0.0], [0.0, 20.0], events=events, **method)
    both, up = result.crossings
    expected = QUARTER * np.arange(1, 20 / QUARTER, 2)
    assert both.time == pytest.approx(expected, abs=TOLERANCE)
    assert up.time == pytest.approx(expected[1::2], abs=TOLERANCE)
    # Located to round-off: the function vanishes to the last digits of the angles around it.
    assert np.abs(both.state[:, 0]).max() < 1e-14
    assert both.count == len(expected)


def test_an_event_at_the_very_end_ends_the_run(method):
    """It is the last step that ends there, not one that is shortened."""
    event = Event(weights=[1, 0], level=1.0, terminal=1)
    result = integrate(flow(free_rates), [0.0, 1.0], [0.0, 1.0], events=[event], **method)
    assert result.outcome is Outcome.EVENT
    assert result.stop_time == pytest.approx(1.0, abs=1e-15)
    assert result.crossings[0].count == 1


def test_directions_share_all_crossings(method):
    events = [Event(weights=[0.3, 1.0], level=0.1, direction=d) for d in (-1, 0, 1)]
    result = integrate(pendulum(), [2.0, 0.0], [0.0, 20.0], events=events, **method)
    down, both, up = (crossing.time for crossing in result.crossings)
    assert len(down) > 1
    assert len(up) > 1
    assert np.sort([*down, *up]) == pytest.approx(both, abs=1e-12)
    rates = [-np.sin(c.state[:, 0]) + 0.3 * c.state[:, 1] for c in result.crossings]
    assert (rates[0] < 0).all()
    assert (rates[2] > 0).all()


def test_events_do_not_change_the_motion(method):
    events = [Event(weights=[1, 0], level=0.3), Event(weights=[0, 1])]
    times = np.linspace(0, 20, 77)
    plain = integrate(pendulum(), [2.0, 0.0], times, **method)
    watched = integrate(pendulum(), [2.0, 0.0], times, events=events, **method)
    assert watched.state.tobytes() == plain.state.tobytes()
    assert watched.steps == plain.steps
    assert plain.crossings == ()


def test_level_of_an_angle_means_every_turn(method):
    events = [Event(weights=[1, 0], level=1.0), Event(weights=[2, 0], level=1.0)]
    result = integrate(pendulum(), [0.0, 3.0], [0.0, 30.0], events=events, **method)
    turns = math.floor((rotation(3.0, 30.0) - 1.0) / (2 * math.pi)) + 1
    assert result.crossings[0].count == turns > 5
    assert np.abs(result.crossings[0].state[:, 0] - 1.0).max() < 1e-14
    assert result.crossings[0].turns[:, 0].tolist() == list(range(turns))
    found = np.exp(2j * result.crossings[1].state[:, 0])
    assert found == pytest.approx(np.full(len(found), np.exp(1j)), abs=1e-13)


def test_levels_beyond_a_turn_and_backward_in_time(method):
    event = Event(weights=[-1, 0], level=2.0 + 40 * math.pi)
    result = integrate(pendulum(), [0.0, 3.0], [0.0, -10.0], events=[event], **method)
    assert result.crossings[0].state[0, 0] == pytest.approx(-2.0, abs=1e-13)
    assert (np.diff(result.crossings[0].time) < 0).all()


def test_fractions_of_angles_count_whole_turns(method):
    event = Event(weights=[0.5, 0], level=8.0)
    result = integrate(pendulum(), [0.0, 3.0], [0.0, 30.0], events=[event], **method)
    (crossing,) = result.crossings
    assert crossing.count == 1
    angle = crossing.state[0, 0] + 2 * math.pi * crossing.turns[0, 0]
    assert angle == pytest.approx(16.0, abs=1e-13)


@pytest.mark.parametrize("kind", ["weights", "function"])
def test_two_crossings_within_one_step(kind):
    # At its greatest angle the pendulum is above this level for some 0.06 of a step of 0.5 s.
    level = float(swing(2.0, 0.015)[0])
    event = Event(**{kind: [1, 0] if kind == "weights" else line(1.0, 0.0, 0.0, 0.0)}, level=level)
    times = [0.0, 4 * QUARTER + 0.25]
    result = integrate(pendulum(), [2.0, 0.0], times, method="gauss8", step=0.05, events=[event])
    expected = [0.015, 4 * QUARTER - 0.015, 4 * QUARTER + 0.015]
    assert result.crossings[0].time == pytest.approx(expected, abs=1e-9)


def test_terminal_event_ends_the_run(method):
    events = [Event(weights=[1, 0], terminal=3), Event(weights=[0, 1])]
    times = np.linspace(0, 20, 201)
    result = integrate(pendulum(), [2.0, 0.0], times, events=events, **method)
    assert result.outcome is Outcome.EVENT
    assert result.stop_time == pytest.approx(5 * QUARTER, abs=TOLERANCE)
    assert result.time[-1] <= result.stop_time < result.time[-1] + 0.1
    assert abs(result.final_state[0]) < 1e-14
    assert [crossing.count for crossing in result.crossings] == [3, 2]
    assert result.state[:, 0] == pytest.approx(swing(2.0, result.time)[0], abs=TOLERANCE)


def test_run_from_a_crossing_does_not_meet_it_again(method):
    event = Event(weights=[1, 0], level=0.7, terminal=1)
    state, time, seen = np.array([2.0, 0.0]), 0.0, []
    for _ in range(4):
        part = integrate(pendulum(), state, [time, time + 10.0], events=[event], **method)
        state, time = part.final_state, part.stop_time
        seen.append(time)
    whole = integrate(
        pendulum(), [2.0, 0.0], [0.0, 20.0], events=[Event(weights=[1, 0], level=0.7)], **method
    )
    assert seen == pytest.approx(whole.crossings[0].time[:4], abs=TOLERANCE)


@pytest.mark.parametrize("rotates", [False, True])
@pytest.mark.parametrize("speed", [1.0, -1.0])
def test_start_that_round_off_puts_before_a_level_is_on_it(method, rotates, speed):
    """As a located crossing leaves it: the last digit may be on either side."""
    level = 0.7
    before = math.nextafter(level, level - speed)
    event = Event(weights=[1, 0], level=level)
    moving = flow(free_rates, rotates=[rotates])
    result = integrate(moving, [before, speed], [0.0, 6.0], events=[event], **method)
    assert result.crossings[0].count == 0
    farther = [level - 1e-9 * speed, speed]  # a thousand times what counts as on the level
    result = integrate(moving, farther, [0.0, 6.0], events=[event], **method)
    assert result.crossings[0].count == 1


@pytest.mark.parametrize("name", ["rk4", "gauss8"])
@pytest.mark.parametrize("forward", [1.0, -1.0])
def test_crossings_after_the_end_of_a_run_are_not_recorded(name, forward):
    """Within one step: what is found before the event that ends the run may lie behind it."""
    levels = [0.6, 0.2, 0.4]
    events = [Event(weights=[1, 0], level=forward * level) for level in levels]
    events[2] = dataclasses.replace(events[2], terminal=1)
    events.append(Event(weights=[1, 0], level=forward * 0.8))
    result = integrate(
        flow(free_rates), [0.0, 1.0], [0.0, forward], method=name, step=1.0, events=events
    )
    assert result.stop_time == pytest.approx(forward * 0.4, abs=1e-15)
    assert [crossing.count for crossing in result.crossings] == [0, 1, 1, 0]


def test_memory_is_bounded(method):
    event = Event(weights=[1, 0], capacity=3)
    result = integrate(pendulum(), [2.0, 0.0], [0.0, 60.0], events=[event], **method)
    assert len(result.crossings[0].time) == 3
    assert result.crossings[0].count == math.ceil((60 / QUARTER - 1) / 2)


def test_several_coordinates(method):
    event = Event(weights=[1, 1, 0, 0], direction=-1)
    result = integrate(coupled(), [1.0, 0.0, 0.0, 0.0], [0.0, 10.0], events=[event], **method)
    # The sum of both displacements is cos t.
    assert result.crossings[0].time == pytest.approx([0.5 * math.pi, 2.5 * math.pi], abs=TOLERANCE)


def test_driven_motion(method):
    event = Event(weights=[0, 1], level=0.2)
    result = integrate(driven(), [0.0, 0.0], [0.0, 10.0], events=[event], **method)
    assert result.crossings[0].count > 3
    assert np.abs(result.crossings[0].state[:, 1] - 0.2).max() < 1e-14


def test_crossing_before_the_end_of_reach(method):
    events = [Event(weights=[1, 0], level=1.0), Event(weights=[1, 0], level=1.3)]
    result = integrate(
        flow(limited_rates, [1.2345]), [0.0, 1.0], [0.0, 2.0], events=events, **method
    )
    assert result.outcome is Outcome.UNREACHABLE
    assert [crossing.count for crossing in result.crossings] == [1, 0]


def test_motion_along_a_level_is_no_crossing(method):
    event = Event(weights=[0, 1], level=1.0)
    result = integrate(flow(free_rates), [0.0, 1.0], [0.0, 5.0], events=[event], **method)
    assert result.crossings[0].count == 0


# functions instead of weights


def test_linear_functions_cross_where_weights_do(method):
    pairs = [
        (Event(weights=[0.3, 1.0], level=0.1, direction=d),
         Event(function=line(0.3, 1.0, 0.0, 0.0), level=0.1, direction=d))
        for d in (-1, 0, 1)
    ]  # fmt: skip
    events = [event for pair in pairs for event in pair]
    result = integrate(pendulum(), [2.0, 0.0], [0.0, 20.0], events=events, **method)
    found = result.crossings
    for linear, function in zip(found[::2], found[1::2], strict=True):
        assert len(linear.time) > 1
        assert function.time == pytest.approx(linear.time, abs=1e-13)
        assert function.state == pytest.approx(linear.state, abs=1e-13)


def test_functions_of_angle_and_time(method):
    """sin q = t/20, located to round-off at states of the motion."""
    event = Event(function=line(0.0, 0.0, 1.0, 0.05))
    result = integrate(pendulum(), [2.0, 0.0], [0.0, 19.0], events=[event], **method)
    (found,) = result.crossings
    assert len(found.time) > 3
    assert np.sin(found.state[:, 0]) == pytest.approx(0.05 * found.time, abs=1e-13)
    angles, _ = swing(2.0, found.time)
    assert found.state[:, 0] == pytest.approx(angles, abs=TOLERANCE)
    dense = np.linspace(0, 19, 100_001)
    signs = np.sign(np.sin(swing(2.0, dense)[0]) - 0.05 * dense)
    assert len(found.time) == np.count_nonzero(np.diff(signs))


def test_functions_are_evaluated_once_per_trial():
    counted = line(0.0, 1.0, 0.0, 0.0)
    result = integrate(
        pendulum(), [2.0, 0.0], [0.0, 20.0], events=[Event(function=counted, level=9)]
    )
    assert result.crossings[0].count == 0
    # once more at the start, and at the ends of two steps that need more than arithmetic: the first
    # one, before which nothing is known, and the last one, which has a sample
    assert counted.parameters[4] == result.steps + result.rejected + 3


def test_an_event_has_weights_or_a_function():
    with pytest.raises(ValueError, match="either weights or a function"):
        Event(weights=[1, 0], function=line(1.0, 0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"weights": [0.0, 0.0]}, "not all of them zero"),
        ({"weights": [1.0, math.nan]}, "finite"),
        ({"level": math.inf}, "level of an event must be finite"),
        ({"direction": 2}, "direction of an event"),
        ({"terminal": -1}, "terminal"),
        ({"capacity": 0}, "capacity"),
    ],
)
def test_events_that_make_no_sense(change, message):
    with pytest.raises(ValueError, match=message):
        Event(**({"weights": [1.0, 0.0]} | change))


def test_event_of_another_mechanism():
    with pytest.raises(ValueError, match="1 coordinates and as many speeds"):
        integrate(pendulum(), [1.0, 0.0], [0.0, 1.0], events=[Event(weights=[1.0])])
