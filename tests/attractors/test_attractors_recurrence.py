"""Cycles out of section points, against sequences whose limits are known."""

import numpy as np
import pytest

from linkages.attractors.convergence import recurrence, remaining

UNIT = np.full(2, 1e-5)
NO, ONE = np.zeros(2, dtype=bool), np.array([True, False])


def found(points, angles=NO, longest=16):
    return recurrence(np.asarray(points), angles, UNIT, noise=1e-3, longest=longest)


def spiral(modulus, turn, count, about=(0.3, -0.2)):
    """Points of a linear map with a pair of multipliers, about a fixed point."""
    values = 0.1 * (modulus * np.exp(1j * turn)) ** np.arange(count)
    return np.column_stack([values.real, values.imag]) + about


@pytest.mark.parametrize("modulus", [0.3, 0.8, 0.95, 0.99])
@pytest.mark.parametrize("turn", [0.0, 0.1, 2 * np.pi / 3, 2.0, np.pi])
def test_a_spiral_is_a_cycle_of_one_point_as_soon_as_it_is_within_a_unit(modulus, turn):
    """Never before, whatever the multipliers: 1e4 units away at the start."""
    for count in range(17, 2000, 5):
        result = found(spiral(modulus, turn, count))
        away = 1e4 * modulus ** (count - 1)
        if result is not None:
            assert result.count == 1
            assert away <= 1.5
            return
        assert away > 1e-3  # four points of a unit away at the latest, plus what windows cost
    pytest.fail("no cycle")


def test_slow_convergence_is_not_taken_for_a_cycle():
    """Steps are below the unit, what is left of them is not."""
    points = spiral(0.9999, 0.0, 800)
    assert np.abs(np.diff(points[:, 0])).max() < 1.01 * UNIT[0]
    assert found(points) is None


@pytest.mark.parametrize("count", [2, 3, 5, 12])
def test_the_points_of_a_cycle_are_counted(count):
    places = np.random.default_rng(count).uniform(-1, 1, (count, 2))
    points = places[np.arange(150) % count] + 1e-3 * 0.7 ** np.arange(150)[:, None]
    assert found(points).count == count


def test_a_cycle_longer_than_asked_for_is_none():
    places = np.random.default_rng(1).uniform(-1, 1, (12, 2))
    assert found(places[np.arange(200) % 12], longest=11) is None


def test_a_small_splitting_that_stays_is_two_points():
    """Of ten units: the difference of neighbours is constant and does not shrink."""
    points = np.column_stack([1e-4 * (-1.0) ** np.arange(60), np.zeros(60)])
    assert found(points).count == 2


def test_points_on_a_circle_are_no_cycle():
    """The golden section: the worst to approximate, and the most a torus can look like a cycle."""
    turn = np.pi * (np.sqrt(5) - 1)
    assert found(spiral(1.0, turn, 900)) is None


def test_angles_repeat_after_turns():
    points = np.column_stack([2 * np.pi * np.arange(40.0), np.ones(40)])
    assert found(points) is None
    assert found(points, ONE).count == 1


def test_what_remains_is_the_sum_of_a_geometric_series():
    """1/2 + 1/4 + … of the last step; where steps do not shrink nothing is known."""
    assert remaining(1.0, 2.0, 1.0) == pytest.approx(1.0)
    assert remaining(1.0, 8.0, 3.0) == pytest.approx(1.0)
    assert remaining(1.0, 1.0, 1.0) == np.inf
    assert remaining(0.0, 0.0, 1.0) == 0.0
