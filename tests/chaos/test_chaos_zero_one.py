"""The 0–1 test: G. A. Gottwald, I. Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129."""

import numpy as np
import pytest
from chaos_systems import logistic, orbit

from linkages.chaos.indicators import zero_one

GOLDEN = (np.sqrt(5) - 1) / 2


@pytest.mark.parametrize(("r", "growth"), [(3.55, 0.0), (3.97, 1.0)])
def test_logistic_map(r, growth):
    """Published: K ≈ 0 and K ≈ 1; 100 frequencies leave a median of some thousandths."""
    found = zero_one(orbit(logistic(r), 5000, 1, 500)[:, 0])
    assert found.growth == pytest.approx(growth, abs=0.02)
    assert found.spread < 0.05


def test_displacement_against_its_definition():
    """One frequency by its definition as a double sum and the correlation method."""
    series = orbit(logistic(3.9), 400, 1, 100)[:, 0]
    c = np.random.default_rng(5).uniform(np.pi / 5, 4 * np.pi / 5, 1)[0]
    walk = np.cumsum(series * np.exp(1j * c * np.arange(1, 401)))
    lags = np.arange(1, 41)
    square = [np.mean([abs(walk[j + n] - walk[j]) ** 2 for j in range(360)]) for n in lags]
    square -= series.mean() ** 2 * (1 - np.cos(lags * c)) / (1 - np.cos(c))
    expected = np.corrcoef(lags, square)[0, 1]
    assert zero_one(series, frequencies=1, seed=5).values[0] == pytest.approx(expected, abs=1e-10)


def test_quasi_periodic_is_regular():
    n = np.arange(4000)
    found = zero_one(np.sin(2 * np.pi * GOLDEN * n) + 0.5 * np.sin(2 * np.sqrt(2) * n) + 1)
    assert abs(found.growth) < 0.1


def test_same_seed_same_answer():
    series = orbit(logistic(3.97), 400, 1)[:, 0]
    first, second = zero_one(series), zero_one(series)
    assert first.growth == second.growth
    assert zero_one(series, seed=1).values[0] != first.values[0]


@pytest.mark.parametrize(
    ("series", "message"),
    [
        (np.zeros(500), "constant"),
        (np.arange(100.0) % 2, "200 are needed"),
        (np.full(500, np.nan), "finite"),
    ],
)
def test_unusable_series(series, message):
    with pytest.raises(ValueError, match=message):
        zero_one(series)
