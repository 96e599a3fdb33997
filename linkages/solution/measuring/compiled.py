"""Outputs at many states of an integrated motion, compiled once for a structure.

Where NumPy would take longer than the integration did: measures look at several states per step.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.code.program import write_functions_of
from linkages.kernel.code.sampling import SampledFunctions
from linkages.kernel.graph.remembered import Remembered
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.model import Model
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.structure import MOST_STRUCTURES
from linkages.solution.crossings import accelerated
from linkages.solution.moving.evaluation import variable_values
from linkages.solution.moving.motion import Piece

Floats = NDArray[np.float64]

LANES = 8
"""States side by side; bits do not depend on it."""


def compiled_values(piece: Piece, names: Sequence[str]) -> Floats:
    """Values of the nodes of some variables, as `variable_values` has them, to round-off."""

    def nodes(model: Model) -> list[Scalar]:
        return [node for name in names for node in VARIABLES[name].evaluated(model)]

    functions = _functions(piece, ("variables", *names), nodes) if names else None
    if functions is None:
        return variable_values(piece, names)
    states = np.concatenate([piece.state, piece.acceleration])
    return functions(piece.system.parameters, piece.time, states)


def compiled_accelerated(piece: Piece) -> Piece:
    """A piece with the accelerations that follow from its states, as `accelerated` gives it."""

    def nodes(model: Model) -> list[Scalar]:
        return list(model.integrated_accelerations(model.changes))

    functions = _functions(piece, ("accelerations",), nodes)
    if functions is None:
        return accelerated(piece)
    return replace(piece, acceleration=functions(piece.system.parameters, piece.time, piece.state))


_FUNCTIONS: Remembered[Hashable, SampledFunctions | None] = Remembered(MOST_STRUCTURES)


def _functions(
    piece: Piece, what: tuple[str, ...], nodes: Callable[[Model], Sequence[Scalar]]
) -> SampledFunctions | None:
    """Compiled functions of a piece; None for NumPy.

    That is for driven motions, which need no compiler, and where states are not all of one mode:
    assembled otherwise, or with switches; and for systems that carry effects of numbers.
    """
    system = piece.system
    if not len(piece.state) or piece.flipped or piece.samples is not None:
        return None
    if system.effects is not None:
        return None  # its parameters have derivatives behind them

    def made() -> SampledFunctions | None:
        model = Model(system.topology)
        wanted = nodes(model)
        if not wanted:
            return None
        program = write_functions_of(model, wanted, ", ".join(what))
        return None if program.held else SampledFunctions(program, LANES)

    return _FUNCTIONS.get((system.structure.key, system.topology.coordinates, what), made)
