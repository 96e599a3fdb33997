"""Periods of section points."""

import numpy as np
import pytest
from chaos_systems import logistic, orbit, taylor_pendulum

from linkages.chaos.periods import find_period


@pytest.mark.slow
@pytest.mark.parametrize(
    ("doubling", "before"), [(1.0663, 1), (1.0793, 2), (1.0821, 4)], ids=["1→2", "2→4", "4→8"]
)
def test_driven_pendulum_doubles_its_period(doubling, before):
    """J. R. Taylor, Classical Mechanics, University Science Books 2005, table 12.1.

    0.0005 to either side; next to a doubling points part like a square root and transients are
    long, hence 300 periods before and a tolerance of 2e-3 rad and 2e-3 of the natural rate.
    """
    for strength, count in ((doubling - 5e-4, before), (doubling + 4e-4, 2 * before)):
        points = orbit(taylor_pendulum(strength), 48, 1.0, skip=300)
        found = find_period(points, angles=[True, False], tolerance=[2e-3, 2e-3 * 9.42])
        assert found.count == count, strength


@pytest.mark.parametrize(
    ("r", "count"), [(2.8, 1), (3.2, 2), (3.5, 4), (3.55, 8), (3.566, 16), (3.835, 3), (3.9, None)]
)
def test_logistic_map(r, count):
    """Windows of R. M. May, Nature 261 (1976) 459."""
    found = find_period(orbit(logistic(r), 96, 1, 3000), tolerance=1e-6)
    assert found.count == count
    assert (found.deviation <= 1) == (count is not None)
    assert len(found.cycle) == (count or 0)


def test_repetition():
    assert find_period(np.ones((9, 2))).count == 1
    assert find_period(np.tile([1.0, 2.0], 9)).count == 2
    assert find_period(np.arange(9.0)).count is None


def test_angles_repeat_modulo_a_turn():
    points = np.array([[np.pi - 1e-6, 1.0], [-np.pi + 1e-6, 1.0]] * 6)
    assert find_period(points, angles=[True, False]).count == 1
    assert find_period(points).count == 2
    turning = np.column_stack([2 * np.pi * np.arange(12.0), np.ones(12)])
    assert find_period(turning, angles=[True, False]).count == 1


def test_a_transient_does_not_repeat():
    decaying = 1 + 0.9 ** np.arange(60) * (-1.0) ** np.arange(60)
    assert find_period(decaying, tolerance=1e-6).count is None


def test_quasi_periodic_points_do_not_repeat():
    points = np.arange(90) * 2 * np.pi * (np.sqrt(5) - 1) / 2
    found = find_period(points, angles=[True], tolerance=1e-3)
    assert found.count is None
    # the best return within 30 is after 21: |21 ω - 13| turns
    assert found.deviation == pytest.approx(2e3 * np.pi * abs(21 * 0.6180339887 - 13), rel=1e-3)


def test_arguments():
    with pytest.raises(ValueError, match="periods from 1 to 2"):
        find_period(np.zeros(6), longest=3)
    with pytest.raises(ValueError, match="tolerance"):
        find_period(np.zeros(6), tolerance=0.0)


def test_differences_that_overflow_are_no_repetition():
    points = np.array([[1e308], [-1e308], [1.2e308]] * 2 + [[-1.5e308], [1e308], [-1e308]])
    assert find_period(points, tolerance=1e-4).count is None
