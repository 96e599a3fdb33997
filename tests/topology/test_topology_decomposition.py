from dataclasses import replace
from itertools import permutations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkage_files import FOUR_BAR, NAMES, linkage, mechanism, truss

from linkages.components.rigid_bodies import Bar, Plate
from linkages.topology.decomposition import StructureError, orientations, solution_order
from linkages.topology.topology import build_topology


def reordered(mechanism, places):
    """The same mechanism with its bars and plates in another order of the file."""
    bars = [c for c in mechanism.components if isinstance(c, Bar | Plate)]
    others = [c for c in mechanism.components if not isinstance(c, Bar | Plate)]
    return replace(mechanism, components=(*others, *(bars[i] for i in places)))


def order(mechanism, known):
    """`solution_order` of a mechanism without welds and gears."""
    return solution_order(mechanism, known, orientations(mechanism, {}))


def blocks(mechanism):
    """What is solved together, whatever the order."""
    solved = build_topology(mechanism).solved_blocks
    return {(frozenset(b.unknowns), b.kind) for b in solved}


def bar_count(name):
    return sum(isinstance(c, Bar | Plate) for c in linkage(name).components)


@pytest.mark.parametrize("name", ["fourbar", "clearance", "slidercrank", "fivebar", "trammel"])
def test_blocks_do_not_depend_on_the_order_of_the_file(name):
    expected = blocks(linkage(name))
    for places in permutations(range(bar_count(name))):
        assert blocks(reordered(linkage(name), places)) == expected


@pytest.mark.slow_except("watt")
@pytest.mark.parametrize("name", ["watt", "stephenson", "ninebar"])
def test_blocks_of_larger_linkages_do_not_depend_on_the_order_of_the_file(name):
    expected = blocks(linkage(name))

    @settings(max_examples=40)
    @given(st.permutations(range(bar_count(name))))
    def check(places):
        topology = build_topology(reordered(linkage(name), places))
        assert {(frozenset(b.unknowns), b.kind) for b in topology.solved_blocks} == expected
        assert_solvable(topology)

    check()


def assert_solvable(topology):
    """Both ends of every loop, and every link between, are known when its turn comes."""
    known_joints = set(topology.mechanism.anchors)
    known_bodies = {*topology.driven, *topology.free}
    for block in topology.blocks:
        for loop in block.loops:
            for end in (loop.start, loop.end):
                assert end in known_joints
            for step in loop.steps:
                assert (step.body in known_bodies) != (step.body in block.unknowns)
        known_bodies |= set(block.unknowns)
        for body, entry, _ in block.placements:
            assert body in known_bodies
            assert entry in known_joints
            known_joints |= {j for j, by in topology.placing.items() if by == body}
    labels = {p for b in topology.mechanism.bodies for p in topology.mechanism.labels(b)}
    assert known_joints == {*topology.joints, *labels}
    assert known_bodies == set(topology.mechanism.bodies)


@pytest.mark.parametrize("name", NAMES)
def test_blocks_are_solvable_in_their_order(name):
    assert_solvable(build_topology(linkage(name)))


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("pendulum", []),
        ("doublependulum", []),
        ("fourbar", [("RRR", {"coupler", "rocker"})]),
        ("slidercrank", [("RRP", {"rod", "piston"})]),
        ("trammel", [("PP", {"across", "upright"})]),
        ("fivebar", [("RRR", {"left arm", "right arm"})]),
        ("watt", [("RRR", {"coupler", "rocker"}), ("RRR", {"tie", "arm"})]),
        ("stephenson", [("RRR", {"coupler", "rocker"}), ("RRR", {"tie", "arm"})]),
        (
            "ninebar",
            [
                ("RRR", {"link2", "link3"}),
                ("RRR", {"rocker6", "link7"}),
                ("RRP", {"link8", "slider9"}),
            ],
        ),
    ],
)
def test_kinds_of_blocks(name, expected):
    solved = build_topology(linkage(name)).solved_blocks
    assert [(b.kind, set(b.unknowns)) for b in solved] == expected
    assert [b.index for b in solved] == [*range(len(solved))]


@pytest.mark.parametrize("levels", [1, 2, 12])
def test_a_chain_of_dyads_stays_a_chain(levels):
    text = truss(levels) + "\ndrives: {b01: {angle: 0, speed: 1}}\n"
    found = order(mechanism(text), ["b01"])
    groups = [g.bodies for g in found.groups if g.bodies != ("b01",)]
    assert [len(group) for group in groups] == [2] * levels
    assert found.redundant == ()


@pytest.mark.parametrize("known", ["crank", "coupler", "rocker"])
def test_any_bar_of_a_four_bar_may_be_known(known):
    groups = [g.bodies for g in order(linkage("fourbar").ideal(), [known]).groups]
    others = {"crank", "coupler", "rocker"} - {known}
    # the known bar joins the others where they are needed to place it
    assert others <= {body for group in groups for body in group}
    assert any(others <= set(group) for group in groups)


def test_coordinates_that_nothing_determines_and_constraints_that_repeat():
    """Grübler's count is right in total, but one part has too much and another too little."""
    text = FOUR_BAR + "  tail: {joints: [B, T], length: 0.2}\n"
    with pytest.raises(StructureError) as caught:
        order(mechanism(text), ["crank", "rocker"])
    assert caught.value.surplus == ("tail",)
    assert caught.value.contested == ("A", "B")
