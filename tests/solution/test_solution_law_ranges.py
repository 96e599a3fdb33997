"""Ranges of laws against closed forms, and notes on tables that leave theirs."""

import numpy as np
import pytest
from solution_mechanisms import mechanism

import linkages
from linkages.components.contributed.functions import Number, Table
from linkages.components.contributed.terms import Parameter
from linkages.components.laws import function_of
from linkages.solution.remarks import doubts, law_range
from linkages.spec.formulas import formula

BAR = "joints: {O: [0, 0]}\nbars: {a: {joints: [O, A], length: 1, mass: 1}}\n"


@pytest.mark.parametrize(
    ("text", "end", "low", "high"),
    [
        ("3*sin(7*t) + 1", 2.0, -2.0, 4.0),
        ("t*(2 - t)", 3.0, -3.0, 1.0),
        ("t**2", -3.0, 0.0, 9.0),
        ("exp(-t)*sin(5*t)", 4.0, None, None),
        ("1/(t - 9)", 3.0, -1 / 6, -1 / 9),
        ("sqrt(1 - t)", 2.0, 0.0, 1.0),
    ],
)
def test_formulas(text, end, low, high):
    found = law_range(function_of(formula(text), ("loads", 0, "force")), end)
    if low is None:  # where tan 5t = 5: at peaks e^(−t)·5/√26
        first, second = np.arctan(5) / 5, (np.arctan(5) + np.pi) / 5
        low, high = -np.exp(-second) * 5 / 26**0.5, np.exp(-first) * 5 / 26**0.5
    # extremes are flat, and looked for to 1e-8 of the time; ends of a domain to that itself
    assert (found.low, found.high) == pytest.approx(
        (low, high), abs=2e-4 if "sqrt" in text else 1e-9
    )
    assert found.period is None


def test_constants_and_laws_without_values():
    assert law_range(Number(Parameter((), 3.0)), 1.0).high == 3.0
    assert np.isnan(law_range(function_of(formula("log(-1 - t)"), ()), 1.0).low)


def test_tables():
    """A cubic through (0, 0), (1, 1), (3, 0) bends over its value; outside the slope goes on."""
    table = Table((), (0.0, 1.0, 3.0), (0.0, 1.0, 0.0))
    found = law_range(table, 3.0)
    times = np.linspace(0, 3, 200_001)
    from scipy.interpolate import CubicSpline

    exact = CubicSpline(table.places, table.values, bc_type="natural")
    assert found.high == pytest.approx(exact(times).max(), rel=1e-9)  # the grid is that fine
    assert found.low == pytest.approx(0.0, abs=1e-15)
    assert law_range(table, 5.0).low == pytest.approx(2 * float(exact(3.0, 1)), rel=1e-12)
    assert law_range(table, 0.5).high == pytest.approx(float(exact(0.5)), rel=1e-12)


def test_a_periodic_table_shows_its_whole_period():
    table = Table((), (1.0, 2.0, 3.0), (0.0, 5.0, 0.0), True, "pchip")
    found = law_range(table, 0.1)
    assert (found.low, found.high, found.period) == (0.0, 5.0, 2.0)


SPLINE = "{table: {times: [0, 1, 1.1, 2], values: [0, 0, 1, 1], interpolation: INTERPOLATION}}"


@pytest.mark.parametrize(
    ("section", "interpolation", "found"),
    [
        ("drives: {a: {law: LAW}}", "spline", "drives.a.law.table: the spline leaves the range"),
        ("drives: {a: {law: LAW}}", "pchip", "drives.a: the acceleration of a table with 'pchip'"),
        ("free: {a: {angle: 0, speed: 0}}\nloads: [{bar: a, torque: LAW}]", "spline",
         "loads[0].torque.table: the spline leaves the range of its values by 1.8 N m, 184 %"),
        ("free: {a: {angle: 0, speed: 0}}\nloads: [{bar: a, torque: LAW}]", "pchip", None),
        ("free: {a: {angle: 0, speed: 0}}\nloads: [{bar: a, torque: LAW}]", "linear", None),
    ],
)  # fmt: skip
def test_notes(section, interpolation, found):
    """Simulations say it as well."""
    law = SPLINE.replace("INTERPOLATION", interpolation)
    made = mechanism(BAR, section.replace("LAW", law))
    notes = linkages.simulate(made, end=0.1, samples=3).notes
    assert tuple(doubts(made)) == notes
    assert [note[: len(found)] for note in notes] == [found] if found else not notes


def test_a_spline_through_a_smooth_curve_needs_no_note():
    """Between 61 samples of a cosine it exceeds them by up to (π/60)²/2 of its amplitude."""
    times = np.linspace(0, 1, 61)
    values = np.cos(2 * np.pi * (times - 0.5 / 60))
    rows = {"times": times.round(9).tolist(), "values": values.round(9).tolist()}
    assert not doubts(mechanism(BAR, f"drives: {{a: {{law: {{table: {rows}}}}}}}"))


def test_a_spline_within_its_values_needs_no_note():
    law = "{table: {times: [0, 1, 2, 3], values: [0, 1, 2, 3]}}"
    assert not doubts(mechanism(BAR, f"drives: {{a: {{law: {law}}}}}"))
