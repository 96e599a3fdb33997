"""The order in which positions are solved: block-triangular form of the point equations.

Every moving joint has two coordinates, every body has a place and, unless driven or free, one
unknown coordinate. Each time a joint lies on a body, two scalar equations hold. A perfect matching
of equations and unknowns directs their bipartite graph; its strongly connected components are the
smallest groups of bodies that must be solved together (Assur groups), whatever loops are chosen
later. Pins shared by several bodies need no special treatment, because joints are unknowns too.
"""

from __future__ import annotations

from collections.abc import Collection

import networkx as nx

from linkages.components.mechanism import Mechanism
from linkages.components.terms import Body

Unknown = tuple[str, str, str]
Equation = tuple[str, str, str, str]


class StructureError(Exception):
    """Equations and unknowns cannot be matched one to one.

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


def solution_order(mechanism: Mechanism, known: Collection[str]) -> list[tuple[str, ...]]:
    """Groups of bodies in an order in which their positions can be solved.

    Parameters
    ----------
    mechanism
        Its bodies keep the order of the file within a group and, where possible, among groups.
    known
        Bodies whose coordinate is driven or free.

    Raises
    ------
    StructureError
        If the mechanism is not exactly determined by the known coordinates.
    """
    incidence, equations = _incidence(mechanism, known)
    matching = nx.bipartite.hopcroft_karp_matching(incidence, equations)
    unmatched = [equation for equation in equations if equation not in matching]
    unknowns = [node for node in incidence if node not in equations]
    loose = [unknown for unknown in unknowns if unknown not in matching]
    if unmatched or loose:
        under = _alternating(incidence, matching, loose)
        over = _alternating(incidence, matching, unmatched)
        surplus = {node[1] for node in under if node[0] in ("body", "coordinate")}
        contested = {node[1] for node in over if node[0] == "at"} - set(mechanism.ground)
        raise StructureError(sorted(surplus), sorted(contested))
    return _body_groups(mechanism, incidence, equations, matching)


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
    mechanism: Mechanism, known: Collection[str]
) -> tuple[nx.Graph, dict[Equation, None]]:
    """Bipartite graph of equations and unknowns; equations are at (joint, body, axis)."""
    graph = nx.Graph()
    equations: dict[Equation, None] = {}
    for body in mechanism.bodies.values():
        graph.add_nodes_from(_own_unknowns(body, known))
        for joint in body.points:
            for axis in ("x", "y"):
                equation = ("at", joint, body.name, axis)
                equations[equation] = None
                graph.add_node(equation)
                if joint not in mechanism.ground:
                    graph.add_edge(equation, ("joint", joint, axis))
                for unknown in _own_unknowns(body, known):
                    if unknown[2] in (axis, ""):
                        graph.add_edge(equation, unknown)
    return graph, equations


def _own_unknowns(body: Body, known: Collection[str]) -> list[Unknown]:
    place = [("body", body.name, "x"), ("body", body.name, "y")] if body.rotates else []
    return place if body.name in known else [*place, ("coordinate", body.name, "")]


def _body_groups(
    mechanism: Mechanism,
    incidence: nx.Graph,
    equations: dict[Equation, None],
    matching: dict[Unknown | Equation, Unknown | Equation],
) -> list[tuple[str, ...]]:
    """Strongly connected components of 'needs the value of', earliest first, as bodies."""
    needs = nx.DiGraph()
    needs.add_nodes_from(equations)
    for equation in equations:
        for unknown in incidence[equation]:
            if matching[unknown] != equation:
                needs.add_edge(matching[unknown], equation)
    condensed = nx.condensation(needs)
    position = {name: index for index, name in enumerate(mechanism.bodies)}

    def determined(component: int) -> list[str]:
        """Bodies with an unknown that the equations of this component are matched to."""
        members = (matching[equation] for equation in condensed.nodes[component]["members"])
        return sorted({u[1] for u in members if u[0] != "joint"}, key=position.__getitem__)

    def rank(component: int) -> int:
        return min((position[body] for body in determined(component)), default=-1)

    order = nx.lexicographical_topological_sort(condensed, key=rank)
    groups = [determined(component) for component in order]
    # x and y of a body with a known angle are components of their own: it stands in the later
    last = {body: index for index, group in enumerate(groups) for body in group}
    kept = [tuple(b for b in group if last[b] == index) for index, group in enumerate(groups)]
    immediate = [(body,) for body in mechanism.bodies if body not in last]
    return [*immediate, *(group for group in kept if group)]
