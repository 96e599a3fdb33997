import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from linkages.spec.formulas import Call, Clock, Constant, formula
from linkages.spec.grammar import NumberError


def test_tree():
    assert formula("2*sin(t)").tree == Call("mul", (Constant(2.0), Call("sin", (Clock(),), 2)), 4)


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("2*pi", 2 * math.pi),
        ("sin(pi/6)", math.sin(math.pi / 6)),
        ("max(2, 3) - min(2, 3) + abs(-1)", 2.0),
        ("sqrt(2)**4", math.pow(math.sqrt(2), 4)),
        ("t**0", 1.0),
    ],
)
def test_what_does_not_depend_on_time_is_one_number(text, number):
    assert formula(text).tree == Constant(number)


def test_precedence_is_that_of_arithmetic():
    """Both have one grammar; here only that formulas use it."""
    assert formula("-t**2").tree == Call("neg", (formula("t**2").tree,), 4)
    assert formula("t - 1 - 2").tree == formula("(t - 1) - 2").tree
    assert formula("1 − t").tree == formula("1 - t").tree
    assert formula("t**+2").tree == formula("t**(1 + 1)").tree


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("sine(t)", "unknown function 'sine' (character 1); did you mean 'sin'?"),
        (
            "1 + f(t)",
            "unknown function 'f' (character 5); expected one of: sin, cos, tan, asin, acos, atan, "
            "sinh, cosh, tanh, exp, log, sqrt, abs, min, max",
        ),
        ("2*x", "unknown name 'x' (character 3); expected t or pi"),
        ("t(2)", "unknown function 't' (character 1)"),
        ("sin t", "expected '(' after 'sin' before 't' (character 5)"),
        ("sin(t, 1)", "'sin' takes 1 argument, found 2 (character 1)"),
        ("1 + max(t)", "'max' takes 2 arguments, found 1 (character 5)"),
        ("2*(t - 1", "expected ')' at the end (character 9)"),
        ("2*", "expected a number at the end (character 3)"),
        ("t^2", "cannot read '^2' (character 2); powers are written **"),
        ("3 t", "cannot read 't' (character 3); numbers in formulas are in SI, without units"),
        ("t/0", "division by zero (character 1)"),
        ("t + 1/(2 - 2)", "division by zero (character 5)"),
        ("t + log(-1)", "log(-1) is not a real number (character 5)"),
        ("t*exp(1000)", "too large for a number (character 3)"),
        ("t**0.5", "expected a whole exponent of at most 100, found 0.5 (character 1)"),
        ("2**t", "expected a whole exponent of at most 100, found one that depends on t"),
        ("t**101", "expected a whole exponent of at most 100, found 101"),
        ("t + " * 100 + "t", "longer than 300 characters"),
        ("sin(" * 40 + "t" + ")" * 40, "nested more than 32 deep"),
        ("abs(" * 20 + "t" + ")" * 20, "expected fewer nested abs, min and max"),
        ("__import__('os')", "unknown function '__import__' (character 1)"),
        ("t.real", "cannot read '.real' (character 2)"),
        ("", "expected a number at the end (character 1)"),
    ],
)
def test_texts_that_are_no_formula(text, reason):
    with pytest.raises(NumberError) as caught:
        formula(text)
    assert reason in str(caught.value)


@given(st.text("t1.+-*/() ,sinmaxp", max_size=60))
def test_any_text_gives_a_formula_or_the_one_error(text):
    try:
        tree = formula(text).tree
    except NumberError:
        return
    assert isinstance(tree, Constant | Clock | Call)
