import networkx as nx
import pytest
from linkage_files import linkage, mechanism, truss

from linkages.components.contributed.load_measures import GROUND
from linkages.topology.decomposition import (
    bodies_at,
    gruebler_mobility,
    loop_count,
    pairs,
    topology_graph,
    unreachable_bodies,
)
from linkages.topology.topology import build_topology


@pytest.mark.parametrize(
    ("name", "mobility", "loops"),
    [
        ("pendulum", 1, 0),
        ("doublependulum", 2, 0),
        ("fourbar", 1, 1),
        ("clearance", 2, 1),
        ("slidercrank", 1, 1),
        ("trammel", 1, 1),
        ("fivebar", 2, 1),
        ("watt", 1, 2),
        ("stephenson", 1, 2),
        ("ninebar", 3, 3),
    ],
)
def test_mobility_and_loops(name, mobility, loops):
    topology = build_topology(linkage(name))
    assert (topology.mobility, topology.loops) == (mobility, loops)
    assert gruebler_mobility(topology.mechanism) == mobility
    assert loop_count(topology.graph) == loops
    # every loop closes in two equations, every body has one coordinate
    assert len(topology.mechanism.bodies) - 2 * loops == mobility


def test_ideal_nine_bar_has_two_degrees_of_freedom():
    topology = build_topology(linkage("ninebar").ideal())
    assert (topology.mobility, topology.loops) == (2, 3)


def test_each_clearance_adds_one_degree_of_freedom_and_no_loop():
    mobility = [gruebler_mobility(m) for m in (linkage("clearance").ideal(), linkage("clearance"))]
    assert mobility == [1, 2]


@pytest.mark.parametrize("count", [2, 3, 4, 7])
@pytest.mark.parametrize("grounded", [False, True])
def test_pin_shared_by_k_bodies_is_k_minus_1_pairs(count, grounded):
    pin = "O" if grounded else "A"
    bars = "".join(f"  bar{i}: {{joints: [{pin}, E{i}], length: 1}}\n" for i in range(count))
    meeting = pairs(mechanism(f"joints: {{O: [0, 0]}}\nbars:\n{bars}"))
    at_pin = [pair for pair in meeting if pair.joint == pin]
    assert len(at_pin) == count - 1 + grounded
    assert {p.first for p in at_pin} == {GROUND if grounded else "bar0"}


def test_nine_bar_pins():
    at = bodies_at(linkage("ninebar"))
    assert at == {
        "O": (GROUND, "crank1", "rocker6"),
        "D": (GROUND, "crank4"),
        "A": ("crank1", "link2"),
        "B": ("link2", "link3", "link7"),
        "C.r1": ("link3", "r1"),
        "C": ("crank4", "r1"),
        "E": ("rocker6", "link7", "link8"),
        "F": ("link8", "slider9"),
    }
    # 1+1 at O, 1 at D, 1 at A, 2 at B, 1 at each end of the clearance, 2 at E, 1 at F
    assert len(pairs(linkage("ninebar"))) == 11


def test_graph_of_a_slider_crank():
    graph = topology_graph(linkage("slidercrank"))
    edges = {
        (*sorted((a, b)), key, data["kind"])
        for a, b, key, data in graph.edges(keys=True, data=True)
    }
    assert edges == {
        ("crank", "ground", "O", "revolute"),
        ("crank", "rod", "A", "revolute"),
        ("piston", "rod", "B", "revolute"),
        ("ground", "piston", "piston", "prismatic"),
    }  # fmt: skip
    assert graph.nodes["piston"]["kind"] == "slider"
    assert graph.nodes[GROUND]["kind"] == "ground"


def test_two_pins_may_join_the_same_bodies():
    text = "joints: {O: [0, 0], C: [1, 0]}\nbars: {beam: {joints: [O, C], length: 1}}\n"
    beam = mechanism(text)
    graph = topology_graph(beam)
    assert graph.number_of_edges(GROUND, "beam") == 2
    assert (gruebler_mobility(beam), loop_count(graph)) == (-1, 1)


def test_unreachable_bodies():
    text = """
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 1}
  lost: {joints: [X, Y], length: 1}
  adrift: {joints: [Y, Z], length: 1}
"""
    assert unreachable_bodies(topology_graph(mechanism(text))) == ["lost", "adrift"]
    assert unreachable_bodies(topology_graph(linkage("ninebar"))) == []


@pytest.mark.parametrize("levels", [1, 3, 10])
def test_triangles_on_a_crank_move_as_one(levels):
    triangles = mechanism(truss(levels))
    graph = topology_graph(triangles)
    assert gruebler_mobility(triangles) == 1
    assert loop_count(graph) == levels
    assert loop_count(graph) == len(nx.cycle_basis(nx.Graph(graph))) + sum(
        graph.number_of_edges(a, b) - 1 for a, b in nx.Graph(graph).edges
    )
