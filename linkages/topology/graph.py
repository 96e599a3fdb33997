"""The topology graph (bodies are nodes, joints are edges), and orientations of bodies."""

from __future__ import annotations

from dataclasses import dataclass, replace

import networkx as nx

from linkages.components.contributed.load_measures import GROUND, Revolute, Turn, revolute_pairs
from linkages.components.contributed.terms import Parameter, Relation
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


@dataclass(frozen=True)
class Orientation:
    """What the orientation of a body depends on.

    Parameters
    ----------
    masters
        The bodies with an angle of their own that it depends on.
    rigid
        Whether it is the angle of its only master plus a constant (or a constant, without one).
    moved
        The bodies with a coordinate of their own that the body's coordinate depends on: of one that
        turns the same, of one that slides itself, unless its displacement follows from others.
    """

    masters: tuple[str, ...]
    rigid: bool
    moved: tuple[str, ...]


def slaves(mechanism: Mechanism) -> dict[str, Relation]:
    """Bodies whose coordinate follows from those of others, with the relation that says how.

    None of them is driven or free, or follows twice: `Mechanism` refuses that.
    """
    return {relation.body: relation for relation in mechanism.relations}


def is_unit(ratio: Parameter) -> bool:
    """Whether a ratio is structure: a body that turns with another as if fixed to it."""
    return ratio.value == 1.0 and not ratio.kept


def orientations(mechanism: Mechanism, followers: dict[str, Relation]) -> dict[str, Orientation]:
    """Orientation of every body."""
    found: dict[str, Orientation] = {}

    def orientation(name: str) -> Orientation:
        if name not in found:
            guide = mechanism.bodies[name].guide
            follows = combined(followers[name]) if name in followers else None
            own = Orientation((name,), rigid=True, moved=(name,)) if follows is None else follows
            if guide is None:
                found[name] = own
            elif guide.body is None:
                found[name] = Orientation((), rigid=True, moved=own.moved)
            else:
                found[name] = replace(orientation(guide.body), moved=own.moved)
        return found[name]

    def combined(relation: Relation) -> Orientation:
        others = [orientation(other) for other, _ in relation.parts]
        moved = tuple(dict.fromkeys(m for other in others for m in other.moved))
        turn = all(mechanism.bodies[name].rotates for name, _ in relation.parts)
        unit = turn and all(is_unit(ratio) for _, ratio in relation.parts)
        rigid = unit and len(others) <= 1 and all(other.rigid for other in others)
        return Orientation(moved, rigid, moved)

    return {name: orientation(name) for name in mechanism.bodies}


def turned_bodies(mechanism: Mechanism) -> set[str]:
    """Bodies whose angle counts with its whole turns, for a spring or a relation depends on it."""
    found = {name for load in mechanism.loads for name in load.turned}
    ended = (end.measure for end in mechanism.ends)
    found |= {name for turn in ended if isinstance(turn, Turn) for name in turn.bodies}
    for relation in mechanism.relations:
        tied = [relation.body, *(name for name, _ in relation.parts)]
        turning = {name for name in tied if mechanism.bodies[name].rotates}
        if len(turning) < len(tied) or not all(is_unit(ratio) for _, ratio in relation.parts):
            found |= turning
    return found
