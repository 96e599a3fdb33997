"""Compiled steps: one module for all flows of a shape and a tableau."""

from __future__ import annotations

from functools import lru_cache

from linkages.kernel.code.llvm import Module
from linkages.kernel.code.machine import MachineCode
from linkages.solvers.coefficients.tableau import Tableau
from linkages.solvers.printed.advance import Advance
from linkages.solvers.printed.samples import (
    write_begin,
    write_between,
    write_first,
    write_interpolation,
    write_sample,
    write_samples,
)
from linkages.solvers.printed.shape import Shape, StepMemory, set_whole
from linkages.solvers.printed.stages import Stages
from linkages.solvers.steps.views import STATUS


def write_step(tableau: Tableau, shape: Shape, gain: float = 0.0, lanes: int = 1) -> str:
    """The text of a module with the functions of a step, which take the address of a frame.

    ``int64 attempt(frame)`` steps from row 0 to the end, over a time in the pace, and returns a
    status; ``int64 further(frame)`` computes the further rows of the dense output. Tableaus with an
    error estimate have ``int64 advance(frame, ticks)``, which goes on until a step needs more than
    arithmetic, and returns the number of trials in the upper half, below a bit for each lane that
    does. All arrays of several lanes consist of rows of W entries, their statuses stand in the
    pace, and ``int64 between(frame)`` evaluates states within a step.

    Parameters
    ----------
    tableau, shape
        Of the step.
    gain
        As `linkages.solvers.printed.control.next_factor` has it.
    lanes
        Number W of states side by side.
    """
    module = Module(lanes)
    rows, last = len(tableau.extended_c) - 1, tableau.stages
    for name, first, end in (("attempt", 1, last), ("further", last + 1, rows)):
        code = module.instructions()
        memory = StepMemory(code, shape)
        status = Stages(code, tableau, shape, memory).write(first, end)
        if lanes == 1:
            code.say("ret i64 0")
            module.define(f"i64 @{name}(ptr %frame)", code)
        else:
            set_whole(code, status, memory["pace"], STATUS)
            code.say("ret i64 0")
            module.define(f"i64 @{name}(ptr %frame)", code)
    if lanes == 1:
        _single(module, tableau, shape)
    else:
        code = module.instructions()
        write_between(code, tableau, shape)
        module.define("i64 @between(ptr %frame)", code)
    if tableau.error.size:
        code = module.instructions()
        Advance(code, tableau, shape, gain).write()
        module.define("i64 @advance(ptr %frame, i64 %ticks)", code)
    return module.text


def _single(module: Module, tableau: Tableau, shape: Shape) -> None:
    """What a single motion has beside its steps."""
    code = module.instructions()
    write_interpolation(code, tableau, shape)
    module.define("i64 @interpolate(ptr %frame)", code)
    code = module.instructions()
    write_first(code, shape, tableau.error_order)
    module.define("i64 @first(ptr %frame)", code)
    code = module.instructions()
    write_sample(code, shape)
    module.define("i64 @sample(ptr %frame, ptr %row)", code)
    code = module.instructions()
    write_samples(code, tableau, shape)
    module.define("internal i64 @samples(ptr %frame)", code)
    code = module.instructions()
    write_begin(code, shape)
    module.define("i64 @begin(ptr %frame)", code)


@lru_cache(maxsize=256)
def compiled_step(tableau: Tableau, shape: Shape, gain: float = 0.0, lanes: int = 1) -> MachineCode:
    """The functions of a step as machine code; see `write_step`."""
    return MachineCode(write_step(tableau, shape, gain, lanes))
