import numpy as np
import pytest

from linkages.plots.style import Scale, axis_scale, scale_for, scale_of


@pytest.mark.parametrize(
    ("peak", "units", "expected"),
    [
        (7.8e-5, "m", Scale(1e6, "µm")),
        (0.029, "m/s", Scale(1e3, "mm/s")),
        (8.7, "m/s^2", Scale(1.0, "m/s²")),
        (0.1, "m", Scale(1.0, "m")),
        (1500.0, "N", Scale(1e-3, "kN")),
        (2.5e6, "N m", Scale(1e-6, "MN·m")),
        (0.05, "s", Scale(1e3, "ms")),
        (5000.0, "rad/s", Scale(1.0, "rad/s")),  # nobody reads kiloradians
        (2e4, "m", Scale(1.0, "m")),
        (0.0, "m", Scale(1.0, "m")),
        (1e-3, "furlong", Scale(1.0, "furlong")),
        (1e-3, "1", Scale(1.0, "")),
    ],
)
def test_prefix(peak, units, expected):
    found = scale_for(peak, units)
    assert found.units == expected.units
    assert found.factor == pytest.approx(expected.factor, rel=1e-15)


@pytest.mark.parametrize("power", range(-9, 12))
@pytest.mark.parametrize("units", ["J", "W"])
def test_largest_number_on_an_axis_is_from_a_tenth_to_a_thousand(power, units):
    for peak in (1.0, 3.3, 9.99):
        shown = peak * 10.0**power * scale_for(peak * 10.0**power, units).factor
        assert 0.1 <= shown < 1000.0 * (1 + 1e-12)  # a product of two rounded powers of ten


def test_values_that_are_not_finite_are_passed_over():
    assert scale_of([np.nan, 2e-3, np.inf], "m").units == "mm"
    assert scale_of([], "m").units == "m"


def test_label_has_units_in_brackets():
    assert scale_for(8e-5, "m").label("displacement error") == "displacement error [µm]"
    assert scale_for(1.0, "").label("ratio") == "ratio"


def test_value_in_words():
    assert scale_for(8e-5, "m").text(-7.8061e-5) == "−78.06 µm"


def test_large_values_without_a_prefix_have_a_power_of_ten():
    scale = axis_scale([-3.273e5], "m/s^2")
    assert (scale.factor, scale.units) == (pytest.approx(1e-3), "10³ m/s²")
    assert scale.text(-3.273e5) == "−327.3·10³ m/s²"
    assert axis_scale([9e3], "m/s^2").units == "m/s²"
    assert axis_scale([2e4], "N").units == "kN"
    assert axis_scale([np.pi], "rad") == Scale(180 / np.pi, "°")
