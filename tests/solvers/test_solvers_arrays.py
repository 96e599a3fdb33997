"""What compiled code is told of arrays."""

import numpy as np
import pytest

from linkages.kernel.code.operands import Int, Table
from linkages.solvers.arrays import Memory


def read_only():
    found = np.ones(3)
    found.flags.writeable = False
    return found


@pytest.mark.parametrize("array", [np.ones((2, 3)), np.ones(5)[2:], np.zeros(0), read_only()])
def test_arrays_are_taken_where_they_are(array):
    """Compiled code writes its results in place, so that a copy would lose them."""
    memory = Memory()
    assert memory.floats(array) == array.ctypes.data
    assert memory.arrays[0] is array


def test_rows_of_an_array_have_addresses_one_for_each_motion():
    memory, table = Memory(3), np.arange(12).reshape(3, 4)
    assert memory.rows(table).tolist() == [row.ctypes.data for row in table]
    assert memory.each([*table]).tolist() == memory.rows(table).tolist()
    assert np.diff(memory.zeros(2, 2)).tolist() == [32, 32]


def test_words_may_differ_from_motion_to_motion():
    """A single motion has integers where several have arrays of them."""
    for count, own in ((1, [5]), (3, [5, 6, 7])):
        memory = Memory(count)
        memory.words([1, memory.own(own), 2])
        assert memory.arrays[-1].reshape(count, 3).tolist() == [[1, word, 2] for word in own]


class Pair(Table):
    one: Int
    other: Int


class Holder(Table):
    first: Int
    pair: Pair
    last: Int


def test_tables_have_entries_at_their_places():
    """Also those of parts; what is not given is 0."""
    memory = Memory(2)
    memory.table(Holder, {"last": memory.own([3, 4]), "pair": {"other": 5}})
    assert memory.arrays[-1].tolist() == [[0, 0, 5, 3], [0, 0, 5, 4]]


def test_lists_and_strided_arrays_are_copied():
    """Compiled code reads entries one behind the other."""
    memory, strided = Memory(), np.arange(6)[::2]
    address = memory.integers(strided)
    assert address == memory.arrays[0].ctypes.data != strided.ctypes.data
    assert memory.arrays[0].tolist() == [0, 2, 4]
    memory.floats([1, 2])
    assert memory.arrays[1].dtype == np.float64
