import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from linkages.spec.formulas import HIGHEST, LONGEST, Call, Clock, Constant, Sensed, formula
from linkages.spec.grammar import NumberError


def test_tree():
    assert formula("2*sin(t)").tree == Call("mul", (Constant(2.0), Call("sin", (Clock(),))))


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
    assert formula("-t**2").tree == Call("neg", (formula("t**2").tree,))
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
            "sinh, cosh, tanh, exp, log, sqrt, atan2, abs, min, max, sign, where, rate, distance, "
            "angle",
        ),
        ("t(2)", "unknown function 't' (character 1)"),
        ("sin t", "expected '(' after 'sin' before 't' (character 5)"),
        ("sin(t, 1)", "'sin' takes 1 argument, found 2 (character 1)"),
        ("1 + max(t)", "'max' takes 2 arguments, found 1 (character 5)"),
        ("2*(t - 1", "expected ')' at the end (character 9)"),
        ("2*", "expected a number at the end (character 3)"),
        ("t^2", "cannot read '^2' (character 2); powers are written **"),
        ("3 t", "cannot read 't' (character 3); an operator is missing, or the number its unit"),
        ("t/0", "division by zero (character 1)"),
        ("t + 1/(2 - 2)", "division by zero (character 5)"),
        ("t + log(-1)", "log(-1) is not a real number (character 5)"),
        ("t*exp(1000)", "too large for a number (character 3)"),
        ("t**0.5", "expected a whole exponent of at most 100, found 0.5 (character 1)"),
        ("2**t", "expected a whole exponent of at most 100, found one that depends on t"),
        ("t**101", "expected a whole exponent of at most 100, found 101"),
        ("t + " * LONGEST + "t", f"longer than {LONGEST} characters"),
        ("t+" * (HIGHEST + 1) + "t", f"more than {HIGHEST} operations one within the other (char"),
        ("sin(" * 40 + "t" + ")" * 40, "nested more than 32 deep"),
        ("__import__('os')", "unknown function '__import__' (character 1)"),
        ("t.real", "unknown quantity 't.real' (character 1); expected position, velocity, angle"),
        ("parameters.load", "(character 1); in formulas a parameter is its name alone, load"),
        ("2*gap.sped", "unknown quantity 'gap.sped' (character 3); did you mean 'speed'?"),
        ("A.reaction", "'A.reaction' follows from accelerations, which follow from the loads (ch"),
        ("1 + gap.force", "'gap.force' follows from accelerations, which follow from the loads (c"),
        ("crank.effort", "'crank.effort' follows from accelerations, which follow from the loads"),
        ("p.acceleration", "'p.acceleration' follows from accelerations, which follow from the l"),
        ("5*(t < 3)", "a comparison stands first in 'where(…)' only (character 4)"),
        ("t < 3", "cannot read '< 3' (character 3); a comparison stands in 'where(…)' only"),
        ("sin(t < 3)", "a comparison stands first in 'where(…)' only (character 5)"),
        ("where(t, 1, 2)", "'where' expects a comparison first, such as where(t < 1 s, 0 N, 5 N)"),
        ("where(t < 1, 2)", "'where' takes 3 arguments, found 2 (character 1)"),
        ("distance(A)", "'distance' takes 2 arguments, found 1 (character 1)"),
        ("rate(crank.speed)", "'rate' expects a position, an angle or a distance, such as rate(d"),
        ("a.angle.b", "cannot read '.b' (character 8)"),
        ("'a.angle", 'expected a number before "\'" (character 1)'),
        ("3 mtr*t", "unknown unit 'mtr'"),
        ("3 degC*t", "degC has its zero elsewhere; expected a unit that scales (character 3)"),
        ("", "expected a number at the end (character 1)"),
    ],
)
def test_texts_that_are_no_formula(text, reason):
    with pytest.raises(NumberError) as caught:
        formula(text)
    assert reason in str(caught.value)


@given(st.text("t1.+-*/() ,sinmaxp<>='", max_size=60))
def test_any_text_gives_a_formula_or_the_one_error(text):
    try:
        tree = formula(text).tree
    except NumberError:
        return
    assert isinstance(tree, Constant | Clock | Sensed | Call)


def test_quantities():
    assert formula("piston.velocity").tree == Sensed("velocity", ("piston",))
    assert formula("'left crank'.angle").tree == Sensed("angle", ("left crank",))
    assert formula("distance( A , 'B 2' )").tree == Sensed("distance", ("A", "B 2"))
    assert formula("rate(angle(ground, rod))").tree == Sensed("angle", ("ground", "rod"), True)
    assert formula("sin.angle + t.x").tree == Call(
        "add", (Sensed("angle", ("sin",)), Sensed("x", ("t",)))
    )  # what stands before a point is a name


@pytest.mark.parametrize(
    ("sign", "order", "turned"),
    [(">=", "ab", False), ("<", "ab", True), ("<=", "ba", False), (">", "ba", True)],
)
def test_comparisons_are_differences_that_are_not_negative(sign, order, turned):
    """a < b is exactly what a >= b is not."""
    names = {name: Sensed("x", (name,)) for name in "ab"}
    difference = Call("sub", tuple(names[name] for name in order))
    both = (Constant(2.0), Constant(1.0)) if turned else (Constant(1.0), Constant(2.0))
    assert formula(f"where(a.x {sign} b.x, 1, 2)").tree == Call("where", (difference, *both))


def test_a_comparison_of_numbers_is_settled_at_once():
    assert formula("where(1 < 2, t, 0)").tree == Clock()
    assert formula("where(1 >= 2, t, 0)").tree == Constant(0.0)


@pytest.mark.parametrize("name", ["abs", "sign", "sin"])
def test_functions_do_not_repeat_their_argument(name):
    """The tree is as large as the text, whatever is nested in what."""
    nested = formula(f"{name}(" * 30 + "t" + ")" * 30)
    assert sum(1 for _ in nested.nodes()) == 31
    longest = formula("max(t, min(1, t))*" * 100 + "t")
    assert sum(1 for _ in longest.nodes()) <= LONGEST


def test_depth_is_bounded_and_length_is_not_depth():
    assert formula("t+" * HIGHEST + "t").tree.depth == HIGHEST
    flat = "+".join(["(" + "+".join(["t"] * 30) + ")"] * 30)
    assert len(flat) > 10 * HIGHEST
    assert formula(flat).tree.depth < HIGHEST
