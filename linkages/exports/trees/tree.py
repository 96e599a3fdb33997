"""A spanning tree of bodies, and the joints that are left over."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from linkages.components.contributed.terms import Displacement
from linkages.components.mechanisms.mechanism import Mechanism

WORLD = ""
"""The ground, among names of bodies."""


@dataclass(frozen=True)
class Pin:
    """Two bodies share a point, about which they turn."""

    joint: str
    one: str
    other: str


@dataclass(frozen=True)
class Rail:
    """A slider on the body that carries its axis."""

    slider: str
    carrier: str

    @property
    def one(self) -> str:
        """The first of its bodies."""
        return self.carrier

    @property
    def other(self) -> str:
        """The second one."""
        return self.slider


@dataclass(frozen=True)
class Gap:
    """A massless link from a joint of a body to a point of another one."""

    term: Displacement
    one: str
    other: str


Joining = Pin | Rail | Gap
"""What joins two bodies."""


@dataclass(frozen=True)
class Branch:
    """A body of the tree, on another one."""

    body: str
    parent: str
    joining: Joining


@dataclass(frozen=True)
class Tree:
    """Bodies in an order in which each follows the one that it stands on, and loops.

    Parameters
    ----------
    branches
        All bodies.
    loops
        Pins that the tree has not.
    """

    branches: tuple[Branch, ...]
    loops: tuple[Pin, ...]

    def path(self, body: str) -> list[Branch]:
        """Branches from the ground to a body."""
        known = {branch.body: branch for branch in self.branches}
        found: list[Branch] = []
        while body != WORLD:
            found.insert(0, known[body])
            body = known[body].parent
        return found


def tree_of(mechanism: Mechanism) -> Tree:
    """The tree of a mechanism; rails and gaps come before pins, for only pins can close loops.

    Raises
    ------
    InputError
        If links of clearances close loops among themselves.
    """
    group = {name: name for name in (WORLD, *mechanism.bodies)}

    def root(body: str) -> str:
        while group[body] != body:
            body = group[body]
        return body

    beside: dict[str, list[Joining]] = {name: [] for name in group}
    loops: list[Pin] = []
    for joining in _joinings(mechanism):
        one, other = root(joining.one), root(joining.other)
        if one != other:
            group[one] = other
            beside[joining.one].append(joining)
            beside[joining.other].append(joining)
        elif isinstance(joining, Pin):
            loops.append(joining)
        else:
            name = joining.slider if isinstance(joining, Rail) else joining.term.name
            message = f"{name} closes a loop that has no revolute joint to be opened at"
            raise mechanism.error([((), message)])
    branches: list[Branch] = []
    reached = [WORLD]
    for body in reached:
        for joining in beside[body]:
            child = joining.one if joining.other == body else joining.other
            if child not in reached:
                branches.append(Branch(child, body, joining))
                reached.append(child)
    return Tree(tuple(branches), tuple(loops))


def _joinings(mechanism: Mechanism) -> Iterator[Joining]:
    links = {link.name for term in mechanism.displacements for link in term.links}
    bodies = {name: body for name, body in mechanism.bodies.items() if name not in links}
    for name, body in bodies.items():
        if body.guide is not None:
            yield Rail(name, body.guide.body or WORLD)
    owners: dict[str, list[str]] = {joint: [WORLD] for joint in mechanism.ground}
    for name, body in bodies.items():
        for joint in body.points:
            owners.setdefault(joint, []).append(name)
    for term in mechanism.displacements:
        yield Gap(term, owners[term.joint][0], term.body)
    for joint, names in owners.items():
        for other in names[1:]:
            yield Pin(joint, names[0], other)
