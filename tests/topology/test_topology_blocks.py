"""Kinds of blocks, the direction of their loops, and what is left over."""

import os
import subprocess
import sys

import pytest
from linkage_files import mechanism

from linkages.components.contributed.terms import axis_label
from linkages.topology.assur_groups import CLOSED_FORMS
from linkages.topology.topology import build_topology

QUICK_RETURN = """
joints: {O: [0, 0], P: [0, 0.1]}
bars: {crank: {joints: [P, A], length: 0.05}, arm: {joints: [O, B], length: 0.25}}
sliders: {block: {joint: A, on: arm, through: O}}
drives: {DRIVEN}
"""
YOKE = """
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.05}}
sliders: {yoke: {joint: Y, through: O}, pin: {joint: A, on: yoke, through: Y, angle: 90 deg}}
drives: {DRIVEN}
"""
CRANK = "crank: {angle: 0, speed: 1}"


def solved(text, driven):
    return build_topology(mechanism(text.replace("DRIVEN", driven))).solved_blocks


@pytest.mark.parametrize(
    ("text", "driven", "kind", "unknowns"),
    [
        (QUICK_RETURN, CRANK, "RPR", ("arm", "block")),
        (QUICK_RETURN, "arm: {angle: 1, speed: 1}", "RRP", ("crank", "block")),
        (QUICK_RETURN, "block: {position: 0.1, speed: 1}", "RRR", ("crank", "arm")),
        (YOKE, CRANK, "PP", ("yoke", "pin")),
        (YOKE, "yoke: {position: 0.01, speed: 1}", "RRP", ("crank", "pin")),
        (YOKE, "pin: {position: 0.01, speed: 1}", "RRP", ("crank", "yoke")),
    ],
)
def test_kinds_with_moving_axes(text, driven, kind, unknowns):
    (block,) = solved(text, driven)
    assert (block.kind, block.unknowns) == (kind, unknowns)
    assert block.title == CLOSED_FORMS[kind]
    assert block.surplus == 0


def test_a_way_along_a_slider_has_labels_at_both_ends():
    (block,) = solved(QUICK_RETURN, CRANK)
    ends = {place for step in block.loops[0].steps for place in (step.start, step.end)}
    assert axis_label("block") in ends
    assert None not in ends


CLOSED_TWICE = """
joints: {O: [0, 0], C: [0.4, 0]}
bars:
  crank: {joints: [O, A], length: 0.1}
  one: {joints: [C, D], length: 0.5}
  two: {points: {E: [0, 0], F: [0.1, 0]}}
sliders: {first: {joint: A, on: one, through: C}, second: {joint: E, on: one, through: D}}
drives: {crank: {angle: 0, speed: 1}, second: {position: 0, speed: 1}, two: {angle: 0, speed: 1}}
"""


def test_what_slides_on_a_guide_behind_a_dyad():
    topology = build_topology(mechanism(CLOSED_TWICE))
    assert [b.kind for b in topology.solved_blocks] == ["RPR"]
    assert topology.placing["E"] == "second"
    assert topology.entry["second"] == axis_label("second")


WELDED = """
joints: {O: [0, 0], C: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.3}
  coupler: {joints: [A, B], length: 0.9}
  rocker: {joints: [C, B], length: 0.7}
  arm: {joints: [A, E], length: 0.5}
welds: {A: {bars: [WELD], angle: 0.4}}
drives: {crank: {angle: 1, speed: 1}}
"""


@pytest.mark.parametrize(
    ("weld", "unknowns"),
    [("coupler, arm", ("coupler", "rocker")), ("arm, coupler", ("arm", "rocker"))],
)
def test_a_weld_does_not_turn_a_loop_round(weld, unknowns):
    """Left and right are seen along the bars of the file, whichever of them has the angle."""
    (block,) = build_topology(mechanism(WELDED.replace("WELD", weld))).solved_blocks
    assert (block.kind, block.unknowns) == ("RRR", unknowns)
    assert [step.body for step in block.loops[0].steps] == ["coupler", "rocker"]


def test_gears_within_a_loop_have_no_closed_form():
    text = WELDED.replace("welds: {A: {bars: [WELD], angle: 0.4}}", "gears: [GEAR]").replace(
        "  arm: {joints: [A, E], length: 0.5}\n", ""
    )
    gear = "{bars: [coupler, rocker], ratio: -2}"
    free = text.replace("joints: [C, B]", "joints: [B, C2]").replace("GEAR", gear)
    slider = "sliders: {end: {joint: C2, through: C}}\ngears:"
    (block,) = build_topology(mechanism(free.replace("gears:", slider))).solved_blocks
    assert (block.kind, {*block.unknowns}, len(block.loops)) == ("N", {"coupler", "end"}, 1)


PARALLEL = """
joints: {O: [0, 0], C: [1, 0], D: [2, 0]}
bars:
  crank: {joints: [O, A], length: 0.3}
  second: {joints: [C, B], length: 0.3}
  third: {joints: [D, E], length: 0.3}
  coupler: {points: {A: [0, 0], B: [1, 0], E: [2, 0]}}
drives: {crank: {angle: 1, speed: 1}}
"""


def test_what_is_left_over_stays_with_the_loop_that_it_closes():
    topology = build_topology(mechanism(PARALLEL))
    assert [b.surplus for b in topology.solved_blocks] == [0, 1]
    last = topology.solved_blocks[1]
    assert (last.kind, len(last.unknowns), len(last.loops)) == ("N", 1, 1)
    assert last.title == "group of 1 loop with 1 redundant equation"
    assert len(topology.redundant) == 1
    assert topology.mobility == 0


SCRIPT = """
import sys
from linkages.components.mechanisms.definition import from_document
from linkages.reading.document import parse
from linkages.topology.topology import build_topology
topology = build_topology(from_document(parse(sys.argv[1], "m.yaml")))
print(topology.redundant, topology.blocks, topology.placing, topology.entry)
"""


@pytest.mark.slow
def test_what_is_left_over_is_the_same_in_every_process():
    """There are several largest matchings; sets of texts must not decide among them."""
    found = {
        subprocess.run(
            [sys.executable, "-c", SCRIPT, PARALLEL],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "2", "3", "4")
    }
    assert len(found) == 1
