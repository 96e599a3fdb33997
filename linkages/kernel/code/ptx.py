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

from linkages.kernel.code.cache import kept
from linkages.kernel.code.cuda import DeviceError
from linkages.kernel.code.instructions import INTEGER, Instructions
from linkages.kernel.code.llvm import Module, call_routine
from linkages.kernel.code.statements import Routine

WIDTH = 32
"""Threads of a warp, which read one row of an array together."""

_TRIPLE = "nvptx64-nvidia-cuda"
_REGISTER = "llvm.nvvm.read.ptx.sreg"


class UnprintedError(DeviceError):
    """A kernel calls functions that graphics processors have no code for.

    Parameters
    ----------
    names
        Of the functions.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        super().__init__(
            f"kernels call {', '.join(names)} of the C library, which graphics processors do not "
            "have; expected functions that linkages.kernel.code.functions writes"
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
    module = lane_functions(routines)
    for routine in routines:
        add_kernel(module, routine.name, (*routine.arguments, "status"))
    return assemble_ptx([module.text], architecture)


def lane_functions(routines: Sequence[Routine]) -> Module:
    """A module with a function ``NAME_lane`` for each routine, which runs it for one state."""
    arrays = {name for routine in routines for name in routine.arguments}
    module = Module(strides=dict.fromkeys(arrays, WIDTH))
    for routine in routines:
        module.add(routine, internal=True)
        code = module.instructions()
        given = {
            name: code.column(f"%{name}", "%lane", max(1, size), WIDTH)
            for name, size in routine.arguments.items()
        }
        if "t" in given:
            given["t"] = code.load(given["t"], 0)
        status = call_routine(code, routine, given)
        place = code.give(f"getelementptr {INTEGER}, ptr %status, {INTEGER} %lane")
        code.say(f"store {INTEGER} {status}, ptr {place}")
        code.say("ret void")
        module.define(lane_signature(routine.name, (*routine.arguments, "status")), code)
    return module


def lane_signature(name: str, arrays: Sequence[str], integers: Sequence[str] = ()) -> str:
    """Signature of the function that a kernel calls: addresses, integers, number of a state."""
    return f"void @{name}_lane({_arguments(arrays, (*integers, 'lane'))})"


def add_kernel(
    module: Module, name: str, arrays: Sequence[str], integers: Sequence[str] = ()
) -> None:
    """Add the kernel ``NAME_lanes``, whose threads call ``NAME_lane`` for the state of theirs.

    Its last argument is the number of states, in place of the number of one.
    """
    code = module.instructions()
    index = _thread(code)
    run, done = code.new_label("run"), code.new_label("done")
    code.branch(code.give(f"icmp ult {INTEGER} {index}, %count"), run, done)
    code.begin(run)
    code.say(f"call void @{name}_lane({_arguments(arrays, integers)}, {INTEGER} {index})")
    code.say(f"br label %{done}")
    code.begin(done)
    code.say("ret void")
    module.define(
        f"ptx_kernel void @{name}_lanes({_arguments(arrays, (*integers, 'count'))})", code
    )


def _arguments(arrays: Sequence[str], integers: Sequence[str]) -> str:
    return ", ".join([*(f"ptr %{a}" for a in arrays), *(f"{INTEGER} %{i}" for i in integers)])


def link(texts: Sequence[str]) -> Any:
    """A module of all functions of some, which may call each other."""
    first, *others = (_llvm().parse_assembly(text) for text in texts)
    for other in others:
        first.link_in(other)
    return first


def assemble_ptx(texts: Sequence[str], architecture: str = "sm_80") -> str:
    """PTX of all functions of some modules, for processors of an architecture and later ones.

    Raises
    ------
    UnprintedError
        One calls a function of the C library.
    """
    key = "\n".join([architecture, *map(str, _llvm().llvm_version_info), *texts])
    content, _ = kept(key, ".ptx", lambda: _assembled(texts, architecture).encode())
    return content.decode()


def _assembled(texts: Sequence[str], architecture: str) -> str:
    llvm, module = _llvm(), link(texts)
    missing = [f.name for f in module.functions if f.is_declaration]
    missing = [name for name in missing if not name.startswith("llvm.")]
    if missing:
        raise UnprintedError(sorted(missing))
    for function in module.functions:
        if not function.is_declaration and not function.name.endswith("_lanes"):
            function.linkage = "internal"  # a part of the kernels, and of nothing else
    target = llvm.Target.from_triple(_TRIPLE).create_target_machine(cpu=architecture, opt=3)
    module.triple, module.data_layout = _TRIPLE, str(target.target_data)
    builder = llvm.create_pass_builder(target, llvm.create_pipeline_tuning_options(3))
    builder.getModulePassManager().run(module, builder)
    return str(target.emit_assembly(module))


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


@cache
def _llvm() -> Any:
    import llvmlite.binding

    llvmlite.binding.initialize_all_targets()
    llvmlite.binding.initialize_all_asmprinters()
    return llvmlite.binding
