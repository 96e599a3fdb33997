"""Tangents across touches and leaves, against differences of motions of their own."""

import pytest
from random_blocks import definition as block_definition
from random_contact import ENDS, definition, kind
from tangent_differences import check

RANDOM = {
    "memory": 0,
    "friction and two clearances": 6,
    "a force that jumps": 13,
    "free coordinates": 7,
}


@pytest.mark.slow_except("memory", "a force*")
@pytest.mark.parametrize("case", RANDOM)
def test_random_mechanisms(case):
    seed = RANDOM[case]
    check(definition(seed), ENDS[kind(seed)] / 2, 2e-4)


def test_cases_are_what_they_say():
    assert "kelvin-voigt" in definition(RANDOM["a force that jumps"])
    assert definition(RANDOM["friction and two clearances"]).count("friction:") >= 1
    assert definition(RANDOM["free coordinates"]).count("free:") == 1


@pytest.mark.slow_except("1")
@pytest.mark.parametrize("seed", [1, 2, 5])
def test_blocks_in_guides(seed):
    """On a bar, with memory, friction and two blocks; angles count as offsets over a length."""
    check(block_definition(seed), 0.006, 2e-4)
