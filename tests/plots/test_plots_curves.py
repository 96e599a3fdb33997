import numpy as np
import pytest

from linkages.plots.motion.curves import peak_of


@pytest.mark.parametrize("offset", [0.0, 0.2, 0.5, 0.9])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_peak_of_a_smooth_curve_lies_between_samples(offset, sign):
    """A parabola through samples at −θ/2, θ/2 and 3θ/2 is off by Π|xᵢ|·|f‴|/6 ≤ θ⁴/32."""
    step = 2 * np.pi / 40
    time = step * (np.arange(-20, 20) + offset)
    peak = peak_of(time, sign * (1.5 * np.cos(time) + 0.5))
    assert peak.value == pytest.approx(sign * 2.0, abs=1.5 * step**4 / 32)
    assert peak.time == pytest.approx(0.0, abs=step**3 / 10)


@pytest.mark.parametrize(
    "values",
    [
        [0.0, 0.0, 0.0, 1.0, 0.99, 0.98, 0.97],  # a jump: a parabola would rise to 1.12
        [0.7, 0.8, 0.9, 1.0, 0.5, 0.0, -0.5],  # a corner
        [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0],  # a lone sample
        [0.0, 0.1, np.nan, 1.0, 0.9, 0.1, 0.0],
        [1.0, 0.9, 0.5, 0.1, 0.0, 0.0, 0.0],  # at the end
        [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0],
    ],
)
def test_peak_of_a_curve_that_is_not_smooth_is_a_sample(values):
    peak = peak_of(np.arange(7.0), np.array(values))
    assert peak[:2] == (float(np.nanargmax(values)), 1.0)


def test_a_load_that_steps_never_leaves_its_values():
    """A quartic through these samples rises to 40.01; what is joined by pchip stays at 40."""
    values = np.array([20.0, 40.0, 40.0, 40.0, 39.9, 39.0, 30.0])
    assert peak_of(np.arange(7.0), values).value > 40.0
    assert peak_of(np.arange(7.0), values, smooth=False)[:2] == (1.0, 40.0)


def test_peak_is_the_sample_farthest_from_zero():
    assert peak_of(np.arange(4.0), np.array([1.0, np.nan, -3.0, 2.0])) == (2.0, -3.0, False, "peak")
    assert peak_of(np.arange(2.0), np.full(2, np.nan)) is None
    assert peak_of(np.array([]), np.array([])) is None
