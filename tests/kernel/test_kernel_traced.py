"""Functions that write themselves: what they compute is what Python computes with numbers."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from linkages.kernel.code.elementary_functions import elementary
from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.operands import (
    Bool,
    Int,
    IntArray,
    Real,
    Table,
    copysign,
    floats,
    floor,
    fma,
    integers,
    maximum,
    minimum,
    rint,
    select,
    select_of,
    sqrt,
)
from linkages.kernel.code.procedure import Procedure, text_of, traced

VALUES = [0.0, -0.0, 1.0, -1.5, 2.5, 3.5, 1e-300, -7e200, math.inf, -math.inf, math.nan]
PAIRS = [(a, b) for a in VALUES for b in VALUES]


@cache
def code_of(function):
    """Machine code, which lives as long as the tests."""
    return MachineCode(text_of(function))


def compiled(function):
    return code_of(function).function(function.__name__)


def evaluated(function, *given):
    """What a function of numbers writes to an array, of which it has the address."""
    found = np.zeros(32)
    compiled(function)(*given, found.ctypes.data)
    return found


@traced
def arithmetic(_code: Procedure, a: Real, b: Real, out: Int) -> None:
    found = floats(out)
    results = (
        a + b, a - b, a * b, a / b, 1.0 + a, 1.0 - a, 2 * a, 1.0 / a, -a, abs(a),
        minimum(a, b), maximum(a, b), select(a > b, a, 5.0), copysign(2.0, a), rint(a),
        fma(a, b, 0.1),
    )  # fmt: skip
    for place, result in enumerate(results):
        found[place] = result


@pytest.mark.parametrize(("a", "b"), PAIRS)
def test_arithmetic_is_that_of_numpy_to_the_last_bit(a, b):
    found = evaluated(arithmetic, a, b)
    with np.errstate(all="ignore"):
        x, y = np.float64(a), np.float64(b)
        expected = [
            x + y, x - y, x * y, x / y, 1.0 + x, 1.0 - x, 2 * x, 1.0 / x, -x, abs(x),
            y if y < x else x, y if y > x else x, x if x > y else 5.0, np.copysign(2.0, x),
            np.rint(x),
        ]  # fmt: skip
    np.testing.assert_array_equal(found[: len(expected)], expected)


def test_a_fused_sum_is_rounded_once():
    """(1 + ε)(1 - ε) = 1 - ε² differs from 1 by less than half a unit in the last place."""
    small = 2.0**-30
    assert evaluated(arithmetic, 1.0 + small, 1.0 - small)[15] == 1.0 + 0.1 - small**2
    product = traced(exact_product)
    assert evaluated(product, 1.0 + small, 1.0 - small)[0] == -(small**2)


def exact_product(_code: Procedure, a: Real, b: Real, out: Int) -> None:
    floats(out)[0] = fma(a, b, -1.0)


@traced
def relations(_code: Procedure, a: Real, b: Real, out: Int) -> None:
    found = floats(out)
    holds = (a < b, a <= b, a > b, a >= b, a == b, a != b)
    for place, truth in enumerate((*holds, ~holds[0], holds[0] | holds[4], holds[1] & holds[3])):
        found[place] = truth.to_real


@pytest.mark.parametrize(("a", "b"), PAIRS)
def test_relations_are_false_of_what_is_no_number(a, b):
    holds = [a < b, a <= b, a > b, a >= b, a == b, a != b, not a < b, a <= b, a == b]
    assert evaluated(relations, a, b)[:9].tolist() == [float(x) for x in holds]


@traced
def whole(_code: Procedure, a: Int, b: Int, out: Int) -> None:
    found = integers(out)
    results = (a + b, a - b, 3 - a, a * b, a & 7, a >> 1, a % b, a // b, (a < b).to_int)
    for place, result in enumerate(results):
        found[place] = result


def test_integers():
    found = np.zeros(9, dtype=np.int64)
    compiled(whole)(45, 7, found.ctypes.data)
    assert found.tolist() == [52, 38, -42, 315, 5, 22, 3, 6, 0]


@traced
def functions(_code: Procedure, x: Real, out: Int) -> None:
    found = floats(out)
    found[0], found[1], found[2] = sqrt(x), floor(-x).to_real, elementary("atan2", x, 2.0 * x)


def test_functions():
    """The arc tangent errs by less than two units in the last place."""
    root, floor, arc = evaluated(functions, 6.25)[:3]
    assert (root, floor, arc) == (2.5, -7.0, pytest.approx(math.atan2(1.0, 2.0), rel=5e-16))


@traced
def collatz(code: Procedure, start: Int, most: Int) -> Int:
    """Steps to 1, or -1 if there are too many."""
    n, steps = code.variable(start), code.variable(0)
    with code.while_(lambda: n != 1):
        with code.if_(steps == most):
            code.return_(-1)
        steps.set(steps + 1)
        with code.if_(n % 2 == 0):
            n.set(n // 2)
            code.continue_()
        n.set(3 * n + 1)
    return code.value(steps)


@pytest.mark.parametrize(("start", "steps"), [(1, 0), (6, 8), (27, 111), (97, -1)])
def test_loops_that_begin_again_and_functions_that_are_left(start, steps):
    """Lengths of Collatz' sequences, OEIS A006577."""
    assert compiled(collatz)(start, 115) == steps


@traced
def below(code: Procedure, limit: Int, i: Int) -> Bool:  # noqa: ARG001
    return i * i < limit


@traced
def squares(code: Procedure, limit: Int, count: Int) -> Int:
    """Number of square pairs (i, j < i) below a limit, and 1000 where there is none."""
    found = code.variable(0)
    with code.for_range(count) as i:
        with code.if_(~below(limit, i)):
            code.break_()
        with code.for_range(i) as j:
            with code.if_(below(limit, i + j)) as case:
                found.set(found + 1)
            with case.else_():
                code.break_()
    with code.if_(found == 0) as case:
        code.return_(1000)
    with case.else_():
        code.return_(found)
    return code.value(0)


@pytest.mark.parametrize(("limit", "count"), [(1, 9), (2, 9), (30, 9), (1000, 9), (1000, 0)])
def test_loops_cases_and_calls(limit, count):
    pairs = [(i, j) for i in range(count) for j in range(i) if i * i < limit > (i + j) ** 2]
    assert compiled(squares)(limit, count) == (len(pairs) or 1000)


class Sides(Table):
    first: Int
    second: Int
    target: IntArray


class Both(Table):
    one: Sides
    other: Sides


@traced
def second_side(code: Procedure, sides: Sides, factor: Int) -> Int:  # noqa: ARG001
    return sides.second * factor


@traced
def from_sides(_code: Procedure, both: Both, further: IntArray) -> Real:
    """Entries where the function begins, of a part of a table, and of one found on the way."""
    found = Sides.at(further[0])
    before = found.first
    both.one.target[0] = 40
    return (100 * second_side(both.one, both.other.first) + found.first - before).to_real


def test_entries_of_tables():
    target = np.array([4, 0, 0])
    words = np.array([1, 2, target.ctypes.data, 30, 0, 0])
    further = np.array([target.ctypes.data])
    assert compiled(from_sides)(words.ctypes.data, further.ctypes.data) == 6000 + 36


@traced
def confused(_code: Procedure, a: Real, n: Int) -> Real:
    return a + n


@traced
def undecided(_code: Procedure, a: Real) -> Real:
    return a if a > 0.0 else -a


@traced
def short_of_one(_code: Procedure, limit: Int) -> Bool:
    return below(limit)


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (confused, "expected Real, found Int"),
        (undecided, "use `Procedure.when`"),
        (short_of_one, "below takes 2 arguments, found 1"),
    ],
)
def test_what_cannot_be_written(function, message):
    with pytest.raises(TypeError, match=message):
        text_of(function)


def test_constants_of_both_arms():
    @traced
    def sign(_code: Procedure, a: Real) -> Real:
        return select_of(Real, a < 0.0, -1, 1)

    assert [compiled(sign)(x) for x in (-3.0, 0.0, 2.0)] == [-1.0, 1.0, 1.0]
