"""Layout of rows of the workspace, access to memory from generated code, and stages of a step."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.code.instructions import DOUBLE, INTEGER
from linkages.kernel.code.operands import (
    Bool,
    Int,
    IntArray,
    Place,
    Real,
    RealArray,
    fma,
    rint,
    select,
    select_of,
)
from linkages.kernel.code.procedure import Procedure
from linkages.solvers.flow import Flow, Renormalisation
from linkages.solvers.loops.memory import (
    FUNCTION,
    HALF,
    LARGEST_ANGLE,
    LARGEST_STATE,
    NOT_FINITE,
    STEPPER_SIZE,
    TWO_PI,
    TWO_PI_TAIL,
    VALUES,
    KernelTable,
    Pointers,
)
from linkages.solvers.tableau import Tableau
from linkages.solvers.trajectory import Event

MOST_TANGENTS = 8
"""Tangents that are made orthogonal to see how far they are apart: texts grow with their square."""

_NONE = (0, 0, 0, False)


@dataclass(frozen=True)
class RowLayout:
    """What stands where in a row of the workspace; see `linkages.solvers.loops.memory.Pointers`.

    `linked` says that the functions of the flow become part of the same module and are called by
    name, not by the addresses in the pointers.
    """

    n: int
    blocks: int
    first_carried: int
    carried: int
    counted: int
    width: int
    rotates: tuple[bool, ...]
    tangents: tuple[int, int, int, bool] = _NONE
    active: tuple[int, ...] = ()
    events: int = 0
    linked: bool = False

    @classmethod
    def of(
        cls, flow: Flow, tangents: Renormalisation | None = None, events: Sequence[Event] = ()
    ) -> RowLayout:
        """That of a flow, of tangents and of events that are watched."""
        own = _NONE
        if tangents is not None and is_compiled(tangents):
            own = tangents.columns, tangents.size, tangents.placed, tangents.orthogonal
        return cls(
            tangents=own,
            events=len(events) if are_compiled(events) else 0,
            n=flow.coordinates,
            blocks=len(flow.margin_scale),
            first_carried=flow.first_carried,
            carried=flow.carried,
            counted=flow.counted,
            width=2 * flow.coordinates + flow.written,
            rotates=tuple(flow.rotates.tolist()),
            active=() if flow.switching is None else flow.switching.active,
        )

    def turning(self, code: Procedure) -> Iterator[Any]:
        """Write what follows for each coordinate that is an angle, as `for_entries` does."""
        first = 0
        for rotates, run in groupby(self.rotates):
            count = len(list(run))
            if rotates:
                for i in code.for_entries(count):
                    yield first + i
            first += count

    @property
    def margins(self) -> int:
        """Place of the margins in a row; their rates follow."""
        return 3 * self.n

    @property
    def settled(self) -> int:
        """Place of what was found of coordinates that are carried along; its rates follow."""
        return 3 * self.n + 2 * self.blocks

    @property
    def functions(self) -> int:
        """Place of the functions of switches; their rates follow."""
        return self.width - 2 * len(self.active)

    @property
    def cosines(self) -> int:
        """Place of the cosines of dependent angles; sines and speeds follow."""
        return self.settled + 2 * self.carried


def entries_of_motion(layout: RowLayout) -> dict[str, int]:
    """Number of entries of arrays that each motion has for itself, in lanes and slots as well."""
    return {
        "stepper": STEPPER_SIZE,
        "atol": 2 * layout.n,
        "scale": layout.blocks,
        "smallest": layout.blocks,
        "turns": layout.n,
        "angles": layout.counted,
        "ahead": layout.counted,
        "values": VALUES * layout.events,
        "levels": layout.events,
    }


def is_compiled(tangents: Renormalisation) -> bool:
    """Whether generated code sees where tangents are to be renormalised."""
    return tangents.columns <= MOST_TANGENTS or not tangents.orthogonal


def are_compiled(events: Sequence[Event]) -> bool:
    """Whether generated code sees where events may happen."""
    return all(event.function is not None for event in events)


class StepMemory(Pointers):
    """Arrays of a motion or of lanes, for generated code, which knows the layout of their rows."""

    def __init__(self, code: Procedure, layout: RowLayout) -> None:
        super().__init__(code, "%motion")
        self._layout = layout

    def row(self, row: int, place: int = 0) -> RealArray:
        """A row of the workspace, from one of its entries on."""
        return self.rows.after(row * self._layout.width + place)

    def event(self, event: int) -> KernelTable:
        """The functions of an event."""
        first = f"getelementptr {INTEGER}, ptr {self.functions.pointer}, i64 {FUNCTION * event}"
        return KernelTable(self.code, self.code.assign_at_entry(first))

    def call_clock(self, time: Real, kernel: KernelTable | None = None) -> Int:
        """Evaluate what depends on time alone; returns the statuses of the flow, or of others."""
        code, called = self.code, kernel or self
        function = self._function("clock", f"{DOUBLE}, ptr, ptr", kernel)
        rest = f"ptr {called.parameters.pointer}, ptr {called.timed.pointer}"
        if code.lanes == 1:
            given = f"{DOUBLE} {time.text}, {rest}"
            return Int(code, code.assign(f"call {INTEGER} {function}({given})"))
        row = RealArray(code, code.alloca(1))
        row[0] = time
        return self._statuses(f"{function}(ptr {row.pointer}, {rest}, ")

    def call_rates(
        self, state: RealArray, out: Place | None = None, kernel: KernelTable | None = None
    ) -> Int:
        """Evaluate a state, which is followed by what is written of it; returns the statuses."""
        code, called = self.code, kernel or self
        function = self._function("rates", "ptr, ptr, ptr, ptr", kernel)
        out = out or state.after(2 * self._layout.n)
        given = ", ".join(f"ptr {a.pointer}" for a in (state, called.parameters, called.timed, out))
        if code.lanes == 1:
            return Int(code, code.assign(f"call {INTEGER} {function}({given})"))
        return self._statuses(f"{function}({given}, ")

    def _function(self, name: str, arguments: str, kernel: KernelTable | None) -> str:
        if kernel is None and self._layout.linked:
            self.code.declared[name] = f"{INTEGER} @{name}({arguments})"
            return f"@{name}"
        pointer: str = getattr(kernel or self, name).pointer
        return pointer

    def _statuses(self, call: str) -> Int:
        status = self.code.alloca(1)
        self.code.emit(f"call void {call}ptr {status})")
        result: Int = IntArray(self.code, status)[0]
        return result


def combined(weights: Sequence[Any], slopes: Sequence[RealArray], i: Any) -> Real:
    """Weighted sum of an entry of some rows, without those whose weight is the number 0."""
    (weight, slope), *others = (
        pair for pair in zip(weights, slopes, strict=False) if isinstance(pair[0], Real) or pair[0]
    )
    total: Real = slope[i] * weight
    for weight, slope in others:
        total = fma(slope[i], weight, total)
    return total


KEEP, NODE, STEP_END = range(3)
"""When a row is evaluated: at the time of the row before, at its node, at the end of the step."""


def write_stages(
    tableau: Tableau, layout: RowLayout, memory: StepMemory, first: int, last: int
) -> Int:
    """Write rows of the workspace; each is evaluated as soon as its state is known.

    Rows at the end of the step are evaluated at that very time, so that the next step begins with
    the same bits. Returns the statuses. A single state returns a status other than 0 at once, with
    the number of the row in the upper half.
    """
    code, n, stepper = memory.code, layout.n, memory.stepper
    t, h, end = stepper.start, stepper.length, stepper.stop
    times, begun, status = clocks(tableau), memory.row(0), code.value(0)
    slopes = [memory.row(row, n) for row in range(last)]

    def met(before: Int, found: Int, row: int) -> Int:
        """Statuses so far; a single state ends with one at once."""
        if code.lanes > 1:
            return select(before == 0, found, before)
        with code.if_(found != 0):
            code.return_(found + (row << HALF))
        return before

    for row in range(first, last + 1):
        state, weights = memory.row(row), tableau.extended_A[row].tolist()
        for i in code.for_entries(2 * n):
            state[i] = fma(h, combined(weights, slopes, i), begun[i])
        if times[row] != KEEP:
            node = fma(h, float(tableau.extended_c[row]), t) if times[row] == NODE else end
            status = met(status, memory.call_clock(node), 0)
        status = met(status, memory.call_rates(state), row)
    if first <= tableau.stages <= last:
        fine = is_sound(layout, memory.row(tableau.stages), 3 * n)
        status = met(status, select_of(Int, fine, 0, NOT_FINITE), 0)
    return status


def is_sound(layout: RowLayout, row: RealArray, columns: int) -> Bool:
    """Whether the first columns of a row are numbers that a motion can have."""
    code = row.code
    sound = code.variable(True)
    for i in code.for_entries(columns):
        # Written so that nan, which compares false with everything, is caught.
        sound.set(sound & (abs(row[i]) < LARGEST_STATE))
    for i in layout.turning(code):
        sound.set(sound & (abs(row[i]) <= LARGEST_ANGLE))
    return code.value(sound)


def wrap(angles: RealArray, turns: IntArray, i: Any, where: Bool | None = None) -> None:
    """Bring an angle within one turn, in some lanes, and count the turns taken away."""
    angle = angles[i]
    beyond = abs(angle) > TWO_PI / 2
    if where is not None:
        beyond = where & beyond
    taken = select(beyond, rint(angle / TWO_PI), 0.0)
    within = fma(-taken, TWO_PI_TAIL, fma(-taken, TWO_PI, angle))
    angles[i] = select(beyond, within, angle)
    turns[i] += taken.to_int


def clocks(tableau: Tableau) -> NDArray[np.int64]:
    """When each row is evaluated; see `KEEP`."""
    c = tableau.extended_c
    result = np.where(c == 1.0, STEP_END, NODE)
    result[1:][c[1:] == c[:-1]] = KEEP
    # Before these rows, samples or another trial may have moved the clock.
    for row in (1, tableau.stages + 1):
        result[row : row + 1][c[row : row + 1] < 1.0] = NODE
    return result
