"""Cycles and chaos from section points alone, of maps whose motion is known."""

import numpy as np
import pytest

from linkages.chaos.recurrence import approached_cycle, find_cycle, points_left, separates

UNIT = np.array([1e-10])
LINE, CIRCLE = np.array([False]), np.array([True])


def followed(step, start, count, skip=0):
    state, points = np.atleast_1d(np.asarray(start, dtype=float)), []
    for _ in range(skip + count):
        state = np.atleast_1d(step(state))
        points.append(state)
    return np.array(points[skip:])


def logistic(r, count=400, skip=0):
    return followed(lambda x: r * x * (1 - x), 0.3, count, skip)


@pytest.mark.parametrize(
    ("r", "period"),
    # doublings at 3, 1 + √6 = 3.4495 and 3.5441; windows begin at 1 + √8 = 3.8284 and 3.7382
    [(2.8, 1), (2.9, 1), (3.2, 2), (3.4, 2), (3.5, 4), (3.55, 8), (3.835, 3), (3.7387, 5)],
)
def test_cycles_of_the_logistic_map(r, period):
    found = find_cycle(logistic(r), LINE, UNIT)
    assert found is not None
    assert found.count == period


def test_the_contraction_is_the_multiplier():
    """r (1 − 2 x*) = 2 − r at the fixed point x* = 1 − 1/r."""
    points = logistic(2.4, 80)
    first = next(n for n in range(10, 81) if find_cycle(points[:n], LINE, UNIT))
    assert find_cycle(points[:first], LINE, UNIT).contraction == pytest.approx(0.4, rel=1e-3)


@pytest.mark.parametrize("r", [3.59, 3.7, 3.9, 4.0])
def test_chaos_of_the_logistic_map(r):
    points = logistic(r, 100)
    assert find_cycle(points, LINE, UNIT) is None
    assert approached_cycle(points, LINE, UNIT) is None
    assert separates(points, LINE)


def test_chaos_in_two_dimensions():
    """Hénon's map, a = 1.4, b = 0.3: exponent 0.42 (M. Hénon, 1976)."""
    points = followed(lambda z: np.array([1 - 1.4 * z[0] ** 2 + z[1], 0.3 * z[0]]), [0, 0], 100, 20)
    both = np.array([False, False])
    assert separates(points, both)
    assert find_cycle(points, both, np.repeat(UNIT, 2)) is None


@pytest.mark.parametrize("K", [0.0, 0.5, 0.9])
def test_a_torus_is_neither(K):
    """Circle maps of the golden mean below K = 1 are conjugate to rotations: V. I. Arnold."""
    mean = (np.sqrt(5) - 1) / 2

    def step(angle):
        return (angle + 2 * np.pi * mean + K * np.sin(angle)) % (2 * np.pi)

    points = followed(step, 0.1, 200)
    assert find_cycle(points, CIRCLE, UNIT) is None
    assert approached_cycle(points, CIRCLE, UNIT) is None
    assert not separates(points, CIRCLE)


def test_angles_repeat_across_the_turn():
    points = (np.pi + 1e-3 * 0.5 ** np.arange(60.0)[:, None]) % (2 * np.pi)
    points = np.where(points > np.pi, points - 2 * np.pi, points)  # comes to ±π from −π
    assert find_cycle(points, CIRCLE, UNIT).count == 1
    points[::2] = -points[::2]
    assert find_cycle(points, CIRCLE, UNIT).count == 1
    assert find_cycle(points, LINE, UNIT).count == 2


@pytest.mark.parametrize("factor", [-0.999, -0.99, 0.99, 0.999])
def test_a_slow_approach_is_no_cycle(factor):
    """From alternating sides it looks like two points: these are 2 (1 − |μ|) as far apart in turn.

    The limit is decided only where distances have become errors.
    """
    points = factor ** np.arange(4000.0)[:, None]
    decided = [find_cycle(points[:n], LINE, UNIT) for n in range(20, 4001, 20)]
    counts = [found.count for found in decided if found is not None]
    assert set(counts) <= {1}
    for found, number in zip(decided, range(20, 4001, 20), strict=True):
        if found is not None:
            assert abs(points[number - 1, 0]) < 1e4 * UNIT[0]
    assert not separates(points[:200], LINE)


def test_what_doubles_at_once_is_not_decided():
    """At r = 3 the fixed point of the logistic map is reached like 1/√n, from alternating sides."""
    points = logistic(3.0, 3000)
    assert find_cycle(points, LINE, UNIT) is None
    assert approached_cycle(points[:400], LINE, UNIT) is None


def test_a_narrow_passage_is_no_cycle():
    """Below the window of three, laminar phases pass by points that almost repeat (type I)."""
    points = logistic(1 + np.sqrt(8) - 1e-6, 20_000)
    assert all(find_cycle(points[:n], LINE, UNIT) is None for n in range(20, 20_001, 37))


def test_a_steady_approach_is_told_before_it_ends():
    """Multipliers of 2 − r = −0.9 and, for the cycle of two, 1 − (r + 1)(r − 3) = 0.8156."""
    points = logistic(2.9, 100)
    found = approached_cycle(points, LINE, UNIT)
    assert find_cycle(points, LINE, UNIT) is None
    assert (found.count, found.contraction) == (1, pytest.approx(0.9, rel=1e-3))
    found = approached_cycle(logistic(3.045, 100), LINE, UNIT)
    assert (found.count, found.contraction) == (2, pytest.approx(1 - 4.045 * 0.045, rel=1e-2))


def test_points_left_are_those_of_the_contraction():
    points = 0.8 ** np.arange(200.0)[:, None]
    first = next(n for n in range(12, 200) if find_cycle(points[:n], LINE, UNIT))
    assert first - 30 <= points_left(points[:30], LINE, UNIT) <= first - 28
    assert points_left(logistic(4.0, 100), LINE, UNIT) > 0


def test_errors_of_the_integration_are_a_cycle_and_drift_is_none():
    noise = np.random.default_rng(1).uniform(-1, 1, (100, 1))
    assert find_cycle(100 * UNIT * noise, LINE, UNIT).count == 1
    assert find_cycle(100 * UNIT * noise + [[0.0], [1.0]] * 50, LINE, UNIT).count == 2
    drift = 100 * UNIT * np.arange(100.0)[:, None]
    assert find_cycle(drift, LINE, UNIT) is None
    assert find_cycle(np.full((100, 1), np.nan), LINE, UNIT) is None
    assert not separates(np.full((100, 1), np.inf), LINE)
