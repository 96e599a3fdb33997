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
from linkages.kernel.code.instructions import DOUBLE, INTEGER, Instructions, PrintedLoop
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
from linkages.solvers.loops.shape import Shape, set_whole, whole_row
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
        self, code: Instructions, tableau: Tableau, shape: Shape, sizes: Mapping[str, int]
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
        go_on, spent = code.new_label("go"), code.new_label("spent")
        counters = self._columns["counters"]
        made = code.on_integers(
            "add", whole_row(code, counters, STEPS), whole_row(code, counters, REJECTED)
        )
        left = code.on_integers("sub", whole_row(code, self._columns["budget"], 0), made)
        code.branch(code.give(f"icmp sgt {INTEGER} {left}, 0"), go_on, spent)
        code.begin(spent)
        self._end(str(SPENT))
        code.begin(go_on)
        fewer = code.give(f"icmp slt {INTEGER} {left}, %ticks")
        ticks = code.give(f"select i1 {fewer}, {INTEGER} {left}, {INTEGER} %ticks")
        places = self._places()
        frame = code.reserve(len(FRAME))
        for k, name in enumerate(FRAME):
            code.say(f"store ptr {places[name]}, ptr {code.address(frame, k)}")
        code.declared["advance"] = f"{INTEGER} @advance(ptr, {INTEGER})"
        found = code.give(f"call {INTEGER} @advance(ptr {frame}, {INTEGER} {ticks})")
        count_trials(code, places["pace"], places["counters"], self._tableau.stages)
        copy(code, self._entries, KEPT, places, self._columns)
        pace = places["pace"]
        ended = code.compare("oeq", code.load(pace, T), code.load(pace, END))
        bit = code.give(f"select i1 {ended}, {INTEGER} {ENDED}, {INTEGER} 0")
        self._end(code.on_integers("or", found, bit))

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

    def _end(self, found: str) -> None:
        place = self._code.give(f"getelementptr {INTEGER}, ptr %found, {INTEGER} {self._slot}")
        self._code.say(f"store {INTEGER} {found}, ptr {place}")
        self._code.say("ret void")


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
    more = f"{lists}, ptr %finish, ptr %outcomes, {INTEGER} %first, {INTEGER} %last"
    module.define(f"{INTEGER} @conclude({arrays}, {more})", code)
    return module.text


def _conclude(code: Instructions, arrays: str) -> None:
    """Make the trial again as a motion alone, and finish it if it needs more there, too."""
    loop = PrintedLoop(code, [(INTEGER, "%first")])
    (k,) = loop.values

    def entry(name: str, place: str, kind: str) -> str:
        found = code.give(f"getelementptr {INTEGER}, ptr %{name}, {INTEGER} {place}")
        return code.give(f"load {kind}, ptr {found}")

    slot = entry("slots", k, INTEGER)
    frame, context, advance = (entry(n, slot, "ptr") for n in ("frames", "contexts", "advances"))
    given = f"{arrays}, ptr {frame}, {INTEGER} {slot}"
    code.say(f"call {INTEGER} @leave({given})")
    found = code.give(f"call {INTEGER} {advance}(ptr {frame}, {INTEGER} 1)")
    flag = code.on_integers("and", found, str(FLAGGED))
    finish, on = code.new_label("finish"), code.new_label("on")
    before = code.block
    code.branch(code.give(f"icmp ne {INTEGER} {flag}, 0"), finish, on)
    code.begin(finish)
    outcome = code.give(f"call {INTEGER} %finish(ptr {context})")
    code.say(f"br label %{on}")
    code.begin(on)
    became = code.give(f"phi {INTEGER} [ 0, %{before} ], [ {outcome}, %{finish} ]")
    set_whole(code, became, "%outcomes", slot)
    code.say(f"call {INTEGER} @enter({given})")
    following = code.on_integers("add", k, "1")
    loop.repeat(code.give(f"icmp slt {INTEGER} {following}, %last"), [following])
    code.say(f"ret {INTEGER} 0")


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


def count_trials(code: Instructions, pace: str, counters: str, evaluations: int) -> None:
    """Count the steps that were made and rejected, with so many evaluations for each."""
    both = []
    for entry, counter in ((TAKEN, STEPS), (REJECTIONS, REJECTED)):
        made = code.give(f"fptosi {DOUBLE} {code.load(pace, entry)} to {INTEGER}")
        code.store(code.constant(0.0), pace, entry)
        before = whole_row(code, counters, counter)
        set_whole(code, code.on_integers("add", before, made), counters, counter)
        both.append(made)
    trials = code.on_integers("mul", code.on_integers("add", *both), str(evaluations))
    before = whole_row(code, counters, EVALUATIONS)
    set_whole(code, code.on_integers("add", before, trials), counters, EVALUATIONS)
