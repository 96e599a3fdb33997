"""A spanning tree of bodies, and the joints that close loops."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.terms import Displacement
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.scalars import Scalar
from linkages.kernel.system import System

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
    """A slider, the other body, on the one that carries its axis."""

    one: str
    other: str


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
    """Bodies in an order in which each follows the one that it stands on, and loops."""

    branches: tuple[Branch, ...]  # all bodies
    loops: tuple[Pin, ...]  # pins that the tree has not

    def path(self, body: str) -> list[Branch]:
        """Branches from the ground to a body."""
        known = {branch.body: branch for branch in self.branches}
        result: list[Branch] = []
        while body != WORLD:
            result.insert(0, known[body])
            body = known[body].parent
        return result


def tree_of(mechanism: Mechanism) -> Tree:
    """The tree of a mechanism; rails and gaps come before pins, for only pins can close loops."""
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
            name = joining.other if isinstance(joining, Rail) else joining.term.name
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
            yield Rail(body.guide.body or WORLD, name)
    owners: dict[str, list[str]] = {joint: [WORLD] for joint in mechanism.ground}
    for name, body in bodies.items():
        for joint in body.points:
            owners.setdefault(joint, []).append(name)
    for term in mechanism.displacements:
        yield Gap(term, owners[term.joint][0], term.body)
    for joint, names in owners.items():
        for other in names[1:]:
            yield Pin(joint, names[0], other)


Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Frame:
    """The frame of a body at the start."""

    origin: Floats  # in the ground's frame, shape (2,)
    angle: float  # of its first axis
    speed: float  # at which it turns

    @property
    def axes(self) -> Floats:
        """Its axes as columns, shape (2, 2)."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        return np.array([[c, -s], [s, c]])

    def local(self, place: Floats) -> Floats:
        """A place of the ground's frame in this one, shape (2,)."""
        return np.asarray(self.axes.T @ (place - self.origin))


GROUND = Frame(np.zeros(2), 0.0, 0.0)


def frames_of(system: System) -> dict[str, Frame]:
    """Body, the ground among them → its frame."""
    model, mechanism = system.model, system.mechanism
    names = list(mechanism.bodies)
    turning = [name for name in names if mechanism.bodies[name].rotates]
    angles = _values(system, {name: model.positions.angle(name) for name in turning})
    angles |= {name: float(np.arctan2(y, x)) for name, (x, y) in system.axes.items()}
    speeds = _values(system, {name: model.velocities.turning(name) for name in names})
    places = system.places()
    result = {WORLD: GROUND}
    for name, body in mechanism.bodies.items():
        joint, point = next(iter(body.points.items()))
        own = Frame(np.zeros(2), angles[name], speeds[name])
        local = np.array([number.value for number in point])
        result[name] = Frame(places[joint] - own.axes @ local, own.angle, own.speed)
    return result


def slides_of(system: System) -> dict[str, float]:
    """Slider → rate of its displacement at the start."""
    bodies = system.mechanism.bodies
    sliders = [name for name, body in bodies.items() if not body.rotates]
    return _values(system, {name: system.model.velocities.moving(name) for name in sliders})


def _values(system: System, nodes: dict[str, Scalar]) -> dict[str, float]:
    """Values at the start."""
    values = system.evaluate([*nodes.values()])[:, 0]
    return dict(zip(nodes, map(float, values), strict=True))
