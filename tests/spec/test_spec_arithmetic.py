import ast
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from linkages.spec.grammar import NumberError, leading_number

NUMBERS = st.one_of(
    st.integers(0, 10**6).map(str),
    st.floats(0, 1e12, allow_nan=False).map(repr),
    st.sampled_from(["pi", ".5", "2.", "1e-3", "3E+2"]),
)
OPERATORS = st.sampled_from(["+", "-", "*", "/", " + ", " - ", "**", " / "])


def combined(inner):
    return st.one_of(
        st.tuples(inner, OPERATORS, inner).map("".join),
        inner.map("({})".format),
        inner.map("-{}".format),
        inner.map("+{}".format),
    )


EXPRESSIONS = st.recursive(NUMBERS, combined, max_leaves=8).filter(lambda text: len(text) < 200)


def by_python(text):
    """The value by Python's own grammar, every literal a float; None where it is no finite one."""
    tree = compile(text, "", "eval", flags=ast.PyCF_ONLY_AST)

    class Floats(ast.NodeTransformer):
        def visit_Constant(self, node):
            return ast.copy_location(ast.Constant(float(node.value)), node)

    code = compile(ast.fix_missing_locations(Floats().visit(tree)), "", "eval")
    try:
        value = eval(code, {"pi": math.pi})
    except (OverflowError, ZeroDivisionError):
        return None
    return value if isinstance(value, float) and math.isfinite(value) else None


@given(EXPRESSIONS)
def test_same_double_as_python(text):
    expected = by_python(text)
    try:
        value, rest = leading_number(text)
        outcome = (value, rest)
    except NumberError as error:
        outcome = error
    if isinstance(outcome, NumberError):
        # Python lets an intermediate infinity cancel (1/inf = 0), and any number of signs pile up.
        assert expected is None or str(outcome).startswith(("too large", "nested"))
    else:
        assert outcome == (expected, "")


@pytest.mark.slow
@given(st.text(max_size=300))
def test_any_text_gives_a_finite_number_or_the_one_error(text):
    try:
        value, _ = leading_number(text)
    except NumberError:
        return
    assert math.isfinite(value)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("-2**2", -4.0),
        ("2**-1", 0.5),
        ("2**3**2", 512.0),
        ("1 - 2 - 3", -4.0),
        ("8/4/2", 1.0),
        ("-1.5*pi", -1.5 * math.pi),
        ("2*π/3", 2 * math.pi / 3),
        (" ( 1 + 2 ) * 3 ", 9.0),
        ("--1", 1.0),
    ],
)
def test_precedence(text, expected):
    assert leading_number(text) == (expected, "")


@pytest.mark.parametrize(
    ("text", "rest"),
    [
        ("3 em", "em"),
        ("3e", "e"),
        ("1e-3 m", "m"),
        ("2 m*s", "m*s"),
        ("2 1/s", "1/s"),
        ("1 2", "2"),
    ],
)
def test_what_follows_the_number(text, rest):
    assert leading_number(text)[1] == rest


def test_what_is_just_not_too_deep_is_read():
    """The number itself is the last of 32 levels."""
    assert leading_number("(" * 31 + "1" + ")" * 31)[0] == 1.0


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("9**9**9**9", "too large"),
        ("1e400", "too large"),
        ("1e308*10", "too large"),
        ("1/(1e308*10)", "too large"),
        ("9" * 1_000_000, "longer than 200 characters"),
        ("(" * 199, "nested more than 32 deep"),
        ("-" * 199, "nested more than 32 deep"),
        ("2**" * 60 + "1", "nested more than 32 deep"),
        ("(" * 32 + "1" + ")" * 32, "nested more than 32 deep"),
        ("1/0", "division by zero"),
        ("0**-1", "is not a real number"),
        ("(-8)**(1/3)", "is not a real number"),
        ("(1", r"expected '\)' at the end"),
        ("", "expected a number at the end"),
        ("nan", "expected a number before 'nan'"),
        (".inf", "expected a number before"),
        ("2 * */3", r"expected a number before '\*'"),
        ("__import__('os')", "expected a number before '__import__'"),
        ("1 + x", "expected a number before 'x'"),
        ("pile", "expected a number before 'pile'"),
        ("١", "expected a number"),
    ],
)
def test_texts_that_are_no_finite_number(text, reason):
    with pytest.raises(NumberError, match=reason):
        leading_number(text)
