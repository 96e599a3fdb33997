"""The comparison with heyoka's batches compares the same motions."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import against_heyoka
from against_heyoka import Cost, measured, rows


@pytest.mark.slow
def test_both_have_the_same_ends():
    """Each checked by the other: errors fall with the tolerance, by some of its order."""
    pytest.importorskip("heyoka")
    found = measured(motions=8, end=0.1, tolerances=(1e-6, 1e-9), rounds=1)
    assert list(found) == list(against_heyoka.WAYS)
    for cost in found.values():
        loose, tight = cost.errors
        assert tight < 0.1 * loose < 1e-4
        assert min(cost.seconds) > 0


def test_costs_are_read_from_a_line():
    """Ten times the time for a thousandth of the error."""
    cost = Cost([1.0, 10.0, 100.0], [1e-3, 1e-6, 1e-9])
    assert cost.at(1e-6) == pytest.approx(10.0, rel=1e-12)
    assert cost.at(1e-7) == pytest.approx(10.0 * 10 ** (1 / 3), rel=1e-12)
    with pytest.raises(ValueError, match="expected some around 1e-12"):
        cost.at(1e-12)
    table = rows({"ours": cost, "theirs": Cost([2.56, 25.6, 256.0], cost.errors)}, 1e-6)
    assert table[2:] == ["| ours | 39.06 | 1.0 |", "| theirs | 100.00 | 2.6 |"]
