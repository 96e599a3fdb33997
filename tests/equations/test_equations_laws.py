"""Laws of time as symbolic expressions: values, derivatives, splines."""

import math

import numpy as np
import pytest
import sympy as sp
from printed_modules import module_of
from scipy.interpolate import CubicSpline

import linkages
from linkages.equations import derive
from linkages.equations.expressions import Select, Spline, exact
from linkages.topology.topology import build_topology

PENDULUM = """
joints: {{O: [0, 0]}}
bars: {{bar: {{joints: [O, tip], length: 1, mass: 2}}}}
drives: {{bar: {{law: {law}}}}}
"""

LAWS = {
    '"0.5 + 0.2*sin(2*t)"': lambda t: 0.5 + 0.2 * np.sin(2 * t),
    '"exp(-t)*sqrt(1 + t)/3 - t**4"': lambda t: np.exp(-t) * np.sqrt(1 + t) / 3 - t**4,
    '"tan(t/9) + atan(t) - tanh(t)*log(t + 2)"': lambda t: (
        np.tan(t / 9) + np.arctan(t) - np.tanh(t) * np.log(t + 2)
    ),
    '"asin(t/9)*cosh(t) - acos(t/9)*sinh(t/2)"': lambda t: (
        np.arcsin(t / 9) * np.cosh(t) - np.arccos(t / 9) * np.sinh(t / 2)
    ),
}
TIMES, VALUES = (0.2, 0.5, 1.1, 1.4, 2.0), (0.3, 1.0, -0.4, 0.7, 0.3)


def module_with(law):
    definition = linkages.loads(PENDULUM.format(law=law))
    return module_of(derive(build_topology(definition)))


def derivatives(module, time):
    return [
        float(module[name](time)[0]) for name in ("drives", "drive_rates", "drive_accelerations")
    ]


@pytest.mark.parametrize("law", LAWS)
def test_formula_and_its_derivatives(law):
    module = module_with(law)
    for t in (0.0, 0.3, 1.7):
        value, rate, acceleration = derivatives(module, t)
        step = 1e-3  # truncation of the fourth-order formulas 1e-12, rounding 1e-10
        f = [LAWS[law](t + n * step) for n in (-2, -1, 0, 1, 2)]
        assert value == pytest.approx(f[2], rel=1e-14)
        slope = (f[0] - 8 * f[1] + 8 * f[3] - f[4]) / (12 * step)
        assert rate == pytest.approx(slope, abs=1e-9)
        bend = (-f[0] + 16 * f[1] - 30 * f[2] + 16 * f[3] - f[4]) / (12 * step**2)
        assert acceleration == pytest.approx(bend, abs=1e-7)


@pytest.mark.parametrize("periodic", [False, True])
def test_table_is_a_cubic_spline(periodic):
    law = f"{{table: {{times: {list(TIMES)}, values: {list(VALUES)}, periodic: {periodic}}}}}"
    module = module_with(law.lower())
    spline = CubicSpline(TIMES, VALUES, bc_type="periodic" if periodic else "natural")
    for t in np.linspace(0.25, 1.95, 12):
        expected = [float(spline(t, order)) for order in range(3)]
        np.testing.assert_allclose(derivatives(module, t), expected, rtol=1e-12, atol=1e-12)
        if periodic:
            np.testing.assert_allclose(derivatives(module, t + 3.6), expected, atol=1e-12)
    if not periodic:
        for end, value in ((0.2, VALUES[0]), (2.0, VALUES[-1])):
            for beyond in (0.0, 0.7):
                t = end + beyond * np.sign(end - 1)
                slope = float(spline(end, 1))
                line = [value + slope * (t - end), slope, 0.0]
                np.testing.assert_allclose(derivatives(module, t), line, atol=1e-12)


def test_rise_is_constant_outside_and_smooth():
    module = module_with("{rise: cycloidal, from: 1, to: 3, begin: 1, duration: 2}")
    assert derivatives(module, 0.5) == [1.0, 0.0, 0.0]
    assert derivatives(module, 3.5) == [3.0, 0.0, 0.0]
    middle = derivatives(module, 2.0)
    np.testing.assert_allclose(middle, [2.0, 2.0, 0.0], atol=1e-14)  # speed 2·(to − from)/duration


def test_select_and_spline_have_derivatives():
    t = sp.Symbol("t", real=True)
    law = Select(t - 1, t**2, sp.sin(t))
    assert sp.diff(law, t) == Select(t - 1, 2 * t, sp.cos(t))
    assert Select(t, t, t) == t
    assert sp.diff(Spline(1, 0, 2 * t), t) == 2 * Spline(1, 1, 2 * t)


@pytest.mark.parametrize(
    ("value", "written"),
    [(3.0, "3"), (0.125, "1/8"), (2 * math.pi, "2*pi"), (4 * math.pi / 3, "4*pi/3"), (0.0, "0")],
)
def test_constants_are_written_as_people_do(value, written):
    assert str(exact(value)) == written


def test_other_constants_stay_as_they_are():
    assert float(exact(4 + math.pi)) == 4 + math.pi
