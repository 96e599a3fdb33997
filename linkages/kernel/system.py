"""A mechanism ready to be computed: topology, equations, assembly branch and initial state."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.terms import point_words
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError
from linkages.kernel.assembly import SeveralPlacesError, assemble, possible_choices
from linkages.kernel.assembly_branches import (
    Assembly,
    Place,
    all_branches,
    assembled,
    require_consistent,
)
from linkages.kernel.dyads import LEAST_MARGIN, block_size
from linkages.kernel.inputs import Effects, definition_vector, structure_key
from linkages.kernel.layout import Layout
from linkages.kernel.lru_cache import LRUCache
from linkages.kernel.model import Model
from linkages.kernel.scalars import Scalar, components
from linkages.reading.wording import TOO_LARGE
from linkages.topology.assur_groups import ITERATED
from linkages.topology.decomposition import followers_of
from linkages.topology.topology import (
    Topology,
    block_conditions,
    build_topology,
    closure_jacobian,
    explained,
    numerical_mobility,
    owners,
)

if TYPE_CHECKING:
    from linkages.components.contributed.contact_laws import WithoutRoom
    from linkages.kernel.forces.contact_forces import GapNodes

DERIVED = ("parameters", "margin_scale", "jacobian", "conditions", "_placed")
"""What a system remembers of its numbers and its state."""

REGULAR = 1e6
"""Condition number up to which a block surely determines its unknowns."""

MOST_STRUCTURES = 64
"""Structures that a process remembers: a few MB each for mechanisms of twenty bodies."""


@dataclass(frozen=True, eq=False)
class Structure:
    """A topology with its equations."""

    key: tuple[Hashable, ...]  # equal for mechanisms that have all of this in common
    topology: Topology  # of the first mechanism of this structure, whose numbers do not count
    # Equations to evaluate; kernels are generated from others, so that their text does not depend
    # on what has been asked for before
    model: Model

    @cached_property
    def layout(self) -> Layout:
        """What stands where in the state of its systems."""
        return Layout.of(self.topology)


_TOPOLOGIES: LRUCache[Hashable, Topology] = LRUCache(MOST_STRUCTURES)
_STRUCTURES: LRUCache[Hashable, Structure] = LRUCache(MOST_STRUCTURES)


def structure_of(mechanism: Mechanism, whole: bool = False) -> Structure:
    """The structure of a mechanism whose free coordinates are all named."""
    key = (structure_key(mechanism.terms), whole)
    topology = _TOPOLOGIES.get(key, lambda: build_topology(mechanism, whole))
    groups = (block for block in topology.solved_blocks if block.kind == ITERATED)
    # sizes of groups that are solved by iteration stand in generated code
    sized = (*key, tuple(block_size(mechanism, block) for block in groups))

    def made() -> Structure:
        own = topology_of(topology, mechanism)
        return Structure(sized, own, Model(own))

    return _STRUCTURES.get(sized, made)


def topology_of(topology: Topology, mechanism: Mechanism) -> Topology:
    """The same topology for another mechanism of the structure."""
    followers = followers_of(mechanism) if topology.followers else {}
    return replace(topology, mechanism=mechanism, followers=followers)


Floats = NDArray[np.float64]


def given_state(topology: Topology, mechanism: Mechanism) -> Floats:
    """Free coordinates and their rates as they are given; zero for those carried along."""
    result = np.zeros((2, len(topology.coordinates)))
    for row, name in enumerate(topology.coordinates):
        if (own := mechanism.initial.get(name)) is not None:
            result[:, row] = own.position, own.speed
        elif name in mechanism.internal:
            result[1, row] = mechanism.internal[name].initial
    return result.ravel()


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
        self, mechanism: Mechanism, time: float = 0.0, near: Mapping[str, Floats] | None = None
    ) -> None:
        if not isinstance(mechanism, Mechanism):
            raise TypeError(f"mechanism must be one, as from linkages.load, found {mechanism!r}")
        self.mechanism = choose_free(mechanism)
        self.time = time
        self.held: Floats | None = None
        self._starting: Callable[[], Floats] | None = None
        self.effects: Effects | None = None
        self.chosen = tuple(
            name for name in self.mechanism.initial if name not in mechanism.initial
        )
        self._take(whole=False)
        try:
            self._assemble(near)
        except InputError as error:
            if not self.topology.redundant:
                raise
            # which equations are redundant shows in numbers only: solve all of them together
            self._take(whole=True)
            try:
                self._assemble(near)
            except SeveralPlacesError:
                raise
            except InputError:
                raise explained(self.mechanism, error) from None

    def _take(self, *, whole: bool) -> None:
        self._whole = whole
        for derived in DERIVED:
            vars(self).pop(derived, None)
        self._bind(structure_of(self.mechanism, whole))
        self.numbers = definition_vector(self.mechanism, self.model.inputs.parameters)

    def _assemble(self, near: Mapping[str, Floats] | None) -> None:
        given = given_state(self.topology, self.mechanism)
        self._place = Place(self.model, self.mechanism, self.numbers, self.time, given)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            self.assembly: Assembly = assemble(self._place, near)
            self.state: Floats = self._settled(self.assembly)
            for point, place in self.places().items():
                if not np.isfinite(place).all():
                    what = f"the place of {point_words(point)} is not a finite number. {TOO_LARGE}"
                    raise self.mechanism.error([((), what)])
            require_consistent(self)
            if near is None:
                self._require_loads()
                self._require_actuators()

    @cached_property
    def parameters(self) -> Floats:
        """Parameters in this way of assembly, shape (p,), then slopes if effects are wanted."""
        result = assembled(self.model.inputs, self.numbers, self.assembly)
        return result if self.effects is None else np.append(result, self.effects.slopes)

    @cached_property
    def margin_scale(self) -> Floats:
        """Sizes of the margins of all blocks, shape (blocks,)."""
        return self.evaluate(self.model.margin_scales)[:, 0]

    def turned(self, state: Floats, turns: Mapping[int, float]) -> System:
        """The same with other whole turns: in the state, and of torsional springs."""
        return self._with(state=state, assembly=replace(self.assembly, turns=dict(turns)))

    def affected(self, effects: Effects | None) -> System:
        """The same whose motions carry along how they change with numbers of the definition."""
        return self._with(effects=effects)

    def with_internal(self, values: Mapping[str, float]) -> System:
        """The same with values of internal states by their names; others are left out."""
        state, coordinates = self.state.copy(), self.topology.coordinates
        for name in values.keys() & set(self.topology.internal):
            state[len(coordinates) + coordinates.index(name)] = values[name]
        return self._with(state=state)

    def bound(
        self,
        mechanism: Mechanism,
        numbers: Floats,
        assembly: Assembly,
        state: Floats,
        margin_scale: Floats,
        starting: Callable[[], Floats],
    ) -> System:
        """The system of another mechanism of this structure, whose assembly is known."""
        return self._with(
            mechanism=mechanism,
            topology=topology_of(self.structure.topology, mechanism),
            numbers=numbers,
            assembly=assembly,
            state=state,
            margin_scale=margin_scale,
            _starting=starting,
            _place=Place(self.model, mechanism, numbers, self.time, state),
        )

    def _bind(self, structure: Structure) -> None:
        self.structure, self.model = structure, structure.model
        self.topology: Topology = topology_of(structure.topology, self.mechanism)

    def __getstate__(self) -> dict[str, object]:
        """Without the equations, which its structure has in every process."""
        own = vars(self).keys() - {"structure", "model", "topology", "_place", "_starting"}
        own.discard("_placed")
        return {name: getattr(self, name) for name in own} | {"given": self._place.given}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """With the equations of its structure."""
        own = dict(state)
        given = own.pop("given")
        vars(self).update(own, _starting=None)
        self._bind(structure_of(self.mechanism, self._whole))
        self._place = Place(self.model, self.mechanism, self.numbers, self.time, given)

    def _with(self, **changed: object) -> System:
        result = object.__new__(System)
        vars(result).update(vars(self))
        for derived in DERIVED:
            vars(result).pop(derived, None)
        # modes belong to a state
        result.held = None if "state" in changed else self.held
        result._starting = None
        vars(result).update(changed)
        return result

    def _require_loads(self) -> None:
        """Loads must have a value at the start, as the laws of drives must; nothing is in walls."""
        result = []
        for wall, nodes in self._walls:
            (depth,) = self._place.values([nodes.gap.indentation], self.assembly)
            if message := wall.start_problem(float(depth), nodes.contact.name):
                result.append((wall.path, message))
        for load in self.model.loads:
            if load.load.bearing is not None and self.topology.redundant:
                places = self.topology.redundant_places
                message = f"constraints at {places} are redundant: rigid bodies do not determine "
                result.append((load.load.path, f"{message}the reaction that friction follows"))
                continue
            given = np.isfinite(self._place.values(load.given, self.assembly))
            rated = np.isfinite(self._place.values(load.doubtful, self.assembly))
            if not given.all() or (not rated[:1].all() and rated[1:].all()):
                message = f"cannot act at t = {self.time:g} s: {load.undefined}"
                result.append((load.load.path, message))
        result += [
            ((*state.path, "period"), "expected a time > 0")
            for state in self.mechanism.sampled.values()
            if state.period is not None and not 0.0 < state.period.parameter.value < math.inf
        ]
        for state, law in self.model.own_laws:
            if not np.isfinite(self._place.values([law], self.assembly)).all():
                result.append((state.path, f"its law has no finite value at t = {self.time:g} s"))
        if result:
            raise self.mechanism.error(dict.fromkeys(result))  # both axes of a force say the same

    @property
    def _walls(self) -> list[tuple[WithoutRoom, GapNodes]]:
        """What may touch walls, with the gaps there."""
        walls = {wall.path: wall for wall in self.mechanism.walls}
        pairs = zip(self.mechanism.contacts, self.model.contacts, strict=True)
        return [(walls[own.path], nodes) for own, nodes in pairs if own.path in walls]

    def starts_in_walls(self, parameters: Floats, state: Floats) -> NDArray[np.bool_]:
        """Which mechanisms of this structure start too deep in a wall, shape (sets,)."""
        result = np.zeros(state.shape[1], dtype=bool)
        for wall, nodes in self._walls:
            inputs = self._inputs(np.array([self.time]), state) | {"p": parameters}
            gap, share = nodes.gap, wall.deepest_start / wall.size
            values = self._evaluated([gap.indentation, gap.size], inputs, None, state.shape[1])
            result |= values[0] > share * values[1]
        return result

    def _require_actuators(self) -> None:
        """A free coordinate that moves an actuator would follow from its effort, and that from it.

        Nor do efforts exist at the start where actuators cannot hold the drives.
        """
        if not self.model.actuators:
            return
        actuations = self.mechanism.actuations.values()
        for name, partial in zip(self.topology.free, self.model.partials, strict=True):
            for own, actuation in zip(self.model.actuators, actuations, strict=True):
                if own.rate(partial).constant != 0.0:
                    message = (
                        f"moves with the free coordinate {name!r}; expected one that the drives "
                        "alone move. To let go of what is free, drive the bars by tables of the "
                        "motion of the actuators"
                    )
                    raise self.mechanism.error([(actuation.path, message)])
        determinant = self.model.actuated.dexterity
        (value,) = self.evaluate([determinant])[:, 0]
        if not abs(value) > LEAST_MARGIN:
            driven = ", ".join(self.topology.driven)
            message = f"cannot hold {driven} at t = {self.time:g} s; expected another start, or"
            raise self.mechanism.error([(("actuators",), f"{message} other actuators")])

    @property
    def layout(self) -> Layout:
        """What stands where in its state."""
        return self.structure.layout

    def _settled(self, assembly: Assembly) -> Floats:
        state = self._place.state(assembly)
        if self.topology.carried:
            rows = self.layout.carried_rows
            state[rows] = self._place.values(self.model.settled, assembly)
        return state

    def at(
        self, time: float, state: Floats, flipped: Collection[int] = (), held: Floats | None = None
    ) -> System:
        """The same at another time and in another state, with some blocks in their other branch.

        `held` are modes and memories there; they follow from the state if not given.
        """
        sides = {b: -s if b in flipped else s for b, s in self.assembly.sides.items()}
        assembly = replace(self.assembly, sides=sides)
        return self._with(time=time, state=state, assembly=assembly, held=held)

    def starting_held(self) -> Floats:
        """Modes, then memories, of the initial state, shape (m,); see `starting_modes`."""
        if self.held is not None:
            return self.held.copy()
        if self._starting is not None:
            return self._starting()
        return self.starting_modes(self.parameters[:, None], self.state[:, None])[:, 0]

    def starting_modes(self, parameters: Floats, state: Floats) -> Floats:
        """Modes, then memories, of mechanisms of this structure, shape (m, sets).

        A mode is the sign of its function or, where that is zero, of its rate. Memories are as if
        all switches had just risen.
        """
        accelerations = self.model.integrated_accelerations(self.model.changes)
        switches, inputs = self.model.switches, self._inputs(np.array([self.time]), state)
        inputs["p"] = parameters
        held = self._signed(inputs)

        def evaluated(nodes: Sequence[Scalar]) -> Floats:
            return self._evaluated(nodes, inputs, held, state.shape[1])

        for number, values in enumerate(evaluated(switches.functions)):
            zero, owner = values == 0.0, switches.switches[number].active
            if owner is not None:
                # its own mode may just have become −1
                held[number, held[owner] < 0.0] = -1.0
                zero &= held[owner] > 0.0
            if zero.any():
                rate = switches.rates([switches.functions[number]], accelerations)
                rising = evaluated(rate)[0] >= 0.0
                held[number, zero] = np.where(rising, 1.0, -1.0)[zero]
                if switches.switches[number].stick:
                    held[number, zero & ~rising & (evaluated(rate)[0] > 0.0)] = 0.0
        return held

    def holding(self, named: Mapping[str, float]) -> System:
        """The same with modes and memories of another motion, if that has all of them."""
        if not named:
            return self
        _ = self.model.free_accelerations
        names = self.model.switches.names
        if not set(names) <= named.keys():
            return self
        return self._with(held=np.array([named[name] for name in names]))

    def modes(self) -> list[Assembly]:
        """All assembly branches at the initial values of drives and free coordinates."""
        return all_branches(self._place)

    def in_mode(self, assembly: Assembly) -> dict[str, Floats]:
        """Point → position in an assembly branch at the initial state, shape (2,)."""
        joints = self.model.positions.joints
        values = np.array(self._place.values(components(joints.values()), assembly)).reshape(-1, 2)
        return dict(zip(joints, values, strict=True))

    def evaluate(
        self,
        nodes: Sequence[Scalar],
        time: Floats | float | None = None,
        state: Floats | None = None,
        acceleration: Floats | None = None,
        flipped: Mapping[int, NDArray[np.bool_]] | None = None,
        held: Floats | None = None,
        further: Mapping[str, Floats] | None = None,
    ) -> Floats:
        """Values of nodes of the model, shape (nodes, times).

        What is not given is that of the initial state. `state` has integrated coordinates, then
        their rates, shape (2n, times), `flipped` the times at which a block is in its other
        assembly branch, and `held` modes, then memories, shape (m, times).
        """
        times = np.atleast_1d(np.asarray(self.time if time is None else time, dtype=float))
        if state is None:
            state = self.state[:, None]
            held = self.held[:, None] if held is None and self.held is not None else held
        inputs = self._inputs(times, state, acceleration, flipped)
        return self._evaluated(nodes, inputs, held, len(times), further)

    def _evaluated(
        self,
        nodes: Sequence[Scalar],
        given: Mapping[str, Floats],
        held: Floats | None,
        columns: int,
        further: Mapping[str, Floats] | None = None,
    ) -> Floats:
        """Values of nodes for given inputs, and modes if they are known, shape (nodes, columns)."""
        evaluator, inputs = self.model.evaluator(nodes), dict(given)
        if evaluator.switched:
            found = self._signed(inputs) if held is None else held
            count = len(self.model.switches.switches)
            inputs |= {"mode": found[:count], "memory": found[count:]}
            inputs["mode"] = self._unstuck(inputs)
        result = np.empty((len(nodes), columns))
        for row, value in zip(result, evaluator(**inputs | dict(further or {})), strict=True):
            row[:] = value
        return result

    def _inputs(
        self,
        times: Floats,
        state: Floats,
        acceleration: Floats | None = None,
        flipped: Mapping[int, NDArray[np.bool_]] | None = None,
    ) -> dict[str, Floats]:
        """Arguments of an evaluator, but for modes and memories."""
        count = len(self.topology.coordinates)
        accelerations = np.zeros((count, 1)) if acceleration is None else acceleration
        parameters = self.parameters
        if flipped:
            parameters = np.repeat(parameters[:, None], len(times), axis=1)
            for block, where in flipped.items():
                parameters[self.model.inputs.parameters["side", block], where] *= -1.0
        return {"t": times[None], "y": state, "a": accelerations, "p": parameters}

    def _unstuck(self, inputs: Mapping[str, Floats]) -> Floats:
        """Modes with the values that those of 0 stand for."""
        modes, values = inputs["mode"], self.model.switches.equivalent
        rows = [row for row in values if (modes[row] == 0.0).any()]
        if not rows:
            return modes
        modes = modes.copy()
        result = self.model.evaluator([values[row] for row in rows])(**inputs)
        for row, value in zip(rows, result, strict=True):
            modes[row] = np.where(modes[row] == 0.0, value, modes[row])
        return modes

    def _signed(self, inputs: Mapping[str, Floats]) -> Floats:
        """Modes and memories that follow from a state, shape (m, times)."""
        result = self.model.switches.signed(inputs)
        return np.concatenate([result["mode"], result["memory"]])

    def places(self) -> dict[str, Floats]:
        """Point → position at the initial state, shape (2,)."""
        return {point: place.copy() for point, place in self._placed.items()}

    @cached_property
    def _placed(self) -> dict[str, Floats]:
        return self.in_mode(self.assembly)

    @property
    def axes(self) -> dict[str, Floats]:
        """Slider → unit vector of its axis at the initial state, for a cam times its slope."""
        sliders = [name for name, body in self.mechanism.bodies.items() if not body.rotates]
        nodes = components(self.model.positions.travel(name) for name in sliders)
        return dict(zip(sliders, self.evaluate(nodes).reshape(-1, 2), strict=True))

    @cached_property
    def jacobian(self) -> Floats:
        """The closure Jacobian at the initial state, columns scaled to unit length."""
        return closure_jacobian(self.topology, self.places(), self.axes)

    @cached_property
    def conditions(self) -> list[float]:
        """Condition number of each block at the initial state."""
        return block_conditions(self.topology, self.places(), self.axes)

    @property
    def mobility(self) -> int:
        """Number of coordinates minus the rank of the closure Jacobian.

        The Jacobian is block triangular: where all blocks are regular its rows are independent.
        """
        blocks = self.topology.blocks
        if any(block.surplus for block in blocks) or max(self.conditions, default=1.0) > REGULAR:
            return numerical_mobility(self.jacobian)
        return len(owners(self.topology)) - 2 * sum(len(block.loops) for block in blocks)


def choose_free(mechanism: Mechanism) -> Mechanism:
    """Add the free coordinates that are not named: at rest, with the best-conditioned closure."""
    best: tuple[float, Mechanism] | None = None
    refusal: InputError | None = None
    for completed in possible_choices(mechanism):
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
