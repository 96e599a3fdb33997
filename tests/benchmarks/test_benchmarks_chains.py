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

from chains import LINKS, chain, line, measure

KEPT = Path(__file__).parents[2] / "docs" / "_static" / "chains.json"


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
    """`python docs/figures_chains.py --measure` makes them anew."""
    content = json.loads(KEPT.read_text(encoding="utf-8"))
    rows = content["rows"]
    assert tuple(row["links"] for row in rows) == LINKS
    assert max(row["compiling"] for row in rows) <= 40
    slope, offset = line(rows)
    off = [row["evaluation"] / (offset + slope * row["links"]) - 1 for row in rows]
    assert np.abs(off).max() < 0.5
    assert content["machine"]
    assert content["date"]
