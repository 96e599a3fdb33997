"""The topology graph: bodies are nodes, joints are edges."""

from __future__ import annotations

import networkx as nx

from linkages.components.contributed.revolute import GROUND, Revolute, revolute_pairs
from linkages.components.mechanisms.mechanism import Mechanism


def bodies_at(mechanism: Mechanism) -> dict[str, tuple[str, ...]]:
    """Joint → the bodies that meet there: the ground first, then in the order of the file."""
    meeting: dict[str, list[str]] = {joint: [GROUND] for joint in mechanism.ground}
    for body in mechanism.bodies.values():
        for joint in body.points:
            meeting.setdefault(joint, []).append(body.name)
    return {joint: tuple(names) for joint, names in meeting.items()}


def shared_pins(mechanism: Mechanism) -> tuple[tuple[str, str], ...]:
    """Joint and body, for each of the three bodies or more that meet at some joints."""
    meeting = bodies_at(mechanism).items()
    return tuple((joint, body) for joint, names in meeting if len(names) > 2 for body in names)


def single_joints(mechanism: Mechanism) -> dict[str, str]:
    """Joint that one body has only → that body; a ground joint that none uses is not one.

    Nor is a joint whose other body a clearance has displaced, or a place on the axis of a block.
    """
    meeting = bodies_at(mechanism).items()
    left = {term.joint for term in mechanism.displacements} | {GROUND}
    left |= {play.slider for play in mechanism.plays}
    return {j: first for j, (first, *others) in meeting if not others and not left & {j, first}}


def pairs(mechanism: Mechanism) -> tuple[Revolute, ...]:
    """All revolute pairs; a pin shared by k bodies gives k − 1."""
    return tuple(
        pair
        for joint, bodies in bodies_at(mechanism).items()
        for pair in revolute_pairs(joint, bodies)
    )


def topology_graph(mechanism: Mechanism) -> nx.MultiGraph:
    """Multigraph with an edge per revolute pair (key: joint) and per guide (key: slider)."""
    graph = nx.MultiGraph()
    graph.add_node(GROUND, kind="ground")
    for body in mechanism.bodies.values():
        graph.add_node(body.name, kind=body.kind)
    for pair in pairs(mechanism):
        graph.add_edge(pair.first, pair.second, key=pair.joint, kind="revolute")
    for body in mechanism.bodies.values():
        if body.guide is not None:
            carrier = mechanism.bearing(body) or GROUND
            graph.add_edge(carrier, body.name, key=body.name, kind="prismatic")
    return graph


def gruebler_mobility(mechanism: Mechanism) -> int:
    """Mobility 3·bodies − 2·pairs − relations (Chebychev, Grübler, Kutzbach).

    The ground does not count. Welds and gears are relations: each takes away one coordinate.
    """
    graph = topology_graph(mechanism)
    free = 3 * (graph.number_of_nodes() - 1) - 2 * graph.number_of_edges()
    return free - len(mechanism.relations)


def loop_count(graph: nx.MultiGraph) -> int:
    """Number of independent loops of a connected graph."""
    return graph.number_of_edges() - graph.number_of_nodes() + 1


def unreachable_bodies(graph: nx.MultiGraph) -> list[str]:
    """Bodies that no chain of joints connects to the ground."""
    reached = nx.node_connected_component(graph, GROUND)
    return [body for body in graph.nodes if body not in reached]
