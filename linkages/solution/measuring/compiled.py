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
from linkages.kernel.system import System
from linkages.solution.crossings import accelerated
from linkages.solution.moving.evaluation import variable_values
from linkages.solution.moving.motion import Piece

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

LANES = 8
"""States side by side; bits do not depend on it."""


class Numbers:
    """Numbers of motions of one structure, and of which of them each state of a piece is.

    Parameters
    ----------
    systems
        Those of the motions.
    which
        Shape (states,).
    """

    def __init__(self, systems: Sequence[System], which: Whole) -> None:
        self.systems, self.which = systems, which
        self._prepared: dict[SampledFunctions, Floats] = {}

    @classmethod
    def alone(cls, piece: Piece) -> Numbers:
        """Those of the one motion of a piece."""
        return cls([piece.system], np.zeros(len(piece.time), dtype=int))

    def part(self, part: NDArray[np.bool_] | NDArray[np.intp]) -> Numbers:
        """Those of some of the states."""
        return self.of(self.which[part])

    def of(self, which: Whole) -> Numbers:
        """The same for other states."""
        found = Numbers(self.systems, which)
        found._prepared = self._prepared
        return found

    def prepared(self, functions: SampledFunctions) -> Floats:
        """What functions take of them."""
        if functions not in self._prepared:
            parameters = np.array([system.parameters for system in self.systems])
            self._prepared[functions] = functions.prepared(parameters)
        return self._prepared[functions]


def compiled_values(piece: Piece, names: Sequence[str], numbers: Numbers | None = None) -> Floats:
    """Values of the nodes of some variables, as `variable_values` has them, to round-off.

    Where states are of several motions, `numbers` are theirs.
    """

    def nodes(model: Model) -> list[Scalar]:
        return [node for name in names for node in VARIABLES[name].evaluated(model)]

    functions = _functions(piece, ("variables", *names), nodes) if names else None
    if functions is None:
        return variable_values(piece, names)
    states = np.concatenate([piece.state, piece.acceleration])
    return _called(functions, piece, states, numbers)


def compiled_accelerated(piece: Piece, numbers: Numbers | None = None) -> Piece:
    """A piece with the accelerations that follow from its states, as `accelerated` gives it."""

    def nodes(model: Model) -> list[Scalar]:
        return list(model.integrated_accelerations(model.changes))

    functions = _functions(piece, ("accelerations",), nodes)
    if functions is None:
        return accelerated(piece)
    return replace(piece, acceleration=_called(functions, piece, piece.state, numbers))


def can_be_compiled(piece: Piece) -> bool:
    """Whether outputs of a piece are evaluated by compiled functions.

    Driven motions need no compiler; the others are those that are assembled otherwise than at the
    start, those in which friction holds, for what it exerts then follows from a system of its own,
    and those that carry effects of numbers: their parameters have derivatives behind them.
    """
    otherwise = bool(piece.flipped) or piece.samples is not None or _sticks(piece)
    return len(piece.state) > 0 and not otherwise and piece.system.effects is None


def _sticks(piece: Piece) -> bool:
    rows = [*piece.system.model.switches.equivalent]
    return piece.held is not None and bool((piece.held[rows] == 0.0).any())


def _called(
    functions: SampledFunctions, piece: Piece, states: Floats, numbers: Numbers | None
) -> Floats:
    own = Numbers.alone(piece) if numbers is None else numbers
    return functions(own.prepared(functions), own.which, piece.time, states, piece.held)


_FUNCTIONS: Remembered[Hashable, SampledFunctions | None] = Remembered(MOST_STRUCTURES)


def _functions(
    piece: Piece, what: tuple[str, ...], nodes: Callable[[Model], Sequence[Scalar]]
) -> SampledFunctions | None:
    """Compiled functions of a piece; None for NumPy."""
    if not can_be_compiled(piece):
        return None
    system = piece.system

    def made() -> SampledFunctions | None:
        model = Model(system.topology)
        wanted = nodes(model)
        if not wanted:
            return None
        return SampledFunctions(write_functions_of(model, wanted, ", ".join(what)), LANES)

    return _FUNCTIONS.get((system.structure.key, system.topology.coordinates, what), made)
