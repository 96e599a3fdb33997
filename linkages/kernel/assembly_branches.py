"""All assembly branches of a block or a mechanism, and redundant constraints."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.terms import point_words
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError
from linkages.kernel.differentiation import Values, evaluate, iterate
from linkages.kernel.dyads import CONTRADICTION, Iterated, block_size, residuals
from linkages.kernel.inputs import SIDED, Inputs, wound_angles
from linkages.kernel.model import Model
from linkages.kernel.scalars import Scalar, Vector, components
from linkages.kernel.velocities import Rates
from linkages.reading.paths import KeyPath
from linkages.topology.assur_groups import ITERATED, Block
from linkages.topology.topology import wrong_mobility

if TYPE_CHECKING:
    from linkages.kernel.system import System

Floats = NDArray[np.float64]

STARTS = 2000
"""Random positions from which branches of an iterated block are looked for."""

SWITCHED = ("mode", "memory")
"""Inputs that follow from a state."""

SAME = 1e-6
MOST_BRANCHES = 512


@dataclass(frozen=True)
class Assembly:
    """How a mechanism is put together."""

    sides: dict[int, int] = field(default_factory=dict)  # block solved in closed form → +1 or −1
    # Body whose coordinate is found by iteration → its value
    values: dict[str, float] = field(default_factory=dict)
    # Torsional spring → what the difference of its angles is too large by, a multiple of 2π
    turns: dict[int, float] = field(default_factory=dict)
    assumed: tuple[int, ...] = ()  # blocks whose side is not given by the definition

    def with_choice(self, block: Block, choice: Choice) -> Assembly:
        """The same with one more block."""
        if isinstance(choice, int):
            return replace(self, sides=self.sides | {block.index: choice})
        result = dict(zip(block.unknowns, choice, strict=True))
        return replace(self, values=self.values | result)

    def side_of(self, block: Block) -> str | None:
        """The side of a dyad in a word; None where there is only one, or values instead."""
        sign = self.sides.get(block.index)
        if sign is None or block.kind == "PP":
            return None
        words = ("left", "right") if block.kind == "RRR" else ("forward", "backward")
        return words[sign < 0]


Choice = int | tuple[float, ...]
"""A side, or values of the unknowns."""


def assembled(inputs: Inputs, numbers: Floats, assembly: Assembly) -> Floats:
    """The parameter array for a way of assembly, shape (parameters,)."""
    values, places = numbers.copy(), inputs.parameters
    chosen: dict[KeyPath, float] = {("side", block): side for block, side in assembly.sides.items()}
    chosen |= {("turns", load): value for load, value in assembly.turns.items()}
    for path, value in chosen.items():
        if path in places:
            values[places[path]] = value
    return values


class Place:
    """Evaluates nodes at one time and state, for different ways of assembly."""

    def __init__(
        self, model: Model, mechanism: Mechanism, numbers: Floats, time: float, state: Floats
    ) -> None:
        self.model = model
        self.mechanism = mechanism
        self.numbers = numbers
        self.time = time
        self.given = state

    def state(self, assembly: Assembly) -> Floats:
        """The state with the values of an assembly, shape (2n,)."""
        state = self.given.copy()
        for name, value in assembly.values.items():
            state[self.model.topology.coordinates.index(name)] = value
        return state

    def inputs(self, assembly: Assembly) -> dict[str, Floats]:
        """Arrays that nodes are evaluated with."""
        return {
            "t": np.array([self.time]),
            "y": self.state(assembly),
            "a": np.zeros(len(self.given)),
            "p": assembled(self.model.inputs, self.numbers, assembly),
        }

    def values(self, nodes: list[Scalar], assembly: Assembly) -> list[float]:
        """Values of nodes."""
        inputs = self.inputs(assembly)
        evaluator = self.model.evaluator(nodes)
        if evaluator.switched:
            inputs |= self.model.switches.signed(inputs)
        evaluated = evaluator(**inputs)
        return [float(np.ravel(value)[0]) for value in evaluated]

    def choices(self, block: Block, assembly: Assembly) -> list[Choice]:
        """Ways to assemble a block, given those of the blocks before it."""
        solved = self.model.positions.dyads[block.index]
        if isinstance(solved, Iterated):
            return list(self._solutions(block, solved, assembly))
        if solved.radicand is None:
            return [1]
        (radicand,) = self.values([solved.radicand], assembly)
        return [1, -1] if radicand >= 0 else []

    def _solutions(
        self, block: Block, solved: Iterated, assembly: Assembly
    ) -> Iterator[tuple[float, ...]]:
        """All solutions that a Newton iteration from many places finds; displacements last."""
        iteration = solved.iteration
        known = self.values(list(iteration.external), assembly)
        outside = {n.index: v for n, v in zip(iteration.external, known, strict=True)}
        random = np.random.default_rng(0)
        turning = [self.mechanism.bodies[name].rotates for name in block.unknowns]
        starts = [
            random.uniform(-np.pi, np.pi, STARTS) if turns else random.normal(0, 3 * scale, STARTS)
            for turns, scale in zip(turning, iteration.scales, strict=True)
        ]
        result = np.array(iterate(iteration, starts, outside, most_turned=np.inf))
        result = result[:, np.isfinite(result).all(axis=0)]
        slid = [self._slides(block, name) for name in block.unknowns]
        angles = np.array(turning) & ~np.array(slid)  # of the others, whole turns matter
        result[angles] = np.remainder(result[angles] + np.pi, 2 * np.pi) - np.pi
        kept = np.empty_like(result)
        count = 0
        for solution in result.T:
            if _apart(solution, kept[:, :count], angles).all():
                kept[:, count] = solution
                count += 1
        for solution in sorted(kept[:, :count].T, key=lambda one: np.round(one, 9).tolist()):
            values = tuple(float(value) for value in solution)
            if solved.radicand is not None:
                chosen = assembly.with_choice(block, values)
                (radicand,) = self.values([solved.radicand], chosen)
                if not radicand >= 0:
                    continue
            yield values

    def _slides(self, block: Block, name: str) -> bool:
        """Whether a displacement follows from a coordinate in the loops of a block."""
        bodies, followed = self.mechanism.bodies, self.model.topology.orientations
        sliders = {s.body for loop in block.loops for s in loop.steps} - {name}
        return any(name in followed[s].moved for s in sliders if not bodies[s].rotates)


class GrowingPlace(Place):
    """The same while blocks are put together in their order.

    What depends on the blocks before alone is evaluated once.
    """

    def __init__(self, place: Place) -> None:
        vars(self).update(vars(place))
        topology, inputs = self.model.topology, self.model.inputs
        self._waiting = list(reversed(topology.solved_blocks))
        chosen = [inputs.turns(load) for load in wound_angles(self.mechanism)]
        chosen += [node for block in self._waiting for node in self._chosen(block)]
        self._open = {node.index for node in chosen}
        self._known: Values = {}
        self._inputs = self.inputs(Assembly())

    def _chosen(self, block: Block) -> list[Scalar]:
        """The inputs that a choice for a block gives values to."""
        inputs, coordinates = self.model.inputs, self.model.topology.coordinates
        if block.kind == ITERATED:
            return [inputs.coordinate(coordinates.index(name)) for name in block.unknowns]
        return [inputs.side(block.index)] if block.kind in SIDED else []

    def settle(self, block: Block, choice: Choice) -> None:
        """Keep a choice for the block that comes next."""
        self._waiting.pop()
        values = (choice,) if isinstance(choice, int) else choice
        for node, value in zip(self._chosen(block), values, strict=False):
            name, index = node.arguments
            self._inputs[name][index] = value
            self._open.discard(node.index)

    def values(self, nodes: list[Scalar], assembly: Assembly) -> list[float]:
        """Values of nodes in an assembly of which all but the block that comes next is settled."""
        known, trial = self._known, set()
        if self._waiting:
            block = self._waiting[-1]
            given: Sequence[float | None] = [assembly.sides.get(block.index)]
            if block.kind == ITERATED:
                given = [assembly.values.get(name) for name in block.unknowns]
            for node, value in zip(self._chosen(block), given, strict=False):
                if value is not None:
                    known[node.index] = np.float64(value)
                    trial.add(node.index)
        new = self._unknown(nodes)
        if any(node.operation == "input" and node.arguments[0] in SWITCHED for node in new):
            for index in trial:
                del known[index]
            return super().values(nodes, assembly)
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            for node in new:
                known[node.index] = evaluate(node, known, self._inputs)
                opened = (operand.index in trial for operand in node.operands)
                if node.index in self._open or any(opened):
                    trial.add(node.index)
        result = [float(np.ravel(known[node.index])[0]) for node in nodes]
        for index in trial:
            del known[index]
        return result

    def _unknown(self, nodes: Sequence[Scalar]) -> list[Scalar]:
        """Nodes without a value that others need, in an order in which they can be computed."""
        waiting, found = list(nodes), {}
        while waiting:
            node = waiting.pop()
            if node.index not in found and node.index not in self._known:
                found[node.index] = node
                waiting.extend(node.operands)
        return [found[index] for index in sorted(found)]


def _apart(solution: Floats, others: Floats, angles: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """From which of some other solutions one differs, shape (others,)."""
    difference = solution[:, None] - others
    difference[angles] = np.remainder(difference[angles] + np.pi, 2 * np.pi) - np.pi
    least = SAME * max(1.0, float(np.abs(solution).max()))
    return np.asarray(np.abs(difference).max(axis=0) > least)


def all_branches(place: Place) -> list[Assembly]:
    """All assembly branches of a mechanism, in a fixed order; at most `MOST_MODES`."""
    modes = [Assembly()]
    for block in place.model.topology.solved_blocks:
        modes = [
            mode.with_choice(block, choice)
            for mode in modes
            for choice in place.choices(block, mode)
        ][:MOST_BRANCHES]
    return modes


CONTRADICTION_RATE = 1e-7
"""Relative velocity from which on redundant constraints contradict each other."""


def require_consistent(system: System) -> None:
    """Make sure that a system's redundant constraints hold whatever drives it."""
    topology = system.topology
    known = (*topology.driven, *topology.free)
    for block in (block for block in topology.blocks if block.surplus):
        if not block.unknowns:
            _require_closed(system, block)
        for name in known:
            partial = Rates(system.model.positions, {name: system.model.graph.one}, "c")
            error = _largest(system, partial.mismatch(block))
            if error > CONTRADICTION_RATE * max(1e-9, _largest(system, partial.parts(block))):
                raise _contradiction(system, name)
    # The Chebychev–Grübler–Kutzbach criterion is right for all others, unless links of special
    # lengths make it 0 for a mechanism that moves
    if (topology.redundant or not known) and len(known) != system.mobility:
        raise wrong_mobility(system.mechanism, system.mobility)


def _largest(system: System, vectors: Sequence[Vector]) -> float:
    return float(np.abs(system.evaluate(components(vectors))).max())


def _require_closed(system: System, block: Block) -> None:
    """Loops without an unknown must close by themselves."""
    positions = system.model.positions
    missed = _largest(system, residuals(positions, block))
    if missed <= CONTRADICTION * block_size(system.mechanism, block):
        return
    joints = system.topology.redundant_places
    loop = block.loops[0]
    met = point_words(loop.apex, "")
    message = (
        f"cannot be assembled: nothing is left to be moved so that {loop.steps[-1].body} "
        f"meets {met}; more constraints than coordinates at {joints}, and they contradict "
        "each other"
    )
    path = system.mechanism.bodies[loop.steps[-1].body].path
    raise system.mechanism.error([(path, message)])


def _contradiction(system: System, name: str) -> InputError:
    joints = system.topology.redundant_places
    message = (
        f"more constraints than coordinates at {joints}: they would not let {name} move; "
        "expected the drives and free coordinates to be independent of each other, or "
        "dimensions with which the redundant constraints hold in all positions"
    )
    return system.mechanism.error([((), message)])
