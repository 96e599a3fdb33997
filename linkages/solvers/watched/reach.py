"""How far a step can be made that leaves the reach of a block."""

from __future__ import annotations

from linkages.kernel.code.operands import Real, integers
from linkages.kernel.code.printed import printed
from linkages.kernel.code.procedure import Procedure
from linkages.solvers.steps.stages import try_step
from linkages.solvers.steps.views import EVALUATIONS, Record, SystemView, TableView

BISECTIONS = 60


@printed
def reachable_part(
    code: Procedure, system: SystemView, table: TableView, record: Record, t: Real, h: Real
) -> Real:
    """Longest fraction of a failed step that can be made, left in the workspace."""
    made, failed = code.variable(0.0), code.variable(1.0)
    with code.count(BISECTIONS):
        middle = 0.5 * (made + failed)
        with code.when(try_step(system, t, middle * h, t + middle * h) == 0) as case:
            made.set(middle)
        with case.otherwise():
            failed.set(middle)
    integers(record.counters)[EVALUATIONS] += (BISECTIONS + 1) * table.end
    with code.when(made > 0.0):
        try_step(system, t, made * h, t + made * h)
    return code.value(made)
