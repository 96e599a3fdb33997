"""Whether redundant constraints hold by themselves, or keep a mechanism from moving."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from linkages.components.contributed.terms import point_words
from linkages.errors import InputError
from linkages.kernel.closure.iteration import CONTRADICTION, block_size, residuals
from linkages.kernel.closure.motion import Rates
from linkages.kernel.graph.vectors import Vector
from linkages.topology.blocks import Block
from linkages.topology.explanation import wrong_mobility
from linkages.topology.jacobian import numerical_mobility

if TYPE_CHECKING:
    from linkages.kernel.system import System

CONTRADICTION_RATE = 1e-7
"""Relative velocity from which on redundant constraints contradict each other."""


def require_consistent(system: System) -> None:
    """Make sure that a system's redundant constraints hold whatever drives it.

    Raises
    ------
    InputError
        If they do not, or if drives and free coordinates do not match the mobility.
    """
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
    if (topology.redundant or not known) and len(known) != numerical_mobility(system.jacobian):
        raise wrong_mobility(system.mechanism, numerical_mobility(system.jacobian))


def _largest(system: System, vectors: Sequence[Vector]) -> float:
    nodes = [node for vector in vectors for node in (vector.x, vector.y)]
    return float(np.abs(system.evaluate(nodes)).max())


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
