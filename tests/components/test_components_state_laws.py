"""What the form of a law says, against its values in plain Python."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from law_values import value

from linkages.components.contributed.functions import (
    Number,
    Operation,
    Time,
    V,
    X,
    applied,
    constant,
)
from linkages.components.contributed.load_measures import (
    Distance,
    Load,
    Turn,
    damper_law,
    spring_law,
)
from linkages.components.contributed.state_laws import (
    NOTHING,
    Monomial,
    addends,
    folded,
    monomial,
    stored,
    sum_of,
    time_functions,
    variables,
)
from linkages.components.contributed.terms import Parameter

PLACES = [(0.7, 1.3, -0.4), (2.1, -0.6, 0.9)]
"""Times, values and rates at which laws are compared."""
STEP = 1e-20
"""Of a complex step: no difference is taken, so derivatives are right to round-off."""


def operation(name, *arguments):
    return Operation(name, arguments)


def number(value, key="stiffness"):
    return Number(Parameter(("loads", 0, key), value, structural=True))


def power(base, exponent):
    return operation("power", base, constant(float(exponent)))


LEAVES = st.sampled_from([X, V, Time(), number(2.0), number(0.0, "damping"), constant(-3.0)])


def _grown(inner):
    two = st.builds(operation, st.sampled_from(["add", "sub", "mul"]), inner, inner)
    ratio = st.builds(lambda a: operation("div", a, number(4.0, "length")), inner)
    raised = st.builds(power, inner, st.integers(1, 3))
    return two | ratio | raised | st.builds(lambda a: operation("neg", a), inner)


LAWS = st.recursive(LEAVES, _grown, max_leaves=7)


@given(LAWS)
def test_no_value_changes(law):
    """Zeros are folded, terms are split and multiplied out; sums stay the same to round-off."""
    short = folded(law)
    parts = sum_of(addends(short))
    for t, x, v in PLACES:
        exact = value(law, t, x, v)
        for same in (short, parts):
            assert value(same, t, x, v) == pytest.approx(exact, rel=1e-12, abs=1e-9)


@given(LAWS)
def test_a_force_is_what_works_and_the_slope_of_what_is_stored(law):
    """Polynomials in x are in the energy, and nothing else; terms cancel to round-off."""
    load = Load(Distance("A", "B"), law, ("loads", 0))
    assert variables(load.energy) in ([], ["x"])
    assert all(variables(term) != ["x"] for term in addends(load.working))
    for t, x, v in PLACES:
        slope = value(load.energy, t, x + 1j * STEP, v).imag / STEP
        found = value(load.working, t, x, v) - slope
        assert found == pytest.approx(value(load.force, t, x, v), rel=1e-12, abs=1e-9)


@given(LAWS)
def test_a_monomial_is_its_powers(law):
    for term in addends(folded(law)):
        found = monomial(term)
        if found is None:
            continue
        for t, x, v in PLACES:
            base = 1.0 if found.base is None else value(found.base, t, x, v)
            product = value(found.coefficient, t) * base**found.degree * v**found.rate
            exact = value(term, t, x, v)
            assert product == pytest.approx(exact, rel=1e-12, abs=1e-9)
            if found.rate:
                assert value(found.over(V), t, x, v) * v == pytest.approx(exact, rel=1e-12)
            if found.base == X:
                assert value(found.over(X), t, x, v) * x == pytest.approx(exact, rel=1e-12)


def test_a_spring_has_no_energy_where_it_is_relaxed():
    stiffness, relaxed = Parameter(("k",), 50.0), Parameter(("L",), 0.3)
    load = Load(Distance("A", "B"), spring_law(stiffness, relaxed, Parameter(("d",), 1.0)), ())
    assert value(load.energy, 0.0, 0.3) == 0.0
    assert value(load.energy, 0.0, 0.5) == pytest.approx(0.5 * 50 * 0.2**2, rel=1e-15)
    pushed = operation("mul", Number(stiffness), operation("sub", Number(relaxed), X))
    assert value(stored(pushed), 0.0, 0.5) == pytest.approx(0.5 * 50 * 0.2**2, rel=1e-15)
    assert load.deflection == operation("sub", X, Number(relaxed))
    assert load.working == damper_law(Parameter(("d",), 1.0))


@pytest.mark.parametrize(
    ("numbers", "elastic_now", "damped", "absent"),
    [
        ((3.0, 0.2, 1.0), True, True, False),
        ((0.0, 0.2, 1.0), False, True, False),
        ((3.0, 0.0, 0.0), True, False, False),
        ((0.0, 0.2, 0.0), False, False, True),
    ],
)
def test_exact_zeros_remove_terms(numbers, elastic_now, damped, absent):
    keys = ("stiffness", "angle", "damping")
    law = spring_law(*(number(n, k).parameter for k, n in zip(keys, numbers, strict=True)))
    load = Load(Turn("rod", None), law, ("springs", 0))
    assert (load.elastic, load.dissipates, load.absent) == (elastic_now, damped, absent)
    assert load.turned == (("rod",) if elastic_now else ())
    assert not load.given  # it stays a spring, whatever its numbers are
    assert (load.force == NOTHING) == absent


def test_what_is_no_polynomial_is_not_stored():
    products = (operation("mul", factor, X) for factor in (V, Time(), operation("sin", X)))
    assert [stored(term) for term in (*products, V, NOTHING)] == [None] * 5
    assert monomial(operation("mul", operation("sin", X), V)) is None
    assert monomial(operation("mul", X, operation("sub", X, constant(1.0)))) is None


def test_a_law_of_neither_is_a_coefficient():
    assert monomial(Time()) == Monomial(Time(), None, 0, 0)


def test_functions_of_time_within_a_law():
    swing = operation("sin", operation("mul", number(3.0), Time()))
    law = operation("sub", operation("mul", operation("add", number(2.0), swing), X), Time())
    assert list(time_functions(law)) == [operation("add", number(2.0), swing), Time()]
    assert Load(Distance("A", "B"), law, ()).laws == tuple(time_functions(law))
    assert list(time_functions(operation("mul", number(2.0), V))) == []


def test_laws_take_operators_and_functions_of_numpy():
    """A band in which nothing pushes, against the operations that formulas of files become."""
    found = -2.0 * (np.maximum(X - 0.1, 0.0) + np.minimum(X + 0.1, 0.0)) + np.sin(-V) / np.exp(X)
    beyond = applied("add", applied("max", X - 0.1, 0.0), applied("min", X + 0.1, 0.0))
    falling = applied("div", applied("sin", applied("neg", V)), applied("exp", X))
    assert found == applied("add", applied("mul", -2.0, beyond), falling)
    assert np.float64(2.0) * X == 2.0 * X
    assert abs(X) == np.abs(X) == applied("abs", X)


def test_functions_that_laws_do_not_have_are_named():
    with pytest.raises(TypeError, match=r"laws know no log10; expected one of: absolute, add"):
        np.log10(X)
