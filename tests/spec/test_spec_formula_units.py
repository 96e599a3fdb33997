"""Units in formulas: where they end, what they scale, and what goes together."""

import math

import pytest

from linkages.spec.formulas import (
    Call,
    Clock,
    Constant,
    described,
    formula,
    measured,
    powers,
    require,
)
from linkages.spec.grammar import NumberError
from linkages.spec.units import FORCE, unit

UNITS = {"position": "m", "velocity": "m/s", "angle": "rad", "speed": "rad/s", "distance": "m"}


def unit_of(quantity):
    return UNITS[quantity.word]


def powers_of(node):
    return powers(unit(unit_of(node)))


def numbers(text):
    return [node.value for node in formula(text).nodes() if isinstance(node, Constant)]


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("30 kN*t", [30e3]),
        ("20 N*s/m * p.velocity", [20.0]),
        ("20 N s/m*p.velocity", [20.0]),
        ("20 N·s/m*p.velocity", [20.0]),
        ("2 N*m*t - 3 N*m.angle", [2.0, 3.0]),  # a bar that is called m
        ("5 N*min(t, 2 s)", [5.0, 2.0]),
        ("2 mm**2*t", [2e-6]),
        ("2 mm²*t + 3 m^2*t", [2e-6, 3.0]),
        ("60 rpm*t", [2 * math.pi]),
        ("3 1/s*t", [3.0]),
        ("5 N/(2 cm)*p.position", [5.0, 0.02]),
        ("5 N/2*t", [5.0, 2.0]),
        ("1e3 N*t", [1e3]),
        ("3 N*pi*t", [3.0, math.pi]),
        ("90 deg*t", [math.pi / 2]),
    ],
)
def test_numbers_are_si_and_units_end_where_they_end(text, values):
    assert numbers(text) == pytest.approx(values, rel=1e-15)


def test_a_unit_belongs_to_its_number_alone():
    """As in 1/(2 kN): a quantity without anything else is read as arithmetic with one unit."""
    assert formula("1/2 kN*t").tree == Call(
        "mul", (Call("div", (Constant(1.0), Constant(2000.0, unit("N")))), Clock())
    )


@pytest.mark.parametrize(
    "text",
    [
        "20 N*s/m * p.velocity",
        "-30 kN - 10 kN*sign(beam.speed)",
        "2 N*sqrt(p.position/(1 m))",
        "sqrt(2 N**2)",
        "5 N*sin(3 rad/s*t) + 2 N*cos(c.angle)",
        "max(0, 3 N)*exp(-p.position/3 mm)",  # 0 is anything
        "where(p.position > 3 cm, 0, 2 kN)",
        "3 kg*p.velocity**2/(2 m)",
        "0.5 N*m*c.speed/(2 m*3 rad/s)",  # a radian counts as one
        "2 N*atan2(p.velocity, 3 m/s)",
        "2 N*abs(c.angle - 30 deg)",
        "5*sin(t) + 3*p.position",  # without units all is in SI
    ],
)
def test_forces(text):
    require(formula(text), FORCE, powers_of)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("20 N*s/m*p.position", "it is a momentum (kg m/s), not a force"),
        ("20 N*m*c.angle", "it is a torque (N m), not a force"),
        ("3 N + 2*p.position", "a force (N) and a length (m) do not go together in '3 N + 2*p.p"),
        ("5 N*sin(3*t)", "'sin' takes an angle or a pure number, found a time (s) in 'sin(3*t)'"),
        ("where(p.position > 3, 0, 2 kN)", "and a length (m) do not go together in 'p.position >"),
        ("where(t > 3 s, 1 m, 2 kN)", "a force (N) and a length (m) do not go together in 'where"),
        ("2 N*exp(p.position)", "'exp' takes an angle or a pure number, found a length (m)"),
        ("max(2, 3 N)", "a pure number and a force (N) do not go together in 'max(2, 3 N)'"),
        ("sqrt(2 N)", "it is a quantity in kg^1/2 m^1/2/s, not a force"),
        ("3 kg*t", "it is a quantity in kg s, not a force"),
    ],
)
def test_what_does_not_go_together(text, reason):
    with pytest.raises(NumberError) as caught:
        require(formula(text), FORCE, powers_of)
    assert reason in str(caught.value)


def test_a_zero_measures_nothing():
    assert measured(formula("0*p.position + 2 N*0"), powers_of) is None
    assert described({}) == "an angle or a pure number"
