"""Lyapunov spectra against published values.

Values and their last digits are those of J. C. Sprott, Chaos and Time-Series Analysis, Oxford
2003 (tables of common chaotic systems); Duffing's are from the discussion of exponents of
stroboscopic maps in ChaosTools.jl. Own values may differ by 3.5 of their standard errors (one
false alarm in 2000 per value) and half a unit of the last digit printed. Errors are bounded as
well: without that, nothing could fail.
"""

import math

import numpy as np
import pytest
from chaos_systems import (
    duffing,
    henon,
    henon_heiles,
    logistic,
    lorenz,
    roessler,
    sprott_pendulum,
)
from make.verdicts.own_systems import Map, Ode

from linkages.chaos.averages import mean_error
from linkages.chaos.exponents import Exponents, lyapunov_spectrum
from linkages.chaos.lyapunov import pair_sums

TURN = 2 * math.pi


@pytest.mark.slow
@pytest.mark.parametrize(
    ("system", "interval", "intervals", "published", "digit", "precise"),
    [
        (lorenz(), 0.5, 1500, [0.9056, 0, -14.5723], 5e-5, 0.02),
        (roessler(), 0.5, 4000, [0.0714, 0, -5.3943], 5e-5, 0.06),
        (sprott_pendulum(), 1.5 * TURN, 500, [0.16, 0, -0.42], 5e-3, 0.015),
        (duffing(), TURN, 500, [0.1589, -0.3589], 5e-5, 0.015),
    ],
    ids=["lorenz", "roessler", "pendulum", "duffing"],
)
def test_published_flows(system, interval, intervals, published, digit, precise):
    found = lyapunov_spectrum(system, interval=interval, intervals=intervals, skip=40)
    assert found.errors.max() < precise
    assert found.errors[0] < 0.015
    np.testing.assert_array_less(np.abs(found.values - published), 3.5 * found.errors + digit)
    assert found.settled, found.unsettled


@pytest.mark.slow
def test_henon_map():
    found = lyapunov_spectrum(henon(), interval=1, intervals=10000, skip=100)
    assert found.errors.max() < 0.005
    np.testing.assert_array_less(abs(found.values - [0.41922, -1.62319]), 3.5 * found.errors + 5e-6)
    total, _ = found.sum
    assert total == pytest.approx(math.log(0.3), abs=1e-12)  # the determinant is -0.3 everywhere
    assert found.settled, found.unsettled


def test_logistic_map_has_ln_2():
    found = lyapunov_spectrum(logistic(4.0), interval=1, intervals=8192, skip=100)
    assert found.errors[0] < 2e-3
    assert abs(found.values[0] - math.log(2)) < 3.5 * found.errors[0]


@pytest.mark.slow
def test_standard_error_against_the_scatter_of_runs():
    """Twelve runs scatter by their error; a standard deviation of 12 is within 0.5 to 1.6 of it."""
    runs = [
        lyapunov_spectrum(
            Map(lambda x: (1 - 1.4 * x[0] ** 2 + x[1], 0.3 * x[0]),
                lambda x: ((-2.8 * x[0], 1.0), (0.3, 0.0)), [0.1 + 0.01 * k, 0.1]),
            interval=1, intervals=1024, skip=50,
        )
        for k in range(12)
    ]  # fmt: skip
    scatter = np.std([run.values[0] for run in runs], ddof=1)
    stated = np.mean([run.errors[0] for run in runs])
    assert 0.5 < scatter / stated < 1.6


def test_linear_system_has_the_real_parts_of_its_eigenvalues():
    matrix = np.array([[-0.1, 2.0, 0.3], [-2.0, -0.1, 0.1], [0.0, 0.0, -1.0]])
    system = Ode(lambda _, y: matrix @ y, lambda *_: matrix, [0.0, 0.0, 0.0])
    found = lyapunov_spectrum(system, interval=math.pi / 4, intervals=128, skip=40)
    np.testing.assert_allclose(found.values, [-0.1, -0.1, -1.0], atol=1e-3)
    assert found.sum[0] == pytest.approx(-1.2, abs=1e-7)


def test_largest_ones_agree_with_the_whole_spectrum():
    """Along one motion; different starts of directions are forgotten like e^(-2 n)."""
    whole = lyapunov_spectrum(henon(), interval=1, intervals=64, skip=50)
    one = lyapunov_spectrum(henon(), interval=1, intervals=64, skip=50, count=1)
    np.testing.assert_allclose(one.growth[:, 0], whole.growth[:, 0], atol=1e-10)


@pytest.mark.parametrize(("system", "interval"), [(lorenz(), 0.5), (duffing(), TURN / 8)])
def test_sum_is_the_mean_divergence(system, interval):
    divergence = {3: -41 / 3, 2: -0.2}[len(system.state)]
    found = lyapunov_spectrum(system, interval=interval, intervals=64)
    # tolerance 1e-7 times the ratio of tangents, averaged
    assert found.sum[0] == pytest.approx(divergence, abs=1e-5)


def test_divergence_that_varies():
    """Rössler: a - c + x, averaged by trapezoids over 0.1; the record is the same for both."""
    found = lyapunov_spectrum(roessler(), interval=0.1, intervals=400, skip=20)
    values = 0.2 - 5.7 + found.states[:, 0]
    gaps = found.growth.sum(axis=1) - 0.5 * (values[:-1] + values[1:])
    assert abs(gaps.mean()) < 1e-3
    assert mean_error(gaps)[0][0] < 1e-2


@pytest.mark.slow
def test_hamiltonian_pairs_vanish_along_chaos():
    """Once directions have been found, frames are symplectic and only the tolerance is left.

    That of a step is 1e-9; ratios of tangents of e^(0.5 · 5) and 20 steps an interval add to it.
    """
    orbit = henon_heiles(1 / 6 - 1e-3, -0.1, 0.1)
    found = lyapunov_spectrum(orbit, interval=5.0, intervals=150, skip=100)
    sums, errors = pair_sums(found)
    assert (np.abs(sums) < 1e-4).all()
    assert (np.abs(sums) < 4 * errors + 1e-7).all()
    assert abs(found.sum[0]) < 1e-7
    assert found.values[0] > 0.05
    with pytest.raises(ValueError, match="whole spectrum"):
        pair_sums(lyapunov_spectrum(henon(), interval=1, intervals=64, count=1))


@pytest.mark.slow
def test_regular_orbit_falls_like_one_over_time():
    """λ(t) = ln(1 + c t) / t: ten times the time leaves 1/10 to 1/5 of it, chaos all of it."""
    found = lyapunov_spectrum(henon_heiles(1 / 12, 0.3), interval=5.0, intervals=640, count=1)
    fall = found.history[639, 0] / found.history[63, 0]
    assert 0.08 < fall < 0.25
    assert not found.settled
    assert "Exponent 1 drifts" in found.unsettled


def test_sticking_is_seen():
    """Halfway from regular to chaotic: a map whose parameter steps stands for an orbit that
    sticks near regular ones and then leaves them."""

    def switching(x):
        return (((3.7 if x[1] > 500 else 4.0) * x[0] * (1 - x[0])), x[1] + 1)

    def jacobian(x):
        return ((((3.7 if x[1] > 500 else 4.0) * (1 - 2 * x[0])), 0.0), (0.0, 1.0))

    found = lyapunov_spectrum(Map(switching, jacobian, [0.3, 0.0]), interval=1, intervals=2000)
    assert not found.settled


@pytest.mark.slow
def test_intervals_that_are_too_long_are_seen():
    found = lyapunov_spectrum(lorenz(1e-6), interval=2.0, intervals=64)
    assert "take shorter intervals" in found.unsettled


def test_watch_and_arguments():
    fractions = []
    lyapunov_spectrum(henon(), interval=1, intervals=64, skip=16, watch=fractions.append)
    assert fractions[-1] == 1
    assert all(np.diff(fractions) > 0)
    for wrong in ({"intervals": 63}, {"count": 3}, {"count": 0}, {"interval": 0}, {"skip": -1}):
        with pytest.raises(ValueError, match="must be"):
            lyapunov_spectrum(henon(), **({"interval": 1, "intervals": 64} | wrong))


def test_system_built_for_another_number_of_tangents():
    class Fixed(Map):
        @property
        def tangents(self):
            return self._tangents.copy()

        @tangents.setter
        def tangents(self, values):
            if self._tangents.shape[1] == 0:
                self._tangents = np.ones((2, 1))
            self._tangents[:] = values

    system = Fixed(henon()._function, henon()._jacobian, [0.1, 0.1])
    with pytest.raises(ValueError, match="carries 1 tangents, 2 are needed"):
        lyapunov_spectrum(system, interval=1, intervals=64)


def stepped(errors, seed):
    """Noise whose first quarter is higher by so many standard errors of a quarter."""
    growth = np.random.default_rng(seed).normal(size=(4096, 1))
    growth[:1024] += errors / 32
    return Exponents(growth, np.zeros((4097, 1)), np.arange(4097.0))


@pytest.mark.parametrize("seed", range(6))
def test_a_drift_is_what_exceeds_six_errors(seed):
    """Means of quarters scatter by one error each, and errors are 0 to 20 % too large."""
    assert stepped(0, seed).settled
    assert stepped(2, seed).settled
    assert not stepped(12, seed).settled


@pytest.mark.parametrize(("ratio", "known"), [(1e8, True), (1e10, False)])
def test_tangents_that_come_too_far_apart(ratio, known):
    """Of numbers of 16 digits one has seven left where another is 1e9 times as large."""
    growth = np.tile([math.log(ratio), 0.0], (64, 1))
    found = Exponents(growth, np.zeros((65, 2)), np.arange(65.0), furthest=1e9)
    assert found.settled is known
