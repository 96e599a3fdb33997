"""Chains of dyads: what is measured is a mechanism that moves, and it does not grow out of hand."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

import linkages
from linkages.kernel.code.program import report_kernel
from linkages.kernel.system import System
from linkages.solution.plan import build_flow, kernel_source

sys.path.insert(0, str(Path(__file__).parent))

from chains import (
    CHECKED_BARS,
    FREE_BARS,
    LINKS,
    chain,
    driven_chain,
    free_chain,
    line,
    measure,
    measure_check,
    measure_free,
)

STATIC = Path(__file__).parents[2] / "docs" / "_static"
KEPT, KEPT_FREE = STATIC / "chains.json", STATIC / "free_chains.json"


def operations(links):
    source = kernel_source(System(chain(links)).topology)
    return sum(
        sum(part.values()) for part in report_kernel(source.model, source.program).counts.values()
    )


@pytest.mark.slow
def test_chain_is_far_from_singular_and_swings():
    system = System(chain(20))
    assert system.topology.free == ("post0",)
    assert [block.kind for block in system.topology.solved_blocks] == ["RRR"] * 10
    assert max(system.conditions) < 4
    data = linkages.simulate(chain(20), end=1.0, samples=101, rtol=1e-11, outputs="all").data
    assert float(data.closure_residual.max()) <= 1e-13
    assert float(np.abs(data.energy_residual).max()) < 1e-8


def test_operations_grow_with_the_links_and_no_faster():
    """Every dyad adds the same: second differences vanish."""
    counts = np.array([operations(links) for links in (4, 8, 12, 16, 40, 64)])
    per_link = np.diff(counts) / np.diff([4, 8, 12, 16, 40, 64])
    assert np.ptp(per_link) <= 2
    assert per_link.max() < 80


def test_measuring_gives_all_figures():
    row = measure(4)
    assert row["links"] == 4
    assert row["evaluation"] > 0
    assert row["operations"] == operations(4)


def test_line_through_exact_times():
    rows = [{"links": n, "evaluation": 3e-8 + 2e-8 * n} for n in LINKS]
    assert line(rows) == pytest.approx((2e-8, 3e-8))


@pytest.mark.long
def test_two_hundred_links_compile():
    system = System(chain(200))
    flow = build_flow(system)
    assert flow.coordinates == 1
    assert len(flow.margin_scale) == 100


def test_kept_numbers():
    """`python docs/make chains.json` measures them anew."""
    content = json.loads(KEPT.read_text(encoding="utf-8"))
    rows = content["rows"]
    assert tuple(row["links"] for row in rows) == LINKS
    assert max(row["compiling"] for row in rows) <= 40
    slope, offset = line(rows)
    off = [row["evaluation"] / (offset + slope * row["links"]) - 1 for row in rows]
    assert np.abs(off).max() < 0.5
    assert content["machine"]
    assert content["date"]


def test_chains_of_free_and_of_driven_bars_are_what_they_are_called():
    assert System(free_chain(5)).topology.free == tuple(f"b{i}" for i in range(5))
    assert System(driven_chain(5)).topology.driven == tuple(f"b{i}" for i in range(5))


@pytest.mark.slow
def test_measuring_free_and_checked_chains_gives_all_figures():
    row = measure_free(14)
    assert row["bars"] == 14
    assert row["terms"] < 14 * 130
    assert min(row["first"], row["evaluation"], row["memory"]) > 0
    assert measure_check(20).keys() == {"bars", "dyads", "driven"}


def test_kept_numbers_of_free_chains_meet_their_goals():
    """`python docs/make free_chains.json` measures them anew.

    Seconds to the first sample of 10, 30, 100 and 300 bars, 0.15 µs per bar, 10 s of `check`.
    """
    content = json.loads(KEPT_FREE.read_text(encoding="utf-8"))
    free = [row for row in content["rows"] if "first" in row]
    checked = [row for row in content["rows"] if "dyads" in row]
    assert tuple(row["bars"] for row in free) == FREE_BARS
    assert tuple(row["bars"] for row in checked) == CHECKED_BARS
    for row, goal in zip(free, (1.0, 1.5, 4.0, 12.0), strict=True):
        assert row["first"] <= goal
        assert row["evaluation"] <= 0.15e-6 * row["bars"]
    assert max(max(row["dyads"], row["driven"]) for row in checked) <= 10.0
    assert content["machine"]
    assert content["date"]
