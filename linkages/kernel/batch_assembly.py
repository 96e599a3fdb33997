"""Assembling many mechanisms of one structure at once, by the decisions of `assembly`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.terms import Hint
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.assembly import place_nodes, placed_joints, turning
from linkages.kernel.assembly_branches import Assembly
from linkages.kernel.differentiation import evaluate
from linkages.kernel.dyads import LinkAndSlider, LinkInGuide, TwoLinks
from linkages.kernel.inputs import definition_vector
from linkages.kernel.layout import Layout
from linkages.kernel.model import Model
from linkages.kernel.scalars import Scalar, reachable
from linkages.kernel.system import choose_free, given_state, structure_of
from linkages.topology.assur_groups import ITERATED, Block

Floats = NDArray[np.float64]

Hints = Mapping[str, Floats]
"""Joint → about where it is, shape (2,) or (2, sets)."""

AMBIGUOUS = 1e-6
"""Difference of distances, beside that of the places, below which a hint is as near to both."""


@dataclass(frozen=True, eq=False)
class AssembledBatch:
    """Mechanisms at the initial time, one for each set of numbers.

    `unreached`: how far from assembly they are, shape (sets,): 0 where all blocks reach, 1 where
    that is not told. The first block that does not reach tells, each with an equal part of what is
    between, the last one the least: by x/(1 + x), with x how far it is beyond its reach.
    """

    parameters: Floats  # with sides and whole turns, shape (p, sets)
    state: Floats  # with what is carried along, shape (2m, sets)
    margin_scale: Floats  # shape (blocks, sets)
    # Which sets can be assembled in one way that the definition tells; nothing else is said of the
    # others. Shape (sets,)
    sound: NDArray[np.bool_]
    assumed: tuple[int, ...]  # blocks whose side is not given by the definition
    unreached: Floats


@dataclass(eq=False)
class _Inputs:
    """Arguments of all sets of numbers, and the values of nodes that are known by now."""

    t: Floats
    p: Floats
    y: Floats
    values: dict[int, Any] = field(default_factory=dict)

    def copy(self) -> _Inputs:
        return _Inputs(self.t, self.p.copy(), self.y, dict(self.values))


class BatchAssembler:
    """Assembles mechanisms of a structure whose blocks all have a closed form."""

    def __init__(self, model: Model, hints: Mapping[str, Hint]) -> None:
        self._model, self._hints = model, hints
        self._layout = Layout.of(model.topology)
        self._places = model.inputs.parameters
        self._orders: dict[object, list[Scalar]] = {}

    @staticmethod
    def serves(model: Model) -> bool:
        """Whether all decisions are told by the signs of radicands and by hints."""
        topology = model.topology
        known = (*topology.driven, *topology.free)
        iterated = any(block.kind == ITERATED for block in topology.solved_blocks)
        return bool(known) and not iterated and not topology.redundant

    @cached_property
    def _blocks(self) -> list[tuple[Block, Scalar | None, list[str], int | None]]:
        """Blocks with what must not be negative, the joints of their hints, and given sides."""
        result = []
        for block in self._model.topology.solved_blocks:
            joints = placed_joints(self._model, block)
            hints = [hint for joint, hint in self._hints.items() if joint in joints]
            sides = [hint.side for hint in hints if hint.side is not None]
            radicand = self._model.positions.dyads[block.index].radicand
            side = sides[0] if sides else None
            result.append((block, radicand, [hint.joint for hint in hints], side))
        return result

    def __call__(self, numbers: Floats, state: Floats, time: float, hints: Hints) -> AssembledBatch:
        """Assemble sets of parameters, shape (p, sets), with states, shape (2m, sets).

        Coordinates that are carried along are zero in the states.
        """
        inputs = _Inputs(np.array([time]), numbers.copy(), state.copy())
        count, unreached = numbers.shape[1], np.zeros(numbers.shape[1])
        sound, assumed = np.ones(count, dtype=bool), []
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            laws = self._model.positions.laws.values()
            sound &= self._finite(
                "laws", [n for w in laws for n in (w.value, w.rate, w.acceleration)], inputs
            )
            for place, (block, radicand, joints, side) in enumerate(self._blocks):
                if radicand is None:
                    continue
                reach = self._values(("reach", block.index), [radicand], inputs)[0]
                first = (reach < 0.0) & (unreached == 0.0)
                if first.any():
                    beyond = self._beyond(block, inputs)
                    part = len(self._blocks) - 1 - place + beyond / (1.0 + beyond)
                    unreached = np.where(first, part / len(self._blocks), unreached)
                sound &= reach >= 0.0
                row = self._places["side", block.index]
                if side is not None:
                    inputs.p[row] = side
                elif joints:
                    inputs.p[row], clear = self._nearer(block, joints, inputs, hints)
                    sound &= clear
                elif block.kind in ("RRP", "RPR"):
                    inputs.p[row] = 1.0
                    assumed.append(block.index)
                else:
                    sound[:] = False
            self._turn(inputs)
            if self._layout.carried:
                rows = self._layout.carried_rows
                inputs.y[rows] = self._values("settled", self._model.settled, inputs)
            sound &= self._finite(
                "places", place_nodes(self._model, self._model.positions.joints), inputs
            )
            given = [node for load in self._model.loads for node in load.given]
            sound &= self._finite("loads", given, inputs)
            scale = self._values("scales", self._model.margin_scales, inputs)
        unreached[~sound & ~(unreached > 0.0)] = 1.0
        return AssembledBatch(inputs.p, inputs.y, scale, sound, tuple(assumed), unreached)

    def _beyond(self, block: Block, inputs: _Inputs) -> Floats:
        """Length by which a block misses its reach, over that of its links."""
        dyad = self._model.positions.dyads[block.index]
        match dyad:
            case TwoLinks(gap_square=gap, first_square=first, second_square=second):
                squares = self._values(("size", block.index), [gap, first, second], inputs)
                apart, one, other = np.sqrt(squares)
                return np.maximum(apart - one - other, np.abs(one - other) - apart) / (one + other)
            case LinkAndSlider() | LinkInGuide():
                nodes = [dyad.across, dyad.margin_scale]
                across, link = np.abs(self._values(("size", block.index), nodes, inputs))
                return (across - link) / np.maximum(across, link)
            case _:
                raise AssertionError("other blocks always reach")

    def assembly(self, settled: AssembledBatch, index: int) -> Assembly:
        """The way in which one set of numbers is assembled."""
        column = settled.parameters[:, index]
        sides = {
            block.index: 1 if radicand is None else int(column[self._places["side", block.index]])
            for block, radicand, *_ in self._blocks
        }
        turned = {load: float(column[self._places["turns", load]]) for load in self._turning}
        return Assembly(sides, {}, turned, settled.assumed)

    @cached_property
    def _turning(self) -> dict[int, Scalar]:
        return turning(self._model)

    def _turn(self, inputs: _Inputs) -> None:
        if not self._turning:
            return
        differences = self._values("turns", list(self._turning.values()), inputs)
        for load, difference in zip(self._turning, differences, strict=True):
            turns = 2 * np.pi * np.round(difference / (2 * np.pi))
            inputs.p[self._places["turns", load]] = turns

    def _nearer(
        self, block: Block, joints: list[str], inputs: _Inputs, hints: Hints
    ) -> tuple[Floats, NDArray[np.bool_]]:
        """Sides that put joints closer to where they should be, and where that is clear."""
        nodes = place_nodes(self._model, joints)
        count = inputs.p.shape[1]
        wanted = np.concatenate(
            [np.broadcast_to(hints[joint].reshape(2, -1), (2, count)) for joint in joints]
        )
        places = []
        for side in (1.0, -1.0):
            tried = inputs.copy()
            tried.p[self._places["side", block.index]] = side
            places.append(self._values(("near", block.index), nodes, tried))
        one, other = (np.linalg.norm(place - wanted, axis=0) for place in places)
        apart = np.linalg.norm(places[0] - places[1], axis=0)
        return np.where(one <= other, 1.0, -1.0), np.abs(one - other) > AMBIGUOUS * apart

    def _finite(self, key: object, nodes: list[Scalar], inputs: _Inputs) -> NDArray[np.bool_]:
        return np.asarray(np.isfinite(self._values(key, nodes, inputs)).all(axis=0))

    def _values(self, key: object, nodes: list[Scalar], inputs: _Inputs) -> Floats:
        """Values of nodes, shape (nodes, sets); what is unknown by then is equal for equal keys."""
        if key not in self._orders:
            self._orders[key] = [n for n in reachable(nodes) if n.index not in inputs.values]
        arguments = {"t": inputs.t, "p": inputs.p, "y": inputs.y, "a": inputs.y}
        given = {node.arguments[0] for node in self._orders[key] if node.operation == "input"}
        if not given <= set(arguments):
            arguments |= self._model.switches.signed(arguments)
        for node in self._orders[key]:
            inputs.values[node.index] = evaluate(node, inputs.values, arguments)
        result = np.empty((len(nodes), inputs.p.shape[1]))
        for row, node in zip(result, nodes, strict=True):
            row[:] = inputs.values[node.index]
        return result


def unreached(mechanism: Mechanism, time: float = 0.0) -> float:
    """How far from assembly a mechanism is: 0 where all blocks reach, 1 where that is not told."""
    mechanism = choose_free(mechanism)
    structure = structure_of(mechanism)
    model = structure.model
    if not BatchAssembler.serves(model):
        return 1.0
    given = given_state(structure.topology, mechanism)
    hints = {
        hint.joint: np.array(hint.position, dtype=float)
        for hint in mechanism.hints.values()
        if hint.position is not None
    }
    assembler = BatchAssembler(model, mechanism.hints)
    numbers = definition_vector(mechanism, model.inputs.parameters)
    return float(assembler(numbers[:, None], given[:, None], time, hints).unreached[0])
