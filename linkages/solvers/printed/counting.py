"""Whole turns of dependent angles, written out; see `watched.counting`."""

from __future__ import annotations

from collections.abc import Sequence

from linkages.kernel.code.arcs import arc_of
from linkages.kernel.code.instructions import Instructions
from linkages.solvers.coefficients.tableau import Tableau
from linkages.solvers.printed.shape import Shape, StepMemory
from linkages.solvers.steps.views import TWO_PI


def end_weights(code: Instructions, tableau: Tableau) -> list[tuple[str, int]]:
    """Weights of the rows at the end of a step."""
    return [(code.constant(w), row) for row, w in enumerate(tableau.b.tolist()) if w]


def write_expected(
    code: Instructions, shape: Shape, memory: StepMemory, h: str, weights: Sequence[tuple[str, int]]
) -> None:
    """Write where dependent angles are after a time h, from weights of their speeds in rows."""
    speeds = shape.cosines + 2 * shape.counted
    for i in range(shape.counted):
        mean = code.constant(0.0)
        for weight, row in weights:
            mean = code.fused(weight, code.load(memory.row(row, speeds), i), mean)
        code.store(code.fused(h, mean, code.load(memory["angles"], i)), memory["ahead"], i)


def write_counted(
    code: Instructions, shape: Shape, memory: StepMemory, row: str, into: str, where: str = ""
) -> None:
    """Write the angles in a row, with the turns that bring them closest to where they should be.

    In some lanes, if they are given.
    """
    cosines = code.address(row, shape.cosines)
    turn = code.constant(TWO_PI)
    for i in range(shape.counted):
        sine = code.load(cosines, shape.counted + i)
        angle = arc_of(code, sine, code.load(cosines, i))
        apart = code.subtract(code.load(memory["ahead"], i), angle)
        whole = code.call("llvm.rint", code.divide(apart, turn))
        found = code.fused(turn, whole, angle)
        code.store(code.select(where, found, code.load(into, i)) if where else found, into, i)
