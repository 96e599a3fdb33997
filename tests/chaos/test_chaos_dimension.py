"""Correlation dimensions of sets with known ones.

Published values with their errors: J. C. Sprott, Chaos and Time-Series Analysis, Oxford 2003,
tables of common chaotic systems. Own values may differ from them by both errors together.
"""

import numpy as np
import pytest
from chaos_systems import henon, lorenz_rates, orbit, roessler_rates, samples

from linkages.chaos.indicators import correlation_dimension
from linkages.chaos.tori import embed

RANDOM = np.random.default_rng(11)


def agrees(found, published, error, precise=0.12):
    assert not found.doubt
    assert found.error < precise
    return abs(found.value - published) <= found.error + error


def test_henon():
    assert agrees(correlation_dimension(orbit(henon(), 6000, 1, 100)), 1.220, 0.036, 0.06)


@pytest.mark.slow
def test_lorenz():
    """Samples 0.3 apart, about half an oscillation; ten of them are decorrelated."""
    points = samples(lorenz_rates, [1.0, 1.0, 20.0], 0.3, 8000)
    assert agrees(correlation_dimension(points, theiler=10), 2.068, 0.086)


@pytest.mark.slow
def test_roessler():
    """Local slopes at the radii of 10 000 points are 1.8 to 1.9, level over two decades.

    They rise to the published 1.991 ± 0.065 only below, where no pairs are left. How far depends on
    the trajectory, and thus on the last bits of a processor's arithmetic.
    """
    found = correlation_dimension(samples(roessler_rates, [1.0, 1.0, 0.0], 1.7, 10000), theiler=5)
    assert not found.doubt
    assert found.error < 0.12
    assert 1.75 < found.value < 1.991 + 0.065


def test_circle_and_torus_of_angles():
    """Uniform points: only pairs are few, 200 of them scatter by 7 % over an octave."""
    circle = correlation_dimension(RANDOM.uniform(-np.pi, np.pi, 3000), angles=[True])
    assert circle.value == pytest.approx(1, abs=0.03)
    torus = RANDOM.uniform(-np.pi, np.pi, (4000, 2))
    assert correlation_dimension(torus, angles=[1, 1]).value == pytest.approx(2, abs=0.06)


def test_quasi_periodic_orbit_fills_a_torus():
    n = np.arange(6000)
    points = np.column_stack([n * np.sqrt(2), n * np.sqrt(3)])
    found = correlation_dimension(points, angles=[True, True])
    assert found.value == pytest.approx(2, abs=0.1)


@pytest.mark.slow_except("2")
@pytest.mark.parametrize("size", [1, 2, 3])
def test_white_noise_fills_its_space(size):
    """Edges of a cube lower slopes: by about r per dimension at radius r, at most a tenth."""
    found = correlation_dimension(RANDOM.uniform(size=(5000, size)))
    assert found.value == pytest.approx(size, rel=0.05)


def test_units_do_not_matter():
    points = orbit(henon(), 2000, 1, 100)
    found = correlation_dimension(points), correlation_dimension(points * [1e-6, 1e3])
    assert found[0].value == pytest.approx(found[1].value, abs=1e-9)


def test_theiler_window():
    """A slow walk along a line looks one-dimensional unless neighbours in time are left out."""
    points = 0.02 * np.cumsum(RANDOM.normal(size=(3000, 2)), axis=0) % 1.0 * 2 * np.pi
    near = correlation_dimension(points, angles=[1, 1]).value
    far = correlation_dimension(points, angles=[1, 1], theiler=300).value
    assert far == pytest.approx(2, abs=0.15)
    assert far >= near


def test_pairs_are_counted_right():
    points = RANDOM.normal(size=(500, 2))
    found = correlation_dimension(points)
    scaled = points / points.std(axis=0)
    apart = np.linalg.norm(scaled[:, None] - scaled, axis=2)[np.triu_indices(500, 1)]
    for number in (-40, -20):
        assert found.sums[number] == pytest.approx(np.mean(apart < found.radii[number]), abs=1e-12)


def test_periodic_points_have_dimension_zero():
    found = correlation_dimension(np.tile([0.0, 1.0, 3.0], 300))
    assert found.value == 0
    assert "finitely many" in found.doubt
    assert correlation_dimension(np.ones((600, 2))).value == 0


def test_angles_are_put_on_circles():
    # the third point gives the entries a spread of their own, by which they are divided
    low, high, _ = embed([[np.pi - 1e-9], [-np.pi + 1e-9], [0.0]], [True])
    np.testing.assert_allclose(low, high, atol=1e-8)


def test_arguments():
    with pytest.raises(ValueError, match="at least 500"):
        correlation_dimension(np.zeros(499))
    with pytest.raises(ValueError, match="at least 500"):
        correlation_dimension(np.zeros(600), theiler=200)
    with pytest.raises(ValueError, match="angles"):
        correlation_dimension(np.zeros((600, 2)), angles=[True])
