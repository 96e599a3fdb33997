"""Blocks without a closed form: their loops as equations of a Newton iteration."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from linkages.kernel.closure.iterated import Iterated, LinearSystem
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.graph.several import Iteration
from linkages.kernel.graph.vectors import Vector
from linkages.topology.blocks import Block, Loop, Step

if TYPE_CHECKING:
    from linkages.components.mechanisms.mechanism import Mechanism
    from linkages.kernel.closure.positions import Positions

CONTRADICTION = 1e-8
"""Relative gap from which on redundant equations contradict each other."""


def iterate_block(positions: Positions, block: Block) -> Iterated:
    """Solve a block by iteration and enter the positions of its bodies."""
    graph, unknowns = positions.graph, block.unknowns
    iterates = [positions.inputs.iterate(positions.body_numbers[name]) for name in unknowns]
    updates, _ = _newton_step(positions, block, iterates)
    scale = block_size(positions.topology.mechanism, block)
    iteration = Iteration(
        iterates=tuple(iterates),
        updates=tuple(updates),
        scales=tuple(1.0 if positions.body(name).rotates else scale for name in unknowns),
        block=block.index,
    )
    found = graph.newton(iteration, [positions.integrated(name) for name in unknowns])
    updates, missed = _newton_step(positions, block, found)
    for name, value, update in zip(unknowns, found, updates, strict=True):
        positions.correct(name, value, update)
    radicand = None
    if block.surplus:
        relative = [residual * (1.0 / scale) for residual in missed]
        allowed = CONTRADICTION**2 * len(missed)
        radicand = allowed - graph.total(residual.square for residual in relative)
    values = tuple(positions.coordinate(name) for name in unknowns)
    return Iterated(values, LinearSystem(columns(positions, block)), iteration, radicand)


def _newton_step(
    positions: Positions, block: Block, values: list[Scalar]
) -> tuple[list[Scalar], list[Vector]]:
    """One step from given values, and by how much they miss."""
    for name, value in zip(block.unknowns, values, strict=True):
        positions.assign(name, value)
    missed = residuals(positions, block)
    system = LinearSystem(columns(positions, block))
    return system.solve([-residual for residual in missed]), missed


def residuals(positions: Positions, block: Block) -> list[Vector]:
    """By how much the links of each loop of a block miss its end."""
    found = []
    for loop in block.loops:
        total = -positions.gap(loop)
        for step in loop.steps:
            total = total + positions.along(*_way(step))
        found.append(total)
    return found


def columns(positions: Positions, block: Block) -> list[list[Vector]]:
    """Derivatives of the loops of a block with respect to its unknowns."""
    return [[_column(positions, loop, name) for loop in block.loops] for name in block.unknowns]


def _column(positions: Positions, loop: Loop, name: str) -> Vector:
    total = Vector(positions.graph.zero, positions.graph.zero)
    for step in loop.steps:
        orientation = positions.topology.orientations[step.body]
        sliding = positions.frames.sliding(*_way(step))
        if sliding and name in orientation.moved:
            ratio = positions.frames.moves(step.body)[name]
            total = total + positions.unit(step.body) * float(sliding) * ratio
        if name in orientation.masters:
            ratio = positions.frames.ratios(step.body)[name]
            total = total + positions.along(*_way(step)).turned * ratio
    return total


def block_size(mechanism: Mechanism, block: Block) -> float:
    """A power of ten of the size of the longest link of a block.

    It is written into generated code, which must not depend on the lengths themselves.
    """
    longest = 0.0
    for step in (step for loop in block.loops for step in loop.steps):
        places = mechanism.attachments[step.body]
        ends = [places[label] for label in (step.start, step.end) if label in places]
        longest = max([longest, *(abs(value.value) for end in ends for value in end)])
    return 10.0 ** math.floor(math.log10(longest)) if longest > 0 else 1.0


def _way(step: Step) -> tuple[str, str, str]:
    return step.body, step.start, step.end
