"""Permutation entropy: of series whose patterns are known, and of linkages."""

import math

import numpy as np
import pytest

import linkages
from linkages.analyses.entropy import permutation_entropy

DRIVEN = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 1, mass: 1}}
free: {rod: {angle: -1.3, speed: 0}}
dampers: [{joint: O, damping: DAMPING}]
loads: [{bar: rod, torque: {harmonic: {amplitude: AMPLITUDE, frequency: 0.4}}}]
simulate: {end: 1, samples: 11, rtol: 1e-8}
"""


def logistic(count):
    found = np.empty(count)
    value = 0.2345
    for k in range(count):
        found[k] = value = 4.0 * value * (1.0 - value)
    return found


def test_the_logistic_map_has_the_entropy_that_its_invariant_density_gives():
    """x ↦ 4x(1−x): three values in a row never fall twice; the patterns are intervals of the first.

    Where a pattern begins or ends two of the three values are equal: x = 1/4, (5 ± √5)/8, 3/4. The
    share of an interval is its invariant measure, (2/π) asin √x.
    """
    borders = [0.0, 0.25, (5 - math.sqrt(5)) / 8, 0.75, (5 + math.sqrt(5)) / 8, 1.0]
    shares = np.diff([2 / math.pi * math.asin(math.sqrt(x)) for x in borders])
    expected = -(shares * np.log(shares)).sum() / math.log(6)
    value, missing = permutation_entropy(logistic(200_000), 3)
    assert missing == 1
    assert value == pytest.approx(expected, abs=3e-3)  # shares of 200,000 points: 1/√200,000


@pytest.mark.parametrize("order", [2, 3, 4, 5])
def test_noise_has_all_patterns_equally_often(order):
    series = np.random.default_rng(1).normal(size=100_000)
    value, missing = permutation_entropy(series, order)
    assert missing == 0
    # the estimate is low by about (n! − 1)/2N, less than 1e-3 of ln n!
    assert value == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("period", [1, 2, 3, 5])
def test_a_periodic_series_has_a_pattern_per_point_of_its_period(period):
    """Equal values count as increasing, also if they differ by the error of an integration."""
    cycle = np.array([0.3, 0.9, 0.1, 0.7, 0.5])[:period]
    noise = 1e-9 * np.random.default_rng(2).normal(size=100 * period)
    value, missing = permutation_entropy(np.tile(cycle, 100) + noise, 4)
    assert missing == 24 - period
    # 100·period − 3 windows: the patterns are equally frequent up to one part in 100
    assert value == pytest.approx(math.log(period) / math.log(24), abs=1e-3)


def test_a_monotonic_series_has_one_pattern():
    assert permutation_entropy(np.arange(50.0), 3) == (0.0, 5)
    assert permutation_entropy(-np.arange(50.0), 3) == (0.0, 5)


@pytest.mark.slow
def test_regular_and_chaotic_linkages_differ():
    mild = linkages.loads(DRIVEN.replace("DAMPING", "2.0").replace("AMPLITUDE", "1.0"))
    wild = linkages.loads(DRIVEN.replace("DAMPING", "0.2").replace("AMPLITUDE", "6.0"))
    regular = linkages.entropy(mild, order=3, periods=40, skip=40)
    assert regular.entropy.item() == 0.0
    assert regular.missing.item() == 5
    chaotic = linkages.entropy(wild, order=3, periods=200, skip=50)
    assert chaotic.coordinate.to_numpy().tolist() == ["rod"]
    assert chaotic.entropy.item() > 0.8
    exponent = linkages.lyapunov(wild, periods=200, skip=50, count=1).exponent.to_numpy()[0]
    assert exponent > 0.1


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"order": 8}, "order must be from 2 to 7, found 8"),
        ({"order": 5, "periods": 500}, "order 5 needs at least 604 periods, found 500"),
    ],
)
def test_arguments_that_make_no_sense_are_named(given, message):
    with pytest.raises(ValueError, match=message):
        linkages.entropy(linkages.load("ninebar"), **given)
