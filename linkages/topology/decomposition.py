"""The order in which positions are solved: block-triangular form of the point equations.

Every moving point has two coordinates, every body has a place and, unless it is driven, free or
follows from others, one unknown coordinate. Each time a point lies on a body, two scalar equations
hold. A largest matching of equations and unknowns directs their bipartite graph; its strongly
connected components are the smallest groups of bodies that must be solved together (Assur groups),
whatever loops are chosen later. Pins shared by several bodies need no special treatment, because
points are unknowns too. Equations that no unknown is left for stay with the group that they close.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import networkx as nx

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.topology.graph import Orientation

Unknown = tuple[str, str, str]
Equation = tuple[str, str, str, str]


class StructureError(Exception):
    """Some coordinates follow from no equation.

    Parameters
    ----------
    surplus
        Bodies in the part that has more unknowns than equations.
    contested
        Moving joints in the part that has more equations than unknowns.
    """

    def __init__(self, surplus: Collection[str], contested: Collection[str]) -> None:
        super().__init__(surplus, contested)
        self.surplus = tuple(surplus)
        self.contested = tuple(contested)


@dataclass(frozen=True)
class Group:
    """Bodies that are placed together.

    Parameters
    ----------
    bodies
        In the order of the mechanism.
    unknowns
        Bodies whose own coordinate this group determines, in the order of the mechanism.
    sliding
        Those among them that have been placed before, by their pin: their axis point follows.
    """

    bodies: tuple[str, ...]
    unknowns: tuple[str, ...]
    sliding: tuple[str, ...] = ()


@dataclass(frozen=True)
class Order:
    """The groups in an order in which they can be solved.

    Parameters
    ----------
    groups
        Earliest first.
    redundant
        Joints at which more equations hold than unknowns are left: they hold by themselves, or the
        mechanism cannot move.
    """

    groups: tuple[Group, ...]
    redundant: tuple[str, ...]


def solution_order(
    mechanism: Mechanism,
    known: Collection[str],
    orientations: Mapping[str, Orientation],
    whole: bool = False,
) -> Order:
    """Groups of bodies in an order in which their positions can be solved.

    Parameters
    ----------
    whole
        Whether all that has more equations than unknowns is solved as a whole: which of its
        equations are the redundant ones is not a matter of structure alone.
    """
    incidence, equations = _incidence(mechanism, known, orientations)
    matching = _matching(incidence, equations)
    unmatched = [equation for equation in equations if equation not in matching]
    unknowns = [node for node in incidence if node not in equations]
    loose = [unknown for unknown in unknowns if unknown not in matching]
    over = _alternating(incidence, matching, unmatched)
    contested = sorted({node[1] for node in over if node[0] == "at"} & _pins(mechanism))
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
    found = nx.bipartite.hopcroft_karp_matching(numbered, tops)
    return {nodes[a]: nodes[b] for a, b in found.items()}


def _pins(mechanism: Mechanism) -> set[str]:
    return {j for b in mechanism.bodies.values() for j in b.points} - set(mechanism.ground)


def _alternating(
    incidence: nx.Graph,
    matching: dict[Unknown | Equation, Unknown | Equation],
    start: list[Unknown] | list[Equation],
) -> set[Unknown | Equation]:
    """What alternating paths from unmatched nodes reach on their own side.

    It is the over- or underdetermined part, the same for every largest matching
    (A. L. Dulmage and N. S. Mendelsohn, Can. J. Math. 10, 517, 1958), so that reports do not
    depend on which one was found.
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
    graph = nx.Graph()
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
    condensed = nx.condensation(needs.reverse())
    position = {name: index for index, name in enumerate(mechanism.bodies)}

    def matched(component: int, *kinds: str) -> list[str]:
        """Bodies with an unknown of some kinds that equations of a component are matched to."""
        members = condensed.nodes[component]["members"]
        found = (matching[equation] for equation in members if equation in matching)
        return sorted({u[1] for u in found if u[0] in kinds}, key=position.__getitem__)

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
    groups = []
    for step, component in enumerate(order):
        bodies = tuple(b for b in mechanism.bodies if last[b] == step)
        unknowns = tuple(matched(component, "coordinate"))
        sliding = tuple(name for name in unknowns if last[name] < step)
        if bodies or unknowns:
            groups.append(Group(bodies, unknowns, sliding))
    return groups
