"""Sizes of generated code, and visits while it is made, against the number of bars.

Costs are counted, not timed: lines of functions, lengths of texts, and calls.
"""

from __future__ import annotations

import re
import sys
from collections import Counter
from itertools import combinations
from pathlib import Path

import pytest
import yaml

import linkages
from linkages.cli.verbs.check_commands import check_content
from linkages.components.contributed.terms import Body
from linkages.kernel.code import machine, writer
from linkages.kernel.system import System
from linkages.reading.document import shipped
from linkages.solution import remarks
from linkages.solution.plan import build_flow, kernel_source
from linkages.solvers.explicit_methods import DOP853
from linkages.solvers.loops.explicit_steps import write_step
from linkages.solvers.loops.row_layout import RowLayout

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))

from arrangements import ARRANGEMENTS
from chains import chain, free_chain

CHAINS = {"free": free_chain, "dyads": chain}


def lengths(text):
    """Lines of all pieces of functions, whose names have numbers."""
    parts = text.split("\n}\n")
    return [part.count("\n") for part in parts if re.search(r"define internal .*@\w+\.\d", part)]


def text_of(name, count):
    return kernel_source(System(CHAINS[name](count)).topology).program.assembly


@pytest.mark.parametrize("name", CHAINS)
@pytest.mark.parametrize("lanes", [1, 8])
def test_functions_have_bounded_lengths(name, lanes):
    """A piece ends behind the statement that exceeds its length; then values are stored in it.

    Of the latter there are at most as many as instructions, with an address each.
    """
    program = kernel_source(System(CHAINS[name](80)).topology).program
    parts = lengths(writer.write_assembly(program.routines, lanes))
    assert len(parts) > 5
    assert max(parts) < 3 * writer.LONGEST


@pytest.mark.parametrize("name", CHAINS)
def test_text_grows_with_the_bars_and_no_faster(name, monkeypatch):
    """All routines are divided; twice the bars add twice the text, but for where pieces end."""
    monkeypatch.setattr(writer, "MANY", 0)
    one, two, four = (len(text_of(name, count)) for count in (40, 80, 160))
    assert (four - two) / (two - one) == pytest.approx(2.0, rel=0.05)


def test_shipped_mechanisms_are_one_function_each():
    for name in shipped():
        system = System(linkages.load(name))
        if system.topology.free:
            assert "@rates.0(" not in kernel_source(system.topology).program.assembly


def test_steps_of_many_coordinates_are_loops():
    """Their text has the number of coordinates in it, and no more of it."""
    found = []
    for count in (20, 60):
        flow = build_flow(System(free_chain(count)))
        found.append(write_step(DOP853.tableau, RowLayout.of(flow)))
    assert len(found[1]) - len(found[0]) < 1000
    assert found[0].count("\n") == found[1].count("\n")


def test_a_text_in_pieces_compiles_sooner_than_one_function():
    """By the rule that announces long compilations: k functions take k**(-1/2) of the time."""
    text = text_of("free", 100)
    whole = re.sub(r"\n}\n", "\n", text)
    assert machine._equivalent(whole) == pytest.approx(len(whole), rel=1e-3)
    count = len(text.split("\n}\n"))
    assert machine._equivalent(text) < 2 * len(text) * count ** (-1 / 3)


@pytest.mark.parametrize("name", ["quick-returns", "slotted-bars", "dyads"])
def test_check_looks_at_each_slider_equally_often(name, monkeypatch):
    """Calls of an attribute that messages look up: twice the bodies, twice the calls."""
    calls = Counter()
    axis = Body.axis.fget
    monkeypatch.setattr(Body, "axis", property(lambda self: calls.update("a") or axis(self)))
    found = []
    for count in (60, 120):
        calls.clear()
        check_content(System(linkages.loads(ARRANGEMENTS[name](count))))
        found.append(calls["a"])
    assert found[1] <= 2.1 * found[0]


def test_distances_between_points_of_a_plate_are_not_all_computed(monkeypatch):
    """Their largest is found to a thousandth: 200 directions miss it by 1 - cos(pi/200) at most."""
    pairs = Counter()

    def counted(places, size):
        for pair in combinations(places, size):
            pairs.update("p")
            yield pair

    monkeypatch.setattr(remarks, "combinations", counted)
    (body,) = linkages.loads(ARRANGEMENTS["wide-plate"](3000)).bodies.values()
    assert remarks.longest(body) == pytest.approx(2.0, rel=1e-3)
    assert pairs["p"] <= remarks.MOST_SPANNED**2 / 2


def test_points_of_a_plate_that_coincide_are_still_reported():
    text = ARRANGEMENTS["wide-plate"](300) + "\n"
    same = yaml.safe_load(text)
    same["bars"]["wheel"]["points"]["P299"] = same["bars"]["wheel"]["points"]["P7"]
    with pytest.raises(linkages.InputError, match="'P299' lies on 'P7'; expected two places"):
        linkages.loads(yaml.safe_dump(same, sort_keys=False))
