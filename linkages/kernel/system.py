"""A mechanism ready to be computed: topology, equations, assembly mode and initial state."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from itertools import combinations, islice

import numpy as np
from numpy.typing import NDArray

from linkages.components.free import FreeAngle
from linkages.components.mechanism import Mechanism
from linkages.components.revolute import GROUND
from linkages.components.terms import Body
from linkages.errors import InputError
from linkages.kernel.assembly import assemble, parameter_values
from linkages.kernel.model import Model
from linkages.kernel.scalars import Evaluator, Scalar
from linkages.topology.graph import gruebler_mobility, topology_graph, unreachable_bodies
from linkages.topology.jacobian import block_condition, closure_jacobian
from linkages.topology.topology import Topology, build_topology

MOST_CHOICES = 200
"""How many sets of free coordinates are tried where the file names none."""


class System:
    """Everything about a mechanism that does not depend on how it is solved.

    Parameters
    ----------
    mechanism
        Free coordinates that it does not name are chosen (see `choose_free`).

    Raises
    ------
    InputError
        If the mobility is wrong or the mechanism cannot be assembled.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = choose_free(mechanism)
        self.chosen = tuple(
            name for name in self.mechanism.initial if name not in mechanism.initial
        )
        self._assemble()

    def _assemble(self) -> None:
        self.topology: Topology = build_topology(self.mechanism)
        self.model = Model(self.topology)
        initial = [self.mechanism.initial[name] for name in self.topology.free]
        self.state: NDArray[np.float64] = np.array(
            [term.position for term in initial] + [term.speed for term in initial], dtype=float
        )
        self.sides, self.assumed = assemble(self.model, self.state)

    def evaluate(
        self,
        nodes: Sequence[Scalar],
        time: NDArray[np.float64] | float = 0.0,
        state: NDArray[np.float64] | None = None,
        acceleration: NDArray[np.float64] | None = None,
    ) -> NDArray[np.float64]:
        """Values of nodes of the model, shape (nodes, times).

        Parameters
        ----------
        nodes
            Nodes of `model`.
        time
            Shape (times,), seconds.
        state
            Shape (2n, times): free coordinates, then their rates; the initial state if not given.
        acceleration
            Shape (n, times).
        """
        times = np.atleast_1d(np.asarray(time, dtype=float))
        if state is None:
            state = self.state[:, None]
        count = len(self.topology.free)
        accelerations = np.zeros((count, 1)) if acceleration is None else acceleration
        parameters = parameter_values(self.model, self.sides)
        values = Evaluator(nodes)(t=times[None], y=state, a=accelerations, p=parameters)
        result = np.empty((len(nodes), len(times)))
        for row, value in zip(result, values, strict=True):
            row[:] = value
        return result

    def places(self, time: float = 0.0) -> dict[str, NDArray[np.float64]]:
        """Joint → position at the initial state, shape (2,)."""
        joints = self.model.positions.joints
        nodes = [node for place in joints.values() for node in (place.x, place.y)]
        values = self.evaluate(nodes, time)[:, 0].reshape(-1, 2)
        return dict(zip(joints, values, strict=True))

    @property
    def axes(self) -> dict[str, NDArray[np.float64]]:
        """Slider → unit vector of its axis."""
        guides = {n: b.guide for n, b in self.mechanism.bodies.items() if b.guide is not None}
        angles = {name: guide.angle.value for name, guide in guides.items()}
        return {name: np.array([np.cos(angle), np.sin(angle)]) for name, angle in angles.items()}

    @cached_property
    def jacobian(self) -> NDArray[np.float64]:
        """The closure Jacobian at the initial state, columns scaled to unit length."""
        return closure_jacobian(self.topology, self.places(), self.axes)

    @property
    def conditions(self) -> list[float]:
        """Condition number of each block at the initial state."""
        return [
            block_condition(self.topology, self.jacobian, block, index)
            for index, block in enumerate(self.topology.solved_blocks)
        ]


def choose_free(mechanism: Mechanism) -> Mechanism:
    """Add the free coordinates that the definition does not name.

    Clearances are always free. Beyond them, ground-connected bars are taken whose position at
    t = 0 follows from the `assembly` section; among all possible choices the one with the
    best-conditioned closure, at rest.

    Raises
    ------
    InputError
        If there are choices but none of them can be assembled: what the first one lacks.
    """
    graph = topology_graph(mechanism)
    known = len(mechanism.prescribed) + len(mechanism.initial)
    needed = gruebler_mobility(graph) - known
    if needed <= 0 or unreachable_bodies(graph):
        return mechanism
    candidates = [c for body in mechanism.bodies.values() if (c := _candidate(mechanism, body))]
    best: tuple[float, Mechanism] | None = None
    refusal: InputError | None = None
    for choice in islice(combinations(candidates, needed), MOST_CHOICES):
        completed = mechanism
        for component in choice:
            completed = completed.with_component(component)
        try:
            system = System(completed)
        except InputError as error:
            refusal = refusal or error
            continue
        worst = max(system.conditions, default=1.0)
        if best is None or worst < best[0] * (1 - 1e-9):
            best = (worst, completed)
    if best is None and refusal is not None:
        raise refusal
    return mechanism if best is None else best[1]


def _candidate(mechanism: Mechanism, body: Body) -> FreeAngle | None:
    """The angle of a bar on the ground, if the place of another of its joints is known.

    A point that a clearance displaces is as good as at its joint.
    """
    taken = body.name in mechanism.prescribed or body.name in mechanism.initial
    pins = [joint for joint in body.points if joint in mechanism.ground]
    links = (link for link in mechanism.bodies.values() if link.kind == "clearance")
    beside = {displaced: joint for joint, displaced in (link.points for link in links)}
    hints = [(j, mechanism.hints.get(beside.get(j, j))) for j in body.points if j not in pins]
    places = [(j, hint.position) for j, hint in hints if hint is not None and hint.position]
    if taken or not body.rotates or not pins or not places or body.name == GROUND:
        return None
    joint, place = places[0]
    origin = [value.value for value in mechanism.ground[pins[0]]]
    pin, point = ([value.value for value in body.points[j]] for j in (pins[0], joint))
    direction = np.arctan2(place[1] - origin[1], place[0] - origin[0])
    own = np.arctan2(point[1] - pin[1], point[0] - pin[0])
    return FreeAngle(name=body.name, angle=float(direction - own))
