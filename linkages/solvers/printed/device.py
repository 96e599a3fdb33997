"""Adaptive steps on graphics processors: every thread moves one motion, until a step needs more.

The functions are those of single motions, see `linkages.solvers.printed.step`; the kernel becomes
part of them. The workspace of a step belongs to its thread. What is kept between calls stands in
blocks of columns, as `linkages.kernel.code.ptx` has them.
"""

from __future__ import annotations

from collections.abc import Sequence

from linkages.kernel.code.instructions import INTEGER, Instructions
from linkages.kernel.code.llvm import Module
from linkages.kernel.code.ptx import WIDTH, add_kernel, assemble_ptx, lane_signature
from linkages.kernel.code.statements import Routine
from linkages.solvers.coefficients.tableau import Tableau
from linkages.solvers.printed.shape import Shape
from linkages.solvers.printed.step import write_step
from linkages.solvers.steps.views import FRAME, PACE

GIVEN = ("atol", "scale", "smallest")
KEPT = ("rows", "pace", "turns")
"""Arrays of a motion's frame that steps read, and those that they change as well."""

ARRAYS = ("p", *GIVEN, *KEPT, "found")
"""Arguments of the kernel."""


def entries_of(shape: Shape) -> dict[str, int]:
    """Number of entries of each array that stays between calls; of the rows it is the first one."""
    return {
        "atol": 2 * shape.n,
        "scale": shape.blocks,
        "smallest": shape.blocks,
        "rows": shape.width,
        "pace": PACE,
        "turns": shape.n,
    }


def write_device_steps(
    tableau: Tableau,
    shape: Shape,
    routines: Sequence[Routine],
    gain: float = 0.0,
    architecture: str = "sm_80",
) -> str:
    """PTX with a kernel ``advance_lanes``.

    Its arguments are the addresses of the parameters, of the arrays in `entries_of`, and of one
    integer per motion, to which goes what ``advance`` returns; most trials in a row; and the number
    of motions.

    Parameters
    ----------
    tableau, shape, gain
        As `linkages.solvers.printed.step.write_step` has them.
    routines
        Of the kernel.
    architecture
        Of the processors that are to run it, and of later ones.

    Raises
    ------
    UnprintedError
        The kernel calls a function of the C library.
    """
    module = lane_function(tableau, shape, routines)
    add_kernel(module, "advance", ARRAYS, ["ticks"])
    return assemble_ptx([module.text, write_step(tableau, shape, gain)], architecture)


def lane_function(tableau: Tableau, shape: Shape, routines: Sequence[Routine]) -> Module:
    """A module with the kernel and ``advance_lane``, which is what a thread does.

    It calls ``advance`` of `linkages.solvers.printed.step.write_step`, with which it is linked.
    """
    module = Module(strides={"p": WIDTH})
    for routine in routines:
        if routine.name != "prepare":
            module.add(routine)
    code = module.instructions()
    sizes = {name: size for routine in routines for name, size in routine.arguments.items()}
    _move(code, tableau, shape, sizes)
    module.define(lane_signature("advance", ARRAYS, ["ticks"]), code)
    return module


def _move(code: Instructions, tableau: Tableau, shape: Shape, sizes: dict[str, int]) -> None:
    """Make steps in a workspace that begins with what is kept of a motion."""
    entries = entries_of(shape)
    columns = {n: code.column(f"%{n}", "%lane", max(1, e), WIDTH) for n, e in entries.items()}
    room = entries | {"rows": (tableau.stages + 1) * shape.width}
    places = {name: code.reserve(max(1, size)) for name, size in room.items()}
    for name in (*GIVEN, *KEPT):
        for i in range(entries[name]):
            code.store(code.load(columns[name], i), places[name], i)
    places |= {"clock": "@clock", "rates": "@rates"}
    places["parameters"] = code.column("%p", "%lane", max(1, sizes["p"]), WIDTH)
    places["timed"] = code.reserve(max(1, sizes["timed"]))
    frame = code.reserve(len(FRAME))
    for k, name in enumerate(FRAME):
        code.say(f"store ptr {places[name]}, ptr {code.address(frame, k)}")
    code.declared["advance"] = f"{INTEGER} @advance(ptr, {INTEGER})"
    found = code.give(f"call {INTEGER} @advance(ptr {frame}, {INTEGER} %ticks)")
    for name in KEPT:
        for i in range(entries[name]):
            code.store(code.load(places[name], i), columns[name], i)
    place = code.give(f"getelementptr {INTEGER}, ptr %found, {INTEGER} %lane")
    code.say(f"store {INTEGER} {found}, ptr {place}")
    code.say("ret void")
