"""Order in which positions are solved: the block-triangular form of the point equations.

Every moving point has two coordinates, and every body at most one unknown coordinate. Each time a
point lies on a body, two scalar equations hold. A largest matching of equations and unknowns
directs their bipartite graph; its strongly connected components are the smallest groups of bodies
that must be solved together (Assur groups). Points are unknowns too, so that pins shared by several
bodies need no special treatment.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Container, Iterable, Mapping
from dataclasses import dataclass, replace

import networkx as nx

from linkages.components.contributed.load_measures import GROUND, Revolute, Turn, revolute_pairs
from linkages.components.contributed.terms import GUIDED, Parameter, Relation
from linkages.components.mechanisms.mechanism import Mechanism


def bodies_at(mechanism: Mechanism) -> dict[str, tuple[str, ...]]:
    """Joint → the bodies that meet there: the ground first, then in the order of the file."""
    return mechanism.meeting


def shared_pins(mechanism: Mechanism) -> tuple[tuple[str, str], ...]:
    """Joint and body, for each of the three bodies or more that meet at some joints."""
    meeting = ((joint, solid(mechanism, names)) for joint, names in bodies_at(mechanism).items())
    return tuple((joint, body) for joint, names in meeting if len(names) > 2 for body in names)


def solid(mechanism: Mechanism, names: Iterable[str]) -> tuple[str, ...]:
    """The ground and bodies, without those that stand for coordinates of points."""
    bodies = mechanism.bodies
    return tuple(n for n in names if n not in bodies or bodies[n].kind != GUIDED)


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
    """What the orientation of a body depends on."""

    masters: tuple[str, ...]  # the bodies with an angle of their own that it depends on
    # Whether it is the angle of its only master plus a constant (or a constant, without one)
    rigid: bool
    moved: tuple[str, ...]


def followers_of(mechanism: Mechanism) -> dict[str, Relation]:
    """Bodies whose coordinate follows from those of others, with the relation that says how.

    None of them is driven or free, or follows twice: `Mechanism` refuses that.
    """
    return {relation.body: relation for relation in mechanism.relations}


def is_unit(ratio: Parameter) -> bool:
    """Whether a ratio is structure: a body that turns with another as if fixed to it."""
    return ratio.value == 1.0 and not ratio.kept


def leaders_first(
    names: Iterable[str], leaders: Callable[[str], Iterable[str]], known: Container[str] = ()
) -> list[str]:
    """Bodies after all those that they follow; none that is known, nor what only those follow.

    Chains of welds and gears have thousands of bodies, and recursion ends at a few hundred.
    """
    result: dict[str, None] = {}
    for name in names:
        stack = [name]
        while stack:
            own = stack[-1]
            if own in result or own in known:
                stack.pop()
            elif missing := [o for o in leaders(own) if o not in result and o not in known]:
                stack += missing
            else:
                result[stack.pop()] = None
    return list(result)


def orientations(mechanism: Mechanism, followers: dict[str, Relation]) -> dict[str, Orientation]:
    """Orientation of every body."""
    result: dict[str, Orientation] = {}

    def leaders(name: str) -> list[str]:
        guide = mechanism.bodies[name].guide
        others = [other for other, _ in followers[name].parts] if name in followers else []
        return others if guide is None or guide.body is None else [*others, guide.body]

    def combined(relation: Relation) -> Orientation:
        others = [result[other] for other, _ in relation.parts]
        moved = tuple(dict.fromkeys(m for other in others for m in other.moved))
        turn = all(mechanism.bodies[name].rotates for name, _ in relation.parts)
        unit = turn and all(is_unit(ratio) for _, ratio in relation.parts)
        rigid = unit and len(others) <= 1 and all(other.rigid for other in others)
        return Orientation(moved, rigid, moved)

    for name in leaders_first(mechanism.bodies, leaders):
        guide = mechanism.bodies[name].guide
        follows = combined(followers[name]) if name in followers else None
        own = Orientation((name,), rigid=True, moved=(name,)) if follows is None else follows
        if guide is None:
            result[name] = own
        elif guide.body is None:
            result[name] = Orientation((), rigid=True, moved=own.moved)
        else:
            result[name] = replace(result[guide.body], moved=own.moved)
    return {name: result[name] for name in mechanism.bodies}


def turned_bodies(mechanism: Mechanism) -> set[str]:
    """Bodies whose angle counts with its whole turns, for a spring or a relation depends on it."""
    result = {name for turn in mechanism.wound for name in turn.bodies}
    ended = (end.measure for end in mechanism.ends)
    result |= {name for turn in ended if isinstance(turn, Turn) for name in turn.bodies}
    result |= {turn.body for turn in mechanism.lifting}
    for relation in mechanism.relations:
        tied = [relation.body, *(name for name, _ in relation.parts)]
        turning = {name for name in tied if mechanism.bodies[name].rotates}
        if len(turning) < len(tied) or not all(is_unit(ratio) for _, ratio in relation.parts):
            result |= turning
    return result


Unknown = tuple[str, str, str]
Equation = tuple[str, str, str, str]


class StructureError(Exception):
    """Bodies with more unknowns than equations (`surplus`), joints with fewer (`contested`)."""

    def __init__(self, surplus: Collection[str], contested: Collection[str]) -> None:
        super().__init__(surplus, contested)
        self.surplus = tuple(surplus)
        self.contested = tuple(contested)


@dataclass(frozen=True)
class Group:
    """Bodies that are placed together."""

    bodies: tuple[str, ...]  # in the order of the mechanism
    # Bodies whose own coordinate this group determines, in the order of the mechanism
    unknowns: tuple[str, ...]
    # Those among them that have been placed before, by their pin: their axis point follows
    sliding: tuple[str, ...] = ()


@dataclass(frozen=True)
class Order:
    """The groups in an order in which they can be solved."""

    groups: tuple[Group, ...]  # earliest first
    # Joints at which more equations hold than unknowns are left: they hold by themselves, or the
    # mechanism cannot move
    redundant: tuple[str, ...]


def solution_order(
    mechanism: Mechanism,
    known: Collection[str],
    orientations: Mapping[str, Orientation],
    whole: bool = False,
) -> Order:
    """Groups of bodies in an order in which their positions can be solved.

    `whole`: solve as a whole all that has more equations than unknowns, because structure alone
    does not tell which of them are redundant.
    """
    incidence, equations = _incidence(mechanism, known, orientations)
    matching = _matching(incidence, equations)
    unmatched = [equation for equation in equations if equation not in matching]
    unknowns = [node for node in incidence if node not in equations]
    loose = [unknown for unknown in unknowns if unknown not in matching]
    over = _alternating(incidence, matching, unmatched)
    pins = {joint for body in mechanism.bodies.values() for joint in body.points}
    pins -= set(mechanism.ground)
    contested = sorted({node[1] for node in over if node[0] == "at"} & pins)
    if loose:
        under = _alternating(incidence, matching, loose)
        surplus = {node[1] for node in under if node[0] in ("body", "coordinate")}
        raise StructureError(sorted(surplus), contested)
    together = [equation for equation in equations if whole and equation in over]
    groups = _groups(mechanism, incidence, equations, matching, unmatched, orientations, together)
    redundant = dict.fromkeys(equation[1] for equation in unmatched)
    return Order(tuple(groups), tuple(redundant))


def _matching(
    incidence: nx.Graph, equations: Collection[Equation]
) -> dict[Unknown | Equation, Unknown | Equation]:
    """A largest matching, the same in every process: sets of texts have an order of the day."""
    nodes = list(incidence)
    number = {node: index for index, node in enumerate(nodes)}
    numbered = nx.Graph()
    numbered.add_nodes_from(range(len(nodes)))
    numbered.add_edges_from((number[a], number[b]) for a, b in incidence.edges)
    tops = [number[equation] for equation in equations]
    result = nx.bipartite.hopcroft_karp_matching(numbered, tops)
    return {nodes[a]: nodes[b] for a, b in result.items()}


def _alternating(
    incidence: nx.Graph,
    matching: dict[Unknown | Equation, Unknown | Equation],
    start: list[Unknown] | list[Equation],
) -> set[Unknown | Equation]:
    """What alternating paths from unmatched nodes reach on their own side.

    It is the same for every largest matching (Dulmage and Mendelsohn, Can. J. Math. 10, 517, 1958).
    """
    reached: set[Unknown | Equation] = set(start)
    stack: list[Unknown | Equation] = list(start)
    while stack:
        for other in incidence[stack.pop()]:
            mate = matching.get(other)
            if mate is not None and mate not in reached:
                reached.add(mate)
                stack.append(mate)
    return reached


def _incidence(
    mechanism: Mechanism, known: Collection[str], orientations: Mapping[str, Orientation]
) -> tuple[nx.Graph, dict[Equation, None]]:
    """Bipartite graph of equations and unknowns; equations are at (point, body, axis)."""
    graph, known = nx.Graph(), frozenset(known)
    equations: dict[Equation, None] = {}
    for name in mechanism.bodies:
        if name not in known:
            graph.add_node(("coordinate", name, ""))
        for label in mechanism.labels(name):
            for axis in ("x", "y"):
                equation = ("at", label, name, axis)
                equations[equation] = None
                graph.add_edge(equation, ("body", name, axis))
                if label not in mechanism.anchors:
                    graph.add_edge(equation, ("joint", label, axis))
                for owner in _owners(mechanism, name, label, orientations):
                    if owner not in known:
                        graph.add_edge(equation, ("coordinate", owner, ""))
    return graph, equations


def _owners(
    mechanism: Mechanism, name: str, label: str, orientations: Mapping[str, Orientation]
) -> tuple[str, ...]:
    """Bodies whose own coordinates say where a point of a body is, relative to its place."""
    masters = orientations[name].masters
    body = mechanism.bodies[name]
    if body.rotates:
        return masters
    if label == body.axis:
        return (*orientations[name].moved, *masters)
    return () if label == next(iter(mechanism.attachments[name])) else masters


def _groups(
    mechanism: Mechanism,
    incidence: nx.Graph,
    equations: dict[Equation, None],
    matching: dict[Unknown | Equation, Unknown | Equation],
    unmatched: list[Equation],
    orientations: Mapping[str, Orientation],
    together: list[Equation],
) -> list[Group]:
    """Strongly connected components of 'needs the value of', earliest first, as bodies."""
    needs = nx.DiGraph()
    needs.add_nodes_from(equations)
    for equation in equations:
        for unknown in incidence[equation]:
            if matching[unknown] != equation:
                needs.add_edge(equation, matching[unknown])
    for kind, label, body, axis in unmatched:
        # solved together with the other component of the same vector equation
        partner = (kind, label, body, "y" if axis == "x" else "x")
        needs.add_edge(partner, (kind, label, body, axis))
    needs.add_edges_from(zip(together, together[1:] + together[:1], strict=True))
    turned = nx.DiGraph()  # `reverse` copies the names of all edges
    turned.add_nodes_from(needs)
    turned.add_edges_from((after, before) for before, after in needs.edges)
    condensed = nx.condensation(turned)
    position = {name: index for index, name in enumerate(mechanism.bodies)}

    def matched(component: int, *kinds: str) -> list[str]:
        """Bodies with an unknown of some kinds that equations of a component are matched to."""
        members = condensed.nodes[component]["members"]
        result = (matching[equation] for equation in members if equation in matching)
        return sorted({u[1] for u in result if u[0] in kinds}, key=position.__getitem__)

    def rank(component: int) -> int:
        bodies = matched(component, "body", "coordinate")
        return min((position[body] for body in bodies), default=-1)

    order = list(nx.lexicographical_topological_sort(condensed, key=rank))
    solved = {owner: step for step, c in enumerate(order) for owner in matched(c, "coordinate")}
    # x, y and the angle of a body may be components of their own: it stands in the last
    last = {body: step for step, c in enumerate(order) for body in matched(c, "body")}
    for body, orientation in orientations.items():
        needed = {*orientation.masters, *({*orientation.moved} - {body})}
        last[body] = max([last[body], *(solved[m] for m in needed if m in solved)])
    placed: dict[int, list[str]] = {}
    for body in mechanism.bodies:
        placed.setdefault(last[body], []).append(body)
    groups = []
    for step, component in enumerate(order):
        bodies = tuple(placed.get(step, ()))
        unknowns = tuple(matched(component, "coordinate"))
        sliding = tuple(name for name in unknowns if last[name] < step)
        if bodies or unknowns:
            groups.append(Group(bodies, unknowns, sliding))
    return groups
