"""Large mechanisms: what is done grows with the number of bars, and what is found is the same."""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest

import linkages
from linkages.cli.verbs.check_commands import MOST_LINES, _parts, check_content
from linkages.kernel import system as systems
from linkages.kernel.assembly import assemble
from linkages.kernel.assembly_branches import Place
from linkages.kernel.lru_cache import LRUCache
from linkages.kernel.system import System
from linkages.reports.report import Table
from linkages.topology.topology import numerical_mobility


def driven_series(count):
    """Bars one behind the other, all of them driven."""
    return {
        "joints": {"J0": [0, 0]},
        "bars": {f"b{i}": _bar(f"J{i}", f"J{i + 1}", 1) for i in range(count)},
        "drives": {f"b{i}": {"angle": math.sin(i), "speed": 1 + i / 100} for i in range(count)},
    }


def dyads_in_a_row(count):
    """A driven post, and dyads of which each stands on the one before."""
    heads = [(i + 0.1 * math.sin(2 * i), -1 + 0.1 * math.sin(3 * i)) for i in range(count // 2)]
    bars = {"post0": _bar("G0", "P0", math.hypot(*heads[0]))}
    for i, head in enumerate(heads[1:], 1):
        bars[f"link{i}"] = _bar(f"P{i - 1}", f"P{i}", math.dist(heads[i - 1], head))
        bars[f"post{i}"] = _bar(f"G{i}", f"P{i}", math.dist((i, 0), head))
    return {
        "joints": {f"G{i}": [i, 0] for i in range(len(heads))},
        "bars": bars,
        "drives": {"post0": {"angle": math.atan2(*reversed(heads[0])), "speed": 0.5}},
        "assembly": {f"P{i}": list(head) for i, head in enumerate(heads) if i},
    }


def dyads_on_one_crank(count):
    """A crank with dyads to the ground side by side, each in the branch that it says."""
    bars, number = {"crank": _bar("A", "B", 1)}, range(count // 2)
    for i in number:
        bars[f"coupler{i}"] = _bar("B", f"C{i}", 4)
        bars[f"rocker{i}"] = _bar(f"C{i}", f"D{i}", 3)
    return {
        "joints": {"A": [0, 0], **{f"D{i}": [4 + i / 1000, 0] for i in number}},
        "bars": bars,
        "drives": {"crank": {"angle": 0.3, "speed": 1}},
        "assembly": {f"C{i}": ("left", "right")[i % 2] for i in number},
    }


def four_bars(count):
    """Four-bar linkages side by side, which share the ground alone."""
    parts = {"joints": {}, "bars": {}, "drives": {}, "assembly": {}}
    for i in range(count // 3):
        parts["joints"] |= {f"A{i}": [10 * i, 0], f"D{i}": [10 * i + 4, 0]}
        parts["bars"] |= {
            f"crank{i}": _bar(f"A{i}", f"B{i}", 1),
            f"coupler{i}": _bar(f"B{i}", f"C{i}", 4),
            f"rocker{i}": _bar(f"C{i}", f"D{i}", 3),
        }
        parts["drives"][f"crank{i}"] = {"angle": 0.3 + 0.1 * math.sin(i), "speed": 1}
        parts["assembly"][f"C{i}"] = [10 * i + 4, 3]
    return parts


def _bar(first, second, length):
    return {"joints": [first, second], "length": length, "mass": 1}


KINDS = [driven_series, dyads_in_a_row, dyads_on_one_crank, four_bars]


def made(kind, count):
    import yaml

    return linkages.loads(yaml.safe_dump(kind(count), sort_keys=False))


def calls(kind, count, monkeypatch):
    """Calls of functions, of Python and C, to read, assemble and describe a new structure."""
    monkeypatch.setattr(systems, "_TOPOLOGIES", LRUCache(1))
    monkeypatch.setattr(systems, "_STRUCTURES", LRUCache(1))
    counted = 0

    def count_one(_frame, event, _argument):
        nonlocal counted
        counted += event in ("call", "c_call")

    sys.setprofile(count_one)
    try:
        check_content(System(made(kind, count)))
    finally:
        sys.setprofile(None)
    return counted


@pytest.mark.parametrize("kind", KINDS)
def test_work_grows_no_faster_than_the_number_of_bars(kind, monkeypatch):
    """Twice the bars from n to 2n, and from 2n to 4n, double what is added: sorting adds little.

    Something done for every pair of bars would quadruple it.
    """
    calls(kind, 12, monkeypatch)  # what is imported and made once
    few, middling, many = (calls(kind, count, monkeypatch) for count in (60, 120, 240))
    assert (many - middling) / (middling - few) < 2.2


@pytest.mark.parametrize("kind", KINDS)
def test_conditions_and_mobility_are_those_of_the_whole_jacobian(kind):
    system = System(made(kind, 40))
    order = [b for b in system.mechanism.bodies if b not in system.topology.followers]
    first = 0
    for block, condition in zip(system.topology.solved_blocks, system.conditions, strict=True):
        rows = slice(first, first + 2 * len(block.loops))
        columns = [order.index(name) for name in block.unknowns]
        first = rows.stop
        expected = np.linalg.cond(system.jacobian[rows, columns])
        assert condition == pytest.approx(expected, rel=1e-12)  # other sums of squares
    assert system.mobility == numerical_mobility(system.jacobian)


@pytest.mark.parametrize("kind", KINDS)
def test_blocks_are_assembled_as_if_everything_were_evaluated_each_time(kind, monkeypatch):
    system = System(made(kind, 24))
    place = system._place
    monkeypatch.setattr("linkages.kernel.assembly.GrowingPlace", _Whole)
    assert assemble(place) == system.assembly


class _Whole(Place):
    """Evaluates all nodes anew."""

    def __init__(self, place):
        vars(self).update(vars(place))

    def settle(self, block, choice):
        """Keeps nothing."""


def test_sizes_far_from_one_have_the_conditions_of_all_others():
    """Squares of lengths of 1e120 m are beyond 1e200; conditions do not depend on the unit."""
    text = """
    joints: {{A: [0, 0], D: [{0}, 0]}}
    bars:
      crank: {{joints: [A, B], length: {1}}}
      coupler: {{joints: [B, C], length: {2}}}
      rocker: {{joints: [C, D], length: {2}}}
    drives: {{crank: {{angle: 1, speed: 1}}}}
    assembly: {{C: left}}
    """
    usual = System(linkages.loads(text.format(2.0, 1.0, 2.5))).conditions
    huge = System(linkages.loads(text.format(2e120, 1e120, 2.5e120))).conditions
    assert huge == pytest.approx(usual, rel=1e-12)


def test_a_report_of_many_bodies_says_how_many_more_there_are():
    content = check_content(System(made(driven_series, MOST_LINES + 7)))
    assert len(content["bodies"]) == MOST_LINES + 7
    parts = list(_parts(content))
    tables = [part for part in parts if isinstance(part, Table)]
    assert all(len(table.rows) == MOST_LINES for table in tables)
    assert "7 more bodies; --json lists all of them" in parts
    assert "8 more joints; --json lists all of them" in parts
