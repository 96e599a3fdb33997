"""What counts as predictable: three digits, against a run at a hundredth of the tolerance."""

import numpy as np
import pytest

import linkages

RTOL = 1e-6
THIRD_DIGIT = 0.0005
"""Half a unit in the third digit after the leading zero, in units of the amplitude."""


def states(solution):
    """Angles and speeds of both rods, shape (4, samples)."""
    data = solution.data
    return np.concatenate([data.bar_angle.to_numpy().T, data.bar_speed.to_numpy().T])


@pytest.fixture(scope="module")
def runs():
    found = linkages.load("double-pendulum")
    return [
        linkages.simulate(found, end=10.0, samples=2001, rtol=rtol)
        for rtol in (RTOL, RTOL / 100, RTOL / 1000)
    ]


def first_time_apart(one, other, by):
    """When two runs first differ by that part of the amplitude, which is half a turn at most."""
    own, better = states(one), states(other)
    amplitude = 0.5 * np.ptp(better, axis=1)
    amplitude[:2] = np.minimum(amplitude[:2], np.pi)
    apart = (np.abs(own - better) / amplitude[:, None]).max(axis=0)
    return float(one.data.time[int(np.argmax(apart > by)) - 1])


def test_three_digits_are_predictable_and_no_fewer(runs):
    """The last sample at which all agree to three digits; two digits would reach further."""
    horizon = runs[0].horizon
    assert not horizon.whole
    assert horizon.time == first_time_apart(runs[0], runs[1], THIRD_DIGIT)
    assert horizon.time < first_time_apart(runs[0], runs[1], 10 * THIRD_DIGIT)
    # the comparison run is good enough: one ten times tighter says nearly the same
    assert horizon.time == pytest.approx(first_time_apart(runs[0], runs[2], THIRD_DIGIT), abs=0.1)
