"""A mechanism ready to be computed: topology, equations, assembly mode and initial state."""

from __future__ import annotations

import copy
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import combinations, islice

import numpy as np
from numpy.typing import NDArray

from linkages.components.free import FreeAngle
from linkages.components.mechanism import Mechanism
from linkages.components.revolute import GROUND
from linkages.components.terms import Body, point_words
from linkages.errors import InputError
from linkages.kernel.assembly import SeveralPlacesError, assemble
from linkages.kernel.evaluator import Evaluator
from linkages.kernel.model import Model
from linkages.kernel.modes import Assembly, Place, all_modes, parameter_values
from linkages.kernel.redundancy import require_consistent
from linkages.kernel.scalars import Scalar
from linkages.reading.wording import TOO_LARGE
from linkages.topology.explanation import explained
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
    time
        Time of the initial state in seconds.
    near
        Point → about where it is then, shape (2,); taken instead of the hints of the definition.

    Raises
    ------
    InputError
        If the mobility is wrong or the mechanism cannot be assembled.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        time: float = 0.0,
        near: Mapping[str, NDArray[np.float64]] | None = None,
    ) -> None:
        self.mechanism = choose_free(mechanism)
        self.time = time
        self.chosen = tuple(
            name for name in self.mechanism.initial if name not in mechanism.initial
        )
        self.topology: Topology = build_topology(self.mechanism)
        try:
            self._assemble(near)
        except InputError as error:
            if not self.topology.redundant:
                raise
            # which equations are redundant shows in numbers only: solve all of them together
            self.topology = build_topology(self.mechanism, whole=True)
            try:
                self._assemble(near)
            except SeveralPlacesError:
                raise
            except InputError:
                raise explained(self.mechanism, error) from None

    def _assemble(self, near: Mapping[str, NDArray[np.float64]] | None) -> None:
        self.model = Model(self.topology)
        self._place = Place(self.model, self.time, self._given())
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            self.assembly: Assembly = assemble(self._place, near)
            self.state: NDArray[np.float64] = self._settled(self.assembly)
            self._require_places()
            require_consistent(self)
            if near is None:
                self._require_loads()

    def _require_places(self) -> None:
        """Make sure that all points are somewhere."""
        for point, place in self.places().items():
            if not np.isfinite(place).all():
                message = f"the place of {point_words(point)} is not a finite number. {TOO_LARGE}"
                raise self.mechanism.error([((), message)])

    def _require_loads(self) -> None:
        """Loads must have a value at the start, as the laws of drives must."""
        found = []
        for load in self.model.loads:
            if not np.isfinite(self._place.values(load.given, self.assembly)).all():
                message = f"cannot act at t = {self.time:g} s: {load.undefined}"
                found.append((load.load.path, message))
        if found:
            raise self.mechanism.error(dict.fromkeys(found))  # both axes of a force say the same

    def _given(self) -> NDArray[np.float64]:
        """Free coordinates and their rates as they are given; zero for those carried along."""
        initial = [self.mechanism.initial[name] for name in self.topology.free]
        carried = [0.0] * len(self.topology.carried)
        positions, speeds = [i.position for i in initial], [i.speed for i in initial]
        return np.array([*positions, *carried, *speeds, *carried])

    def _settled(self, assembly: Assembly) -> NDArray[np.float64]:
        """The initial state of all integrated coordinates."""
        state = self._place.state(assembly)
        count, carried = len(self.topology.coordinates), len(self.topology.carried)
        if carried:
            values = self._place.values(self.model.settled, assembly)
            state[count - carried : count] = values[:carried]
            state[2 * count - carried :] = values[carried:]
        return state

    def at(self, time: float, state: NDArray[np.float64], flipped: Collection[int] = ()) -> System:
        """The same mechanism at another time and state, with some blocks in their other mode."""
        found = copy.copy(self)
        found.time, found.state = time, state
        sides = {b: -s if b in flipped else s for b, s in self.assembly.sides.items()}
        found.assembly = replace(self.assembly, sides=sides)
        return found

    def modes(self) -> list[Assembly]:
        """All assembly modes at the initial values of drives and free coordinates."""
        return all_modes(self._place)

    def in_mode(self, assembly: Assembly) -> dict[str, NDArray[np.float64]]:
        """Point → position in an assembly mode at the initial state, shape (2,)."""
        joints = self.model.positions.joints
        nodes = [node for place in joints.values() for node in (place.x, place.y)]
        values = np.array(self._place.values(nodes, assembly)).reshape(-1, 2)
        return dict(zip(joints, values, strict=True))

    def evaluate(
        self,
        nodes: Sequence[Scalar],
        time: NDArray[np.float64] | float | None = None,
        state: NDArray[np.float64] | None = None,
        acceleration: NDArray[np.float64] | None = None,
        flipped: Mapping[int, NDArray[np.bool_]] | None = None,
    ) -> NDArray[np.float64]:
        """Values of nodes of the model, shape (nodes, times).

        Parameters
        ----------
        nodes
            Nodes of `model`.
        time
            Shape (times,), seconds; that of the initial state if not given.
        state
            Shape (2n, times): integrated coordinates, then their rates; the initial state if not
            given.
        acceleration
            Shape (n, times).
        flipped
            Block → where it is in its other assembly mode, shape (times,).
        """
        times = np.atleast_1d(np.asarray(self.time if time is None else time, dtype=float))
        if state is None:
            state = self.state[:, None]
        count = len(self.topology.coordinates)
        accelerations = np.zeros((count, 1)) if acceleration is None else acceleration
        parameters: NDArray[np.float64] = parameter_values(self.model, self.assembly)
        if flipped:
            parameters = np.repeat(parameters[:, None], len(times), axis=1)
            paths = list(self.model.inputs.parameters)
            for block, where in flipped.items():
                parameters[paths.index(("side", block)), where] *= -1.0
        values = Evaluator(nodes)(t=times[None], y=state, a=accelerations, p=parameters)
        result = np.empty((len(nodes), len(times)))
        for row, value in zip(result, values, strict=True):
            row[:] = value
        return result

    def places(self) -> dict[str, NDArray[np.float64]]:
        """Point → position at the initial state, shape (2,)."""
        return self.in_mode(self.assembly)

    @property
    def axes(self) -> dict[str, NDArray[np.float64]]:
        """Slider → unit vector of its axis at the initial state."""
        sliders = [name for name, body in self.mechanism.bodies.items() if not body.rotates]
        units = [self.model.positions.unit(name) for name in sliders]
        nodes = [node for unit in units for node in (unit.x, unit.y)]
        return dict(zip(sliders, self.evaluate(nodes).reshape(-1, 2), strict=True))

    @cached_property
    def jacobian(self) -> NDArray[np.float64]:
        """The closure Jacobian at the initial state, columns scaled to unit length."""
        return closure_jacobian(self.topology, self.places(), self.axes)

    @property
    def conditions(self) -> list[float]:
        """Condition number of each block at the initial state."""
        return [
            block_condition(self.topology, self.jacobian, block)
            for block in self.topology.solved_blocks
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
    needed = gruebler_mobility(mechanism) - known
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
    followers = (relation.body for relation in mechanism.relations)
    taken = body.name in {*mechanism.prescribed, *mechanism.initial, *followers}
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
