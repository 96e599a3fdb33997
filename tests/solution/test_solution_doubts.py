"""Numbers that are allowed but hardly meant are noted."""

import pytest

import linkages
from linkages.solution.doubts import doubts


def test_a_clearance_in_metres_instead_of_millimetres():
    (note,) = doubts(linkages.load("ninebar", set={"clearances.r1.size": 0.2}))
    assert note.startswith("clearance r1 of 0.2 m is large beside link3 of 0.96")
    assert note.endswith("numbers without a unit are metres")


@pytest.mark.parametrize("name", ["ninebar", "slider-crank", "four-bar"])
def test_nothing_is_doubted_in_shipped_files(name):
    assert doubts(linkages.load(name)) == []


def test_simulations_tell():
    mechanism = linkages.load("ninebar", set={"clearances.r1.size": 0.1})
    solution = linkages.simulate(mechanism, end=0.01, samples=2)
    assert list(solution.notes) == doubts(mechanism) != []
