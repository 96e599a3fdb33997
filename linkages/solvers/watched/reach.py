"""How far a step can be made that leaves the reach of a block."""

from __future__ import annotations

from linkages.solvers.steps.compiled import compiled, integers
from linkages.solvers.steps.stages import try_step
from linkages.solvers.steps.views import EVALUATIONS, Record, SystemView, TableView

BISECTIONS = 60


@compiled
def reachable_part(
    system: SystemView, table: TableView, record: Record, t: float, h: float
) -> float:
    """Longest fraction of a failed step that can be made, left in the workspace."""
    made, failed = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (made + failed)
        if try_step(system, t, middle * h, t + middle * h) == 0:
            made = middle
        else:
            failed = middle
    integers(record.counters)[EVALUATIONS] += (BISECTIONS + 1) * table.end
    if made > 0.0:
        try_step(system, t, made * h, t + made * h)
    return made
