"""Adaptive steps on graphics processors: every thread moves one motion, until a step needs more.

The functions are those of single motions, see `linkages.solvers.loops.explicit_steps`, with the
kernel as a part of them. Motions occupy slots, whose arrays are kept in blocks of columns between
calls, as `linkages.kernel.code.cuda` has them, and their samples one motion after the other. Code
for this processor (`write_slots`) copies between slots and motions, and finishes flagged steps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from linkages.kernel.code.cuda import WIDTH, add_kernel, assemble_ptx, lane_signature
from linkages.kernel.code.instructions import DOUBLE, INTEGER, Instructions
from linkages.kernel.code.operands import Function, Int, IntArray, minimum, select_of
from linkages.kernel.code.procedure import Procedure
from linkages.kernel.code.statements import Routine
from linkages.kernel.code.writer import Module
from linkages.solvers.loops.explicit_steps import write_step
from linkages.solvers.loops.memory import Counters, Motion, Pointers, Stepper
from linkages.solvers.loops.row_layout import RowLayout, entries_of_motion
from linkages.solvers.tableau import Tableau

GIVEN = ("parameters", "held", "atol", "scale", "smallest")
KEPT = ("rows", "stepper", "turns", "angles", "ahead", "counters")
"""Arrays of a motion that steps read, and those that they change as well."""

SERIES = ("times", "states", "sampled_turns", "accelerations", "sampled")
"""Those of its samples."""

SLOTS = ("budget", *GIVEN, *KEPT)
"""What slots hold beside samples, in columns; the budget is the most trials of a motion."""

ARRAYS = ("which", *SLOTS, *SERIES, "found")
"""Arrays of the kernel; the first has the slot of each thread, the last what became of it."""

INTEGERS = ("samples", "ticks")
"""Its integers: for how many samples there is room in a slot, and most trials in a row."""

FLAGGED, ENDED, SPENT = 1, 2, 4
"""What became of a motion: a step needs more, it is at its end, it has used up its trials."""


def slot_entries(layout: RowLayout, parameters: int) -> dict[str, int]:
    """Number of entries of each array of `SLOTS` for a motion; of the rows it is the first one."""
    sizes = {
        "budget": 1,
        "parameters": parameters,
        "held": len(layout.active),
        "rows": layout.width,
        "counters": len(Counters.entries()),
        **entries_of_motion(layout),
    }
    return {name: sizes[name] for name in SLOTS}


def series_entries(layout: RowLayout) -> dict[str, int]:
    """Number of entries of each array of `SERIES` for a sample; of the times there is one more."""
    n = layout.n
    return {
        "times": 1,
        "states": 2 * n,
        "sampled_turns": n,
        "accelerations": n,
        "sampled": layout.counted,
    }


def write_device_steps(
    tableau: Tableau,
    layout: RowLayout,
    routines: Sequence[Routine],
    gain: float = 0.0,
    architecture: str = "sm_80",
) -> str:
    """PTX with a kernel ``advance_lanes``, of the arguments `ARRAYS`, `INTEGERS` and a count.

    Each motion's entry of ``found`` gets what became of it, and in the upper half the number of
    trials.
    """
    module = lane_function(tableau, layout, routines)
    add_kernel(module, "advance", ARRAYS, INTEGERS)
    # called by address, functions would need a stack of a size that nobody knows
    step = write_step(tableau, replace(layout, linked=True), gain)
    return assemble_ptx([module.text, step], architecture)


def lane_function(tableau: Tableau, layout: RowLayout, routines: Sequence[Routine]) -> Module:
    """A module with the kernel and ``advance_lane``, which calls ``advance``, linked with it."""
    module = Module(strides={"p": WIDTH})
    for routine in routines:
        if routine.name != "prepare":
            module.add(routine)
    code = module.instructions()
    sizes = {name: size for routine in routines for name, size in routine.arguments.items()}
    _Thread(code, tableau, layout, sizes).write()
    module.define(lane_signature("advance", ARRAYS, INTEGERS), code)
    return module


class _Thread:
    """Writes what a thread does: makes steps in a workspace of its own."""

    def __init__(
        self, code: Procedure, tableau: Tableau, layout: RowLayout, sizes: Mapping[str, int]
    ) -> None:
        self._code, self._tableau, self._layout = code, tableau, layout
        self._timed = max(1, sizes["timed"])
        self._entries = slot_entries(layout, sizes["p"])
        place = code.assign(f"getelementptr {INTEGER}, ptr %which, {INTEGER} %lane")
        self._slot = code.assign(f"load {INTEGER}, ptr {place}")
        self._columns = columns(code, self._entries, self._slot)

    def write(self) -> None:
        code = self._code
        counters, budget = Counters(code, self._columns["counters"]), self._columns["budget"]
        left = IntArray(code, budget)[0] - (counters.steps + counters.rejected)
        with code.if_(left <= 0):
            self._end(code.value(SPENT))
        ticks = minimum(left, Int(code, "%ticks"))
        places = self._places()
        motion = code.alloca(Pointers.words())
        for name, k in Pointers.places().items():
            code.emit(f"store ptr {places[name]}, ptr {code.address(motion, k)}")
        code.declared["advance"] = f"{INTEGER} @advance(ptr, {INTEGER})"
        call = f"call {INTEGER} @advance(ptr {motion}, {INTEGER} {ticks.text})"
        result = Int(code, code.assign(call))
        stepper = Stepper(code, places["stepper"])
        count_trials(stepper, Counters(code, places["counters"]), self._tableau.stages)
        copy(code, self._entries, KEPT, places, self._columns)
        self._end(result + select_of(Int, stepper.t == stepper.end, ENDED, 0))

    def _places(self) -> dict[str, str]:
        """Arrays of the pointers: the thread's own, or those of its slot."""
        code, entries = self._code, self._entries
        own = {name: entries[name] for name in (*GIVEN, *KEPT) if name != "parameters"}
        own["rows"] = (len(self._tableau.extended_c) + 1) * self._layout.width
        places = {name: code.alloca(max(1, size)) for name, size in own.items()}
        copy(code, entries, own, self._columns, places)
        for name, size in series_entries(self._layout).items():
            room = "%samples"
            if name == "times":
                room = code.int_operation("add", room, "1")
            first = code.int_operation(
                "mul", self._slot, code.int_operation("mul", room, str(size))
            )
            places[name] = code.assign(f"getelementptr {DOUBLE}, ptr %{name}, {INTEGER} {first}")
        places["parameters"] = self._columns["parameters"]
        places["timed"] = code.alloca(self._timed)
        # there are no events; functions have names
        return dict.fromkeys(Pointers.places(), "null") | places

    def _end(self, found: Int) -> None:
        code = self._code
        place = code.assign(f"getelementptr {INTEGER}, ptr %found, {INTEGER} {self._slot}")
        IntArray(code, place)[0] = found
        code.return_()


def write_slots(layout: RowLayout, parameters: int) -> str:
    """The text of a module for this processor: motions in slots, and motions alone.

    All functions take the arrays `SLOTS`. ``int64 enter(…, motion, slot)`` copies a motion into a
    slot, and ``leave(…, motion, slot)`` copies back what steps have changed. ``conclude(…, slots,
    motions, finish, outcomes, first, last)`` finishes flagged steps of the motions in some slots.
    """
    entries, module = slot_entries(layout, parameters), Module()
    arrays = ", ".join(f"ptr %{name}" for name in SLOTS)
    for name, chosen in (("enter", (*GIVEN, *KEPT)), ("leave", KEPT)):
        code = module.instructions()
        placed, motion = columns(code, entries, "%slot"), Pointers(code, "%motion")
        held = {name: getattr(motion, name).pointer for name in chosen}
        source, target = (held, placed) if name == "enter" else (placed, held)
        copy(code, entries, chosen, source, target)
        code.emit(f"ret {INTEGER} 0")
        module.define(f"{INTEGER} @{name}({arrays}, ptr %motion, {INTEGER} %slot)", code)
    code = module.instructions()
    _conclude(code, arrays)
    more = (
        f"ptr %slots, ptr %motions, ptr %finish, ptr %outcomes, {INTEGER} %first, {INTEGER} %last"
    )
    module.define(f"{INTEGER} @conclude({arrays}, {more})", code)
    return module.text


def _conclude(code: Procedure, arrays: str) -> None:
    """Make the trial again as a motion alone, and finish it if it needs more there, too."""
    first = Int(code, "%first")
    with code.for_range(Int(code, "%last") - first) as k:
        slot = IntArray(code, "%slots")[first + k]
        motion = Motion.at(IntArray(code, "%motions")[slot])
        given = f"{arrays}, ptr {motion.pointer}, {INTEGER} {slot.text}"
        code.emit(f"call {INTEGER} @leave({given})")
        became = code.variable(0)
        result = motion.advance(Int, motion, code.value(1))
        with code.if_(result & FLAGGED != 0):
            became.set(Function(code, "%finish")(Int, motion))
        IntArray(code, "%outcomes")[slot] = became
        code.emit(f"call {INTEGER} @enter({given})")
    code.return_(0)


def columns(code: Instructions, entries: Mapping[str, int], slot: str) -> dict[str, str]:
    """Address of the column of a slot in each array."""
    return {n: code.column(f"%{n}", slot, max(1, e), WIDTH) for n, e in entries.items()}


def copy(
    code: Instructions,
    entries: Mapping[str, int],
    names: Sequence[str] | Mapping[str, int],
    source: Mapping[str, str],
    target: Mapping[str, str],
) -> None:
    """Copy arrays entry by entry; bits of integers are copied as well."""
    for name in names:
        for i in range(entries[name]):
            code.store(code.load(source[name], i), target[name], i)


def count_trials(stepper: Stepper, counters: Counters, evaluations: int) -> None:
    """Count the steps that were made and rejected, with so many evaluations for each."""
    accepted, rejected = stepper.accepted_steps.to_int, stepper.rejected_steps.to_int
    stepper.accepted_steps, stepper.rejected_steps = 0.0, 0.0
    counters.steps += accepted
    counters.rejected += rejected
    counters.evaluations += evaluations * (accepted + rejected)
