"""Motions that go on side by side are, in all bits, those that go on alone."""

import numpy as np
import pytest
from lane_kernels import QUIET, duffing

from linkages.solvers.integration import integrate, request
from linkages.solvers.lanes import integrate_many
from linkages.solvers.trajectory import Outcome

PARTS = ("time", "state", "turns", "acceleration", "final_state", "final_turns", "outcome")
COSTS = ("stop_time", "block", "steps", "rejected", "evaluations")


def asked(count=13, method="vern9", times=(0.0, 4.0, 9.0, 20.0), **options):
    """Motions of different forces, of which the fifth starts with an angle of many turns."""
    found = []
    for k in range(count):
        damping, force, growth, reach = QUIET
        flow = duffing(damping, force + 0.02 * k, growth, reach)
        state = [0.1 * k - (600.0 if k == 5 else 0.0), 0.0]
        given = {"method": method, "rtol": 1e-9} | options
        found.append((flow, state, np.asarray(times) * (1 + 0.1 * k), given))
    return found


def require_equal(one, other):
    for name in PARTS:
        assert np.array_equal(getattr(one, name), getattr(other, name)), name
    for name in COSTS:
        assert getattr(one, name) == getattr(other, name), name


def together(motions, lanes, **options):
    requests = [request(flow, state, times, **given) for flow, state, times, given in motions]
    return integrate_many(requests, lanes, **options)


def alone(motions):
    return [integrate(flow, state, times, **given) for flow, state, times, given in motions]


@pytest.mark.slow_except("*-dop853", "4-*")
@pytest.mark.parametrize("method", ["dop853", "vern9", "tsit5"])
@pytest.mark.parametrize("lanes", [2, 4, 8, 16])
def test_lanes_have_the_bits_of_single_motions(method, lanes):
    motions = asked(method=method)
    expected = alone(motions)
    assert {found.outcome for found in expected} == {Outcome.DONE}
    assert expected[5].final_turns[0] != 0
    for one, other in zip(together(motions, lanes), expected, strict=True):
        require_equal(one, other)


def test_order_and_company_do_not_matter():
    motions = asked()
    expected = alone(motions)
    order = np.random.default_rng(1).permutation(len(motions))
    for part in (order, order[:3], order[4:]):
        found = together([motions[k] for k in part], 4)
        for place, one in zip(part, found, strict=True):
            require_equal(one, expected[place])


def test_motions_with_as_many_samples_as_they_like():
    """Those with equally many are set up together; lanes do not know."""
    motions = asked()
    for k, (flow, state, times, given) in enumerate(motions):
        motions[k] = flow, state, times[: 2 + k % 3], given
    for one, other in zip(together(motions, 4), alone(motions), strict=True):
        require_equal(one, other)


@pytest.mark.slow_except("1.0")
@pytest.mark.parametrize("backward", [1.0, -1.0])
def test_samples_are_taken_in_lanes(backward, caplog):
    """Several in each step, some at its end: no step is made alone."""
    times = backward * np.linspace(0.0, 20.0, 1001)
    motions = [
        (flow, state, times * (1 + 0.1 * k), given)
        for k, (flow, state, _, given) in enumerate(asked())
    ]
    expected = alone(motions)
    caplog.set_level("INFO", logger="linkages.solvers.lanes")
    for lanes in (4, 16):
        for one, other in zip(together(motions, lanes), expected, strict=True):
            require_equal(one, other)
    assert [message.endswith(" 0 steps alone") for message in caplog.messages] == [True, True]


def test_a_sample_that_cannot_be_evaluated_is_left_to_the_motion_alone():
    """At that time alone; no stage of a step comes that close to it."""
    (_, state, _, given), *others = asked()
    holed = duffing(*QUIET, without=5.0)
    assert integrate(holed, state, [0.0, 20.0], **given).outcome is Outcome.DONE
    motions = [(holed, state, [0.0, 4.9, 4.99, 5.0, 20.0], given), *others]
    expected = alone(motions)
    assert expected[0].outcome is Outcome.UNREACHABLE
    assert len(expected[0].time) == 3
    for one, other in zip(together(motions, 4), expected, strict=True):
        require_equal(one, other)


def test_motions_backward_in_time():
    motions = asked(times=(0.0, -1.0, -2.0))
    for one, other in zip(together(motions, 4), alone(motions), strict=True):
        require_equal(one, other)


def test_what_ends_a_motion_leaves_the_others_alone():
    motions = asked(method="dop853")
    flow, state, times, given = motions[2]
    motions[2] = (flow, state, times, given | {"max_steps": 7})
    motions[3] = (duffing(0.0, 0.0, 5.0, 1e200), [0.0, 1.0], times, given)  # v' = 5 v³ …
    motions[4] = (duffing(*QUIET[:3], 0.6), [0.1, 0.5], times, given)
    motions[6] = (duffing(*QUIET[:3], 0.2), [0.3, 0.0], times, given)  # cannot even begin
    motions[7] = (flow, state, [0.0], given)  # ends where it begins
    expected = alone(motions)
    ends = [found.outcome for found in expected]
    assert ends[2] is Outcome.STEP_BUDGET
    assert ends[3] in (Outcome.STEP_TOO_SMALL, Outcome.NOT_FINITE)
    assert ends[4] in (Outcome.SINGULAR, Outcome.UNREACHABLE)
    assert ends[6] is Outcome.UNREACHABLE
    for one, other in zip(together(motions, 4), expected, strict=True):
        require_equal(one, other)


def test_different_methods_and_functions_go_together():
    motions = [*asked(5, "dop853"), *asked(5, "vern9"), *asked(3, "rk4", step=0.05)]
    for one, other in zip(together(motions, 4), alone(motions), strict=True):
        require_equal(one, other)


def test_what_a_watch_raises_ends_all():
    """The motions would take minutes; the test ends as soon as the watch has been called."""

    class StopError(Exception):
        pass

    def watch(fraction):
        assert 0.0 <= fraction < 1.0
        raise StopError

    motions = asked(times=(0.0, 1e9))
    with pytest.raises(StopError):
        together(motions, 8, watch=watch)
