"""Functions of time and their derivatives: the absolute formulation's own arithmetic."""

import numpy as np
import pytest
from definition_entries import function
from scipy.interpolate import CubicSpline
from time_functions import jet

from linkages.components.contributed.functions import Table

CLOSE = {"rel": 1e-12, "abs": 1e-12}  # a few dozen roundings of numbers of order 1
FORMULAS = [
    "sin(2*t)*exp(-t)",
    "log(1 + t**3)/cos(t)",
    "tanh(t - 0.3)",
    "sqrt(t)*atan(3*t)",
    "asin(t/4)*cosh(t)",
    "sinh(t/2) - acos(t/5)",
]


@pytest.mark.parametrize("text", [*FORMULAS, "tan(t/2) - (t - 1)**2", "select(t - 2, t**2, t**3)"])
def test_derivatives_of_formulas(text):
    """Central differences of order 2 with Richardson's extrapolation."""
    formula, t, h = function((), text), 0.7, 2e-3
    value, first, second = jet(formula, t)

    def differences(h):
        low, high = (jet(formula, t + sign * h)[0] for sign in (-1, 1))
        return np.array([(high - low) / (2 * h), (high - 2 * value + low) / h**2])

    expected = (4 * differences(h / 2) - differences(h)) / 3
    # h⁴ f⁽⁶⁾/480 with f⁽⁶⁾ up to some hundreds, and round-off of 1e-16/h²
    assert [first, second] == pytest.approx(list(expected), abs=1e-9 * (1 + abs(second)))


def test_tables():
    times, values = (0.0, 0.5, 1.2, 2.0), (0.0, 1.0, -0.5, 0.0)
    open_ended, repeating = (Table((), times, values, periodic) for periodic in (False, True))
    assert jet(open_ended, 0.0)[2] == pytest.approx(0.0, abs=1e-14)
    after, slope, bend = jet(open_ended, 3.0)
    assert (after, bend) == (pytest.approx(slope, **CLOSE), 0.0)
    spline = CubicSpline(times, values, bc_type="periodic")
    for time in (-0.7, 0.3, 2.3):
        expected = [float(spline(time % 2.0, order)) for order in range(3)]
        assert jet(repeating, time) == pytest.approx(expected, **CLOSE)
