"""A number with many values goes through arithmetic as each of them does alone, or is refused."""

import math
import operator

import numpy as np
import pytest

from linkages.reading.overrides import Column, UndecidedError, values_of

VALUES = np.array([0.1, 0.2, 0.30000000000000004, -7.3, 1e-300])


@pytest.mark.parametrize("operation", [operator.add, operator.sub, operator.mul, operator.truediv])
@pytest.mark.parametrize("other", [0.7, 3, Column(VALUES[::-1])], ids=["0.7", "3", "column"])
def test_arithmetic_is_that_of_each_value_in_all_bits(operation, other):
    for swapped in (False, True):
        pair = (other, Column(VALUES)) if swapped else (Column(VALUES), other)
        found = operation(*pair).values
        rows = [np.broadcast_to(values_of(each), VALUES.shape).tolist() for each in pair]
        assert found.tolist() == [operation(*each) for each in zip(*rows, strict=True)]


def test_signs_and_whole_numbers():
    column = Column(np.array([0.5, 1.5, -2.5]))
    assert (-column).values.tolist() == [-0.5, -1.5, 2.5]
    assert abs(column).values.tolist() == [0.5, 1.5, 2.5]
    assert round(column).values.tolist() == [round(v) for v in (0.5, 1.5, -2.5)]


def test_comparisons_are_answered_where_all_values_agree():
    assert Column(np.array([1.0, 2.0])) > 0
    assert not Column(np.array([1.0, 2.0])) <= 0.5
    assert Column(np.array([0.0, 0.0])) == 0.0
    assert not Column(np.zeros(3))
    assert Column(VALUES) is not None
    assert Column(VALUES) != "left"
    for question in (lambda c: c > 1.5, lambda c: c == 1.0, lambda c: c != 1.0, bool):
        with pytest.raises(UndecidedError):
            question(Column(np.array([1.0, 2.0, 0.0])))


@pytest.mark.parametrize(
    "task",
    [float, math.sqrt, lambda c: math.hypot(c, 1.0), np.array, np.sin, lambda c: c**2,
     lambda c: round(c, 2), lambda c: c + "1", int],
)  # fmt: skip
def test_whoever_takes_a_column_for_one_number_is_refused(task):
    with pytest.raises((UndecidedError, TypeError)):
        task(Column(VALUES))
