"""Tangents across touches and leaves, against differences of motions of their own."""

import numpy as np
import pytest
from random_blocks import definition as block_definition
from random_contact import ENDS, definition, kind

import linkages
from linkages.kernel.system import System

STEP = 3e-5
LIMIT = 1e-6
"""In parts of the largest entry, coordinates in sizes of the clearance: differences are taken over
3e-5 of a size, extrapolated, of motions that are right to 1e-11 of one."""
RANDOM = {
    "memory": 0,
    "friction and two clearances": 6,
    "a force that jumps": 13,
    "free coordinates": 7,
}


def check(text, end, size):
    mechanism = linkages.loads(text)
    rhs = linkages.compile(mechanism)
    count, start = len(rhs.names), np.asarray(System(mechanism).state)
    scale = np.repeat([size, 100 * size], count // 2)
    found = rhs.flow(tangents=count, rtol=1e-12).advance(start, 0.0, end, np.eye(count))
    flow = rhs.flow(rtol=1e-13)

    def slope(column, step):
        there = [
            flow.advance(start + sign * step * scale[column] * np.eye(count)[column], 0.0, end).y
            for sign in (1, -1)
        ]
        return (np.asarray(there[0]) - there[1]) / (2 * step)

    slopes = [(4 * slope(k, STEP / 2) - slope(k, STEP)) / 3 for k in range(count)]
    expected = np.array(slopes).T / scale[:, None]
    tangents = np.asarray(found.tangents) * scale / scale[:, None]
    assert np.abs(tangents - expected).max() < LIMIT * np.abs(expected).max()


@pytest.mark.parametrize("case", RANDOM)
def test_random_mechanisms(case):
    seed = RANDOM[case]
    check(definition(seed), ENDS[kind(seed)] / 2, 2e-4)


def test_cases_are_what_they_say():
    assert "kelvin-voigt" in definition(RANDOM["a force that jumps"])
    assert definition(RANDOM["friction and two clearances"]).count("friction:") >= 1
    assert definition(RANDOM["free coordinates"]).count("free:") == 1


@pytest.mark.parametrize("seed", [1, 2, pytest.param(5, marks=pytest.mark.slow)])
def test_blocks_in_guides(seed):
    """On a bar, with memory, friction and two blocks; angles count as offsets over a length."""
    check(block_definition(seed), 0.006, 2e-4)
