"""Adaptive steps on graphics processors: every thread moves one motion, until a step needs more.

The functions are those of single motions, see `linkages.solvers.loops.explicit_steps`; the kernel
becomes part of them. So a thread takes samples and counts turns as well; the workspace belongs to
it.

Motions stand in slots. What is kept of them between calls stands in blocks of columns, as
`linkages.kernel.code.cuda` has them, and their samples one motion after the other. What a slot
holds is what the frame of a single motion holds: code for this processor (`write_slots`) copies one
to the other, and finishes steps that need more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from linkages.kernel.code.cuda import WIDTH, add_kernel, assemble_ptx, lane_signature
from linkages.kernel.code.instructions import DOUBLE, INTEGER, Instructions
from linkages.kernel.code.operands import Reals, Whole, Wholes, choose_of, smaller_of
from linkages.kernel.code.procedure import Procedure
from linkages.kernel.code.statements import Routine
from linkages.kernel.code.writer import Module
from linkages.solvers.loops.explicit_steps import write_step
from linkages.solvers.loops.memory import (
    END,
    EVALUATIONS,
    FRAME,
    PACE,
    REJECTED,
    REJECTIONS,
    STEPS,
    SWITCH,
    TAKEN,
    T,
)
from linkages.solvers.loops.shape import Shape
from linkages.solvers.tableau import Tableau

GIVEN = ("parameters", "held", "atol", "scale", "smallest")
KEPT = ("rows", "pace", "turns", "angles", "ahead", "counters")
"""Arrays of a motion's frame that steps read, and those that they change as well."""

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


def slot_entries(shape: Shape, parameters: int) -> dict[str, int]:
    """Number of entries of each array of `SLOTS` for a motion; of the rows it is the first one."""
    return {
        "budget": 1,
        "parameters": parameters,
        "held": len(shape.active),
        "atol": 2 * shape.n,
        "scale": shape.blocks,
        "smallest": shape.blocks,
        "rows": shape.width,
        "pace": PACE,
        "turns": shape.n,
        "angles": shape.counted,
        "ahead": shape.counted,
        "counters": SWITCH + 1,
    }


def series_entries(shape: Shape) -> dict[str, int]:
    """Number of entries of each array of `SERIES` for a sample; of the times there is one more."""
    n = shape.n
    return {
        "times": 1,
        "states": 2 * n,
        "sampled_turns": n,
        "accelerations": n,
        "sampled": shape.counted,
    }


def write_device_steps(
    tableau: Tableau,
    shape: Shape,
    routines: Sequence[Routine],
    gain: float = 0.0,
    architecture: str = "sm_80",
) -> str:
    """PTX with a kernel ``advance_lanes``, of the arguments `ARRAYS`, `INTEGERS` and a count.

    To each motion's entry of ``found`` goes what became of it, and in the upper half the number of
    trials.

    Parameters
    ----------
    tableau, shape, gain
        As `linkages.solvers.loops.explicit_steps.write_step` has them.
    """
    module = lane_function(tableau, shape, routines)
    add_kernel(module, "advance", ARRAYS, INTEGERS)
    # called by address, functions would need a stack of a size that nobody knows
    step = write_step(tableau, replace(shape, linked=True), gain)
    return assemble_ptx([module.text, step], architecture)


def lane_function(tableau: Tableau, shape: Shape, routines: Sequence[Routine]) -> Module:
    """A module with the kernel and ``advance_lane``, which is what a thread does.

    It calls ``advance`` of `loops.explicit_steps.write_step`, with which it is linked.
    """
    module = Module(strides={"p": WIDTH})
    for routine in routines:
        if routine.name != "prepare":
            module.add(routine)
    code = module.instructions()
    sizes = {name: size for routine in routines for name, size in routine.arguments.items()}
    _Thread(code, tableau, shape, sizes).write()
    module.define(lane_signature("advance", ARRAYS, INTEGERS), code)
    return module


class _Thread:
    """Writes what a thread does: makes steps in a workspace of its own.

    Parameters
    ----------
    code, tableau, shape
        Where, and of what.
    sizes
        Array of the kernel → number of its entries.
    """

    def __init__(
        self, code: Procedure, tableau: Tableau, shape: Shape, sizes: Mapping[str, int]
    ) -> None:
        self._code, self._tableau, self._shape = code, tableau, shape
        self._timed = max(1, sizes["timed"])
        self._entries = slot_entries(shape, sizes["p"])
        place = code.give(f"getelementptr {INTEGER}, ptr %which, {INTEGER} %lane")
        self._slot = code.give(f"load {INTEGER}, ptr {place}")
        self._columns = columns(code, self._entries, self._slot)

    def write(self) -> None:
        """Write the body of the function."""
        code = self._code
        counters, budget = (Wholes(code, self._columns[name]) for name in ("counters", "budget"))
        left = budget[0] - (counters[STEPS] + counters[REJECTED])
        with code.when(left <= 0):
            self._end(code.value(SPENT))
        ticks = smaller_of(left, Whole(code, "%ticks"))
        places = self._places()
        frame = code.reserve(len(FRAME))
        for k, name in enumerate(FRAME):
            code.say(f"store ptr {places[name]}, ptr {code.address(frame, k)}")
        code.declared["advance"] = f"{INTEGER} @advance(ptr, {INTEGER})"
        found = Whole(
            code, code.give(f"call {INTEGER} @advance(ptr {frame}, {INTEGER} {ticks.text})")
        )
        pace = Reals(code, places["pace"])
        count_trials(pace, Wholes(code, places["counters"]), self._tableau.stages)
        copy(code, self._entries, KEPT, places, self._columns)
        self._end(found + choose_of(Whole, pace[T] == pace[END], ENDED, 0))

    def _places(self) -> dict[str, str]:
        """Arrays of the frame: the thread's own, or those of its slot."""
        code, entries = self._code, self._entries
        own = {name: entries[name] for name in (*GIVEN, *KEPT) if name != "parameters"}
        own["rows"] = (len(self._tableau.extended_c) + 1) * self._shape.width
        places = {name: code.reserve(max(1, size)) for name, size in own.items()}
        copy(code, entries, own, self._columns, places)
        for name, size in series_entries(self._shape).items():
            room = "%samples"
            if name == "times":
                room = code.on_integers("add", room, "1")
            first = code.on_integers("mul", self._slot, code.on_integers("mul", room, str(size)))
            places[name] = code.give(f"getelementptr {DOUBLE}, ptr %{name}, {INTEGER} {first}")
        places["parameters"] = self._columns["parameters"]
        places["timed"] = code.reserve(self._timed)
        return dict.fromkeys(FRAME, "null") | places  # there are no events; functions have names

    def _end(self, found: Whole) -> None:
        code = self._code
        place = code.give(f"getelementptr {INTEGER}, ptr %found, {INTEGER} {self._slot}")
        Wholes(code, place)[0] = found
        code.leave()


def write_slots(shape: Shape, parameters: int) -> str:
    """The text of a module for this processor: motions in slots, and motions alone.

    All functions take the arrays `SLOTS`. ``int64 enter(…, frame, slot)`` copies a motion into a
    slot, and ``leave(…, frame, slot)`` what steps have changed back. ``conclude(…, slots, frames,
    contexts, advances, finish, outcomes, first, last)`` finishes steps that need more, of the
    motions in some slots: their frames, contexts and functions ``advance`` are given by slot, and
    what the function ``finish`` returns goes to their outcomes.
    """
    entries, module = slot_entries(shape, parameters), Module()
    arrays = ", ".join(f"ptr %{name}" for name in SLOTS)
    for name, chosen in (("enter", (*GIVEN, *KEPT)), ("leave", KEPT)):
        code = module.instructions()
        placed, held = columns(code, entries, "%slot"), _framed(code, "%frame")
        source, target = (held, placed) if name == "enter" else (placed, held)
        copy(code, entries, chosen, source, target)
        code.say(f"ret {INTEGER} 0")
        module.define(f"{INTEGER} @{name}({arrays}, ptr %frame, {INTEGER} %slot)", code)
    code = module.instructions()
    _conclude(code, arrays)
    lists = ", ".join(f"ptr %{name}" for name in ("slots", "frames", "contexts", "advances"))
    more = f"{lists}, {INTEGER} %finish, ptr %outcomes, {INTEGER} %first, {INTEGER} %last"
    module.define(f"{INTEGER} @conclude({arrays}, {more})", code)
    return module.text


def _conclude(code: Procedure, arrays: str) -> None:
    """Make the trial again as a motion alone, and finish it if it needs more there, too."""
    first = Whole(code, "%first")
    with code.count(Whole(code, "%last") - first) as k:
        slot = Wholes(code, "%slots")[first + k]
        frame, context, advance = (
            Wholes(code, f"%{name}")[slot] for name in ("frames", "contexts", "advances")
        )
        pointer = code.give(f"inttoptr {INTEGER} {frame.text} to ptr")
        given = f"{arrays}, ptr {pointer}, {INTEGER} {slot.text}"
        code.say(f"call {INTEGER} @leave({given})")
        became = code.variable(0)
        found = code.call_at(advance, Whole, frame, code.value(1))
        with code.when(found & FLAGGED != 0):
            became.set(code.call_at(Whole(code, "%finish"), Whole, context))
        Wholes(code, "%outcomes")[slot] = became
        code.say(f"call {INTEGER} @enter({given})")
    code.leave(0)


def columns(code: Instructions, entries: Mapping[str, int], slot: str) -> dict[str, str]:
    """Address of the column of a slot in each array."""
    return {n: code.column(f"%{n}", slot, max(1, e), WIDTH) for n, e in entries.items()}


def _framed(code: Instructions, frame: str) -> dict[str, str]:
    """Address of each array of a frame."""
    found = {}
    for k, name in enumerate(FRAME):
        place = code.give(f"getelementptr {INTEGER}, ptr {frame}, {INTEGER} {k}")
        found[name] = code.give(f"load ptr, ptr {place}")
    return found


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


def count_trials(pace: Reals, counters: Wholes, evaluations: int) -> None:
    """Count the steps that were made and rejected, with so many evaluations for each."""
    for entry, counter in ((TAKEN, STEPS), (REJECTIONS, REJECTED)):
        made = pace[entry].whole
        pace[entry] = 0.0
        counters[counter] += made
        counters[EVALUATIONS] += evaluations * made
