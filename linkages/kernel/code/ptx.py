"""Kernels for NVIDIA's graphics processors: the code for one state, which every thread runs.

LLVM, which comes with llvmlite, writes PTX; NVIDIA's driver makes machine code of it. Operations
carry their rounding (``.rn``), and neither of the two contracts or reorders them. So bits are those
of other processors, as far as IEEE 754 goes.

States stand in blocks of `WIDTH`, the threads of a warp: an array of n entries consists of blocks
of n rows of `WIDTH` numbers, so that threads side by side read numbers side by side.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

from linkages.errors import LinkagesError
from linkages.kernel.code.instructions import INTEGER, Instructions
from linkages.kernel.code.llvm import Module, call_routine
from linkages.kernel.code.statements import Routine

WIDTH = 32
"""Threads of a warp, which read one row of an array together."""

_TRIPLE = "nvptx64-nvidia-cuda"
_REGISTER = "llvm.nvvm.read.ptx.sreg"


class UnprintedError(LinkagesError):
    """A kernel calls functions that graphics processors have no code for.

    Parameters
    ----------
    names
        Of the functions.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        super().__init__(
            f"this mechanism needs {', '.join(names)}, which come from the C library and cannot "
            "run on a graphics processor; expected laws of sums, products, quotients, roots, "
            "sin, cos and tables, or a run on the processor"
        )


def write_ptx(routines: Sequence[Routine], architecture: str = "sm_80") -> str:
    """The text of a module with a kernel ``NAME_lanes`` for each routine.

    Its arguments are the addresses of all arrays of the routine, also of the times, which are an
    array of one entry; that of one status (int64) per state; and the number of states.

    Parameters
    ----------
    routines
        What the kernels do.
    architecture
        Of the processors that are to run it, and of later ones.

    Raises
    ------
    UnprintedError
        A routine calls a function of the C library.
    """
    module = lane_functions(routines, internal=True)
    missing = [name for name in module.declared if not name.startswith("llvm.")]
    if missing:
        raise UnprintedError(sorted(missing))
    for routine in routines:
        _add_kernel(module, routine)
    llvm = _llvm()
    target = llvm.Target.from_triple(_TRIPLE).create_target_machine(cpu=architecture, opt=3)
    parsed = llvm.parse_assembly(module.text)
    parsed.triple, parsed.data_layout = _TRIPLE, str(target.target_data)
    builder = llvm.create_pass_builder(target, llvm.create_pipeline_tuning_options(3))
    builder.getModulePassManager().run(parsed, builder)  # routines become parts of the kernels
    return str(target.emit_assembly(parsed))


def lane_functions(routines: Sequence[Routine], internal: bool = False) -> Module:
    """A module with a function ``NAME_lane`` for each routine, which runs it for one state.

    Parameters
    ----------
    routines
        What they do.
    internal
        Whether only the module itself calls them.
    """
    arrays = {name for routine in routines for name in routine.arguments}
    module = Module(strides=dict.fromkeys(arrays, WIDTH))
    for routine in routines:
        module.add(routine, internal=True)
        code = module.instructions()
        block = code.give(f"udiv {INTEGER} %lane, {WIDTH}")
        column = code.give(f"urem {INTEGER} %lane, {WIDTH}")
        given = {}
        for name, size in routine.arguments.items():
            rows = code.give(f"mul {INTEGER} {block}, {WIDTH * max(1, size)}")
            place = code.give(f"add {INTEGER} {rows}, {column}")
            given[name] = code.give(f"getelementptr double, ptr %{name}, {INTEGER} {place}")
        if "t" in given:
            given["t"] = code.load(given["t"], 0)
        status = call_routine(code, routine, given)
        place = code.give(f"getelementptr {INTEGER}, ptr %status, {INTEGER} %lane")
        code.say(f"store {INTEGER} {status}, ptr {place}")
        code.say("ret void")
        scope = "internal " if internal else ""
        module.define(f"{scope}void @{routine.name}_lane({_arguments(routine)} %lane)", code)
    return module


def _add_kernel(module: Module, routine: Routine) -> None:
    """What a thread does: the state of its number, if there is one."""
    code = module.instructions()
    index = _thread(code)
    run, done = code.new_label("run"), code.new_label("done")
    code.branch(code.give(f"icmp ult {INTEGER} {index}, %count"), run, done)
    code.begin(run)
    given = ", ".join(f"ptr %{name}" for name in (*routine.arguments, "status"))
    code.say(f"call void @{routine.name}_lane({given}, {INTEGER} {index})")
    code.say(f"br label %{done}")
    code.begin(done)
    code.say("ret void")
    module.define(f"ptx_kernel void @{routine.name}_lanes({_arguments(routine)} %count)", code)


def _thread(code: Instructions) -> str:
    """Number of a thread among all."""
    found = []
    for name in ("ctaid.x", "ntid.x", "tid.x"):
        register = f"{_REGISTER}.{name}"
        code.declared[register] = f"i32 @{register}()"
        number = code.give(f"call i32 @{register}()")
        found.append(code.give(f"zext i32 {number} to {INTEGER}"))
    block, size, thread = found
    first = code.give(f"mul {INTEGER} {block}, {size}")
    return code.give(f"add {INTEGER} {first}, {thread}")


def _arguments(routine: Routine) -> str:
    """Arrays, statuses, and the type of a number of states."""
    return ", ".join([*(f"ptr %{name}" for name in (*routine.arguments, "status")), INTEGER])


@cache
def _llvm() -> Any:
    import llvmlite.binding

    llvmlite.binding.initialize_all_targets()
    llvmlite.binding.initialize_all_asmprinters()
    return llvmlite.binding
