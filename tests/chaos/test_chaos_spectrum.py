"""Lines and broadband power of signals that are known."""

import numpy as np
import pytest
from chaos_systems import logistic, lorenz_rates, orbit, samples

from linkages.chaos.indicators import power_spectrum

STEP = 0.05
TIME = STEP * np.arange(8192)
FIRST, SECOND = 1.0, (np.sqrt(5) - 1) / 2


def two_frequencies():
    phases = 2 * np.pi * FIRST * TIME, 2 * np.pi * SECOND * TIME
    return (
        3.0
        + 2.0 * np.sin(phases[0])
        + 1.0 * np.cos(phases[1] + 0.3)
        + 0.4 * np.sin(phases[0] + phases[1])
        + 0.1 * np.sin(2 * phases[0] - phases[1])
        + 0.02 * np.sin(3 * phases[1])
    )


def test_lines_of_two_frequencies():
    """A parabola through three bins of the window finds a frequency to 0.05 bins."""
    found = power_spectrum(two_frequencies(), STEP)
    expected = [FIRST, SECOND, FIRST + SECOND, 2 * FIRST - SECOND, 3 * SECOND]
    np.testing.assert_allclose(found.lines, expected, atol=0.05 * found.resolution)
    np.testing.assert_allclose(found.powers, [2, 0.5, 0.08, 0.005, 0.0002], rtol=0.01)
    assert found.line_share == pytest.approx(1, abs=1e-4)


@pytest.mark.parametrize("seed", range(5))
def test_white_noise_has_no_lines_and_the_right_density(seed):
    """Density 2σ²Δt. One line in 1000 spectra is false; the close floor makes them rarer."""
    noise = np.random.default_rng(seed).normal(size=8192)
    found = power_spectrum(noise, STEP)
    assert len(found.lines) == 0
    assert found.line_share == 0
    assert found.density[1:].mean() == pytest.approx(2 * STEP, rel=0.1)  # 2000 independent bins


def test_line_in_noise():
    """A line with a twentieth of the power of noise: 100 times its density, known to 20 %."""
    noise = np.random.default_rng(7).normal(size=8192)
    found = power_spectrum(noise + np.sqrt(0.1) * np.sin(2 * np.pi * TIME), STEP)
    assert found.lines[0] == pytest.approx(1, abs=found.resolution)
    assert found.line_share == pytest.approx(0.05 / 1.05, rel=0.4)


def test_chaos_is_broadband():
    series = orbit(logistic(3.97), 8192, 1, 100)[:, 0]
    assert power_spectrum(series, 1.0).line_share < 0.05


@pytest.mark.slow
def test_lorenz_is_broadband():
    series = samples(lorenz_rates, [1.0, 1.0, 20.0], 0.1, 8192)[:, 0]
    assert power_spectrum(series, 0.1).line_share < 0.05


def test_arguments():
    with pytest.raises(ValueError, match="256"):
        power_spectrum(np.zeros(255), 1.0)
    with pytest.raises(ValueError, match="interval"):
        power_spectrum(np.zeros(256), 0.0)
    constant = power_spectrum(np.ones(256), 1.0)
    assert constant.line_share == 1
