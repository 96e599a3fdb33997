"""Laws of time: their values against closed forms, their smoothness, and what they refuse."""

import math

import pytest
from component_reading import complaints, component
from hypothesis import given
from hypothesis import strategies as st
from law_values import parameters, value

from linkages.components.contributed.functions import Number, Operation, Table
from linkages.components.contributed.terms import Parameter
from linkages.components.laws import PROFILES, AngleLaw, function_of
from linkages.spec.formulas import formula

CRANK = "joints: {O: [0, 0]}\nbars: {crank: {joints: [O, A], length: 0.3}}\ndrives:\n"
PATH = ("drives", "crank", "law")


def law(text):
    (term,) = component(CRANK + f"  crank: {{law: {text}}}\n", "drives", "crank").terms()
    return term.law


def refusals(text):
    return complaints(CRANK + f"  crank: {{law: {text}}}\n")


def derivative(function, t, order, h=1e-3):
    """By central differences; their error is of the order of h² and of round-off/h^order."""
    if order == 0:
        return value(function, t)
    later, earlier = (derivative(function, t + s * h / 2, order - 1, h) for s in (1, -1))
    return (later - earlier) / h


@pytest.mark.parametrize(
    ("text", "expected"),
    [("0", 0.0), ("30 deg", math.radians(30)), ("-1.5*pi", -1.5 * math.pi), ("2", 2.0)],
)
def test_a_quantity_is_a_constant(text, expected):
    assert law(text) == Number(Parameter(PATH, pytest.approx(expected), structural=True))


@given(st.floats(-3, 3))
@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0.5 + 0.2*sin(2*t)", lambda t: 0.5 + 0.2 * math.sin(2 * t)),
        ("100*(t - 1)**2", lambda t: 100 * (t - 1) ** 2),
        ("-t**3/7", lambda t: -(t**3) / 7),
        ("(t + 9)**-2", lambda t: (t + 9) ** -2),
        ("exp(-t)*cos(pi*t)", lambda t: math.exp(-t) * math.cos(math.pi * t)),
        ("tanh(t)/tan(1)", lambda t: math.tanh(t) / math.tan(1)),
        ("abs(t - 1)", lambda t: abs(t - 1)),
        ("min(t, 1) + 2*max(t, -1)", lambda t: min(t, 1) + 2 * max(t, -1)),
        ("sqrt(t + 4) + log(t + 4)", lambda t: math.sqrt(t + 4) + math.log(t + 4)),
        ("atan(t)", math.atan),
        ("asin(t/4) + 2*acos(t/4)", lambda t: math.asin(t / 4) + 2 * math.acos(t / 4)),
        ("sinh(t)/cosh(t)", math.tanh),
    ],
)  # fmt: skip
def test_formula(text, expected, t):
    function = function_of(formula(text), PATH)
    # a few roundings of terms of at most 1600
    assert value(function, t) == pytest.approx(expected(t), rel=1e-13, abs=1e-13)


def test_numbers_of_a_formula_are_arguments_in_their_order():
    found = parameters(function_of(formula("2*pi*t + 3*sin(t/4)**2 - sqrt(4)"), PATH))
    assert [p.path for p in found] == [(*PATH, place) for place in range(4)]
    # what consists of numbers alone is one number; the exponent belongs to the formula
    assert [p.value for p in found] == [2 * math.pi, 3.0, 4.0, 2.0]


def test_a_repeated_part_keeps_its_numbers():
    function = function_of(formula("abs(3*t)"), PATH)
    assert parameters(function) == [Parameter((*PATH, 0), 3.0, structural=True)]


def test_formulas_of_equal_structure_differ_in_arguments_only():
    def structure(function):
        if isinstance(function, Operation):
            return function.name, *map(structure, function.arguments)
        return type(function).__name__, getattr(function, "parameter", Parameter((), 0)).path

    first, second = (function_of(formula(text), PATH) for text in ("2*sin(3*t)", "-5*sin(0*t)"))
    assert structure(first) == structure(second)


@pytest.mark.parametrize("frequency", ["frequency: 2 Hz", "angular_frequency: 120 rpm"])
def test_harmonic(frequency):
    function = law(f"{{harmonic: {{mean: 1, amplitude: 20 deg, {frequency}, phase: 30 deg}}}}")
    for t in (-0.3, 0.0, 0.7):
        expected = 1 + math.radians(20) * math.sin(4 * math.pi * t + math.pi / 6)
        assert value(function, t) == pytest.approx(expected, rel=1e-14)
    assert {p.path[-1] for p in parameters(function)} == {
        "mean", "amplitude", frequency.split(":")[0], "phase",
    }  # fmt: skip
    assert all(p.path[:-1] == (*PATH, "harmonic") for p in parameters(function))


@pytest.mark.parametrize(
    ("inside", "found"),
    [("", "found neither"), (", frequency: 1, angular_frequency: 1", "found both")],
)
def test_one_frequency(inside, found):
    (problem,) = refusals(f"{{harmonic: {{amplitude: 1{inside}}}}}")
    assert (
        "drives.crank.law.harmonic: expected either 'frequency' or 'angular_frequency'" in problem
    )
    assert problem.endswith(found)


@pytest.mark.parametrize("profile", PROFILES)
def test_rise(profile):
    function = law(f"{{rise: {profile}, from: 1, to: 3, begin: 2 s, duration: 4 s}}")
    assert [value(function, t) for t in (-1, 2, 6, 10)] == pytest.approx([1, 1, 3, 3], abs=1e-15)
    assert value(function, 4) == pytest.approx(2, abs=1e-15)  # symmetric about the middle
    between = [value(function, 2 + 0.04 * k) for k in range(101)]
    assert between == sorted(between)


# peak velocity and acceleration of a unit rise in unit time, as tables of cam factors print them;
# those of the harmonic rise are π/2 and π²/2
FACTORS = {
    "cycloidal": (2.000, 6.283),
    "modified-sine": (1.760, 5.528),
    "polynomial": (1.875, 5.774),
    "harmonic": (1.5708, 4.9348),
}


@pytest.mark.slow_except("cycloidal")
@pytest.mark.parametrize("profile", PROFILES)
def test_peaks_are_those_of_the_tables(profile):
    function = law(f"{{rise: {profile}, to: 1, duration: 1}}")
    # harmonic has its peak acceleration at the ends: stay inside by the width of the difference
    times = [0.002 + 0.996 * k / 2000 for k in range(2001)]
    velocity = max(derivative(function, t, 1) for t in times)
    acceleration = max(derivative(function, t, 2) for t in times)
    # the table has four digits; the harmonic one stops 0.002 short of its peak, which is flat
    assert (velocity, acceleration) == pytest.approx(FACTORS[profile], rel=4e-4)


@pytest.mark.parametrize(
    ("text", "breaks"),
    [
        ("{rise: cycloidal, to: 1, duration: 1}", (0, 1)),
        ("{rise: polynomial, to: 1, duration: 1}", (0, 1)),
        ("{rise: modified-sine, to: 1, duration: 1}", (0, 0.125, 0.875, 1)),
        ("{run-up: {speed: 1, duration: 1}}", (0, 1)),
    ],
)
@pytest.mark.parametrize("order", [0, 1, 2])
def test_two_continuous_derivatives(text, breaks, order):
    function = law(text)
    # Jerks are at most 60, so over 4e-3 the acceleration changes by at most 0.24; a jump of the
    # smallest peak acceleration among these laws, 1.5, would show.
    for place in breaks:
        before, after = (derivative(function, place + s * 2e-3, order) for s in (-1, 1))
        assert abs(after - before) < 0.25


def test_the_harmonic_rise_has_a_jump_where_others_have_none():
    function = law("{rise: harmonic, to: 1, duration: 1}")
    before, after = (derivative(function, s * 2e-3, 2) for s in (-1, 1))
    assert after - before == pytest.approx(math.pi**2 / 2, rel=1e-3)


def test_run_up():
    function = law("{run-up: {speed: 60 rpm, duration: 500 ms, from: 1}}")
    omega = 2 * math.pi
    assert [value(function, t) for t in (-2.0, 0.0)] == [1, 1]
    assert value(function, 0.5) == pytest.approx(1 + omega * 0.25, rel=1e-15)
    assert value(function, 2.5) - value(function, 1.5) == pytest.approx(omega, rel=1e-14)
    # at half the time the speed is half of what it becomes
    assert derivative(function, 0.25, 1) == pytest.approx(omega / 2, rel=1e-5)


def test_table():
    text = "{table: {times: [0, 500 ms, 2], values: [0, 90 deg, 0], periodic: true}}"
    assert law(text) == Table((*PATH, "table"), (0.0, 0.5, 2.0), (0.0, math.pi / 2, 0.0), True)


@pytest.mark.parametrize(
    ("inside", "found"),
    [
        ("times: [0, 1], values: [0, 1]", "expected at least three times, found 2"),
        ("times: [0, 1, 2], values: [0, 1]", "found 3 times and 2 values"),
        ("times: [0, 2, 1], values: [0, 1, 2]", "expected increasing times, found 1 after 2"),
        ("times: [0, 1, 1], values: [0, 1, 2]", "expected increasing times, found 1 after 1"),
        (
            "times: [0, 1, 2], values: [0, 1, 2], periodic: true",
            "expected the same first and last value of a periodic table, found 0 and 2",
        ),
    ],
)
def test_tables_that_are_none(inside, found):
    (problem,) = refusals(f"{{table: {{{inside}}}}}")
    assert problem.startswith("line 4, column 17, drives.crank.law.table: expected ")
    assert problem.endswith(found)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        (
            "5 N",
            "drives.crank.law: expected an angle (radians, or with a unit), a formula of t, or a "
            "law (harmonic, rise, run-up or table), found '5 N': N is a force, not an angle",
        ),
        ("sine(t)", "found 'sine(t)': unknown function 'sine' (character 1); did you mean 'sin'?"),
        (
            "2*x*t",
            "unknown name 'x'; expected t, pi, or a quantity such as crank.angle (character 3 of",
        ),
        ("20 dgree*sin(t)", "unknown unit 'dgree'; did you mean 'degree'? (character 4)"),
        (
            "20 deg*sin(t)",
            "expected an angle (rad), found '20 deg*sin(t)': 'sin' takes an angle or a pure "
            "number, found a time (s) in 'sin(t)'; multiply it by a rate, such as 2 rad/s (char",
        ),
        ("20 deg*sin(crank.angle)", "'crank.angle' is refused (character 12): a drive prescribes"),
        ("{rose: cycloidal}", "found a mapping with 'rose'; did you mean 'rise'?"),
        (
            "{rise: cycloidal, harmonic: {}}",
            "a mapping with 'rise' and 'harmonic'; expected one of them",
        ),
        (
            "{rise: cycloidel, to: 1, duration: 1}",
            "law.rise: expected 'cycloidal', 'modified-sine', 'polynomial' or 'harmonic', "
            "found 'cycloidel'; did you mean 'cycloidal'?",
        ),
        (
            "{rise: cycloidal, to: 1 N, duration: 1}",
            "law.to: expected an angle (radians, or with a unit), found '1 N': N is a force",
        ),
        ("{rise: cycloidal, to: 1, duration: 0}", "law.duration: expected a time > 0"),
        ("{rise: cycloidal, to: 1}", "law: missing key 'duration': expected a time > 0"),
        (
            "{harmonic: {amplitud: 1, frequency: 1, amplitude: 1}}",
            "law.harmonic.amplitud: unknown key 'amplitud'; did you mean 'amplitude'?",
        ),
        ("{run-up: {speed: 1 Hz, duration: 1}}", "law.run-up.speed: expected an angular speed"),
        (
            "{table: {times: [0, 1, 2], values: [0, 1 N, 2]}}",
            "law.table.values[1]: expected an angle",
        ),
    ],
)
def test_what_is_no_law(text, found):
    (problem,) = refusals(text)
    assert found in problem


def test_described_for_editors():
    from pydantic import TypeAdapter

    schema = TypeAdapter(AngleLaw).json_schema()
    assert schema["description"].startswith("an angle (radians, or with a unit), a formula of t")
    assert schema["type"] == ["number", "string", "object"]
