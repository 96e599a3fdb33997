"""What the text of a step depends on beside its tableau, how it reaches memory, and its stages."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.code.instructions import DOUBLE, INTEGER
from linkages.kernel.code.operands import (
    Real,
    Reals,
    Truth,
    Whole,
    Wholes,
    choose,
    choose_of,
    fused,
    rounded,
)
from linkages.kernel.code.procedure import Procedure
from linkages.solvers.flow import Flow, Renormalisation
from linkages.solvers.loops.memory import (
    FRAME,
    FROM,
    FUNCTION,
    HALF,
    LARGEST_ANGLE,
    LARGEST_STATE,
    LENGTH,
    NOT_FINITE,
    TO,
    TWO_PI,
    TWO_PI_TAIL,
)
from linkages.solvers.tableau import Tableau
from linkages.solvers.trajectory import Event

MOST_TANGENTS = 8
"""Tangents that are made orthogonal to see how far they are apart: texts grow with their square."""

_NONE = (0, 0, 0, False)


@dataclass(frozen=True)
class Shape:
    """What stands where in a row of the workspace; see `linkages.solvers.loops.memory.SystemView`.

    The last of the n coordinates are those of tangents: so many, of so many entries, of which so
    many are lengths themselves, orthogonal or not (see `linkages.solvers.flow`).
    `active` is that of `linkages.solvers.flow.Switching`, with an entry for each mode; `events` is
    their number. `linked` says whether the functions of the flow are called by their names, for
    they become part of the same module, or by the addresses in the frame.
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
    ) -> Shape:
        """That of a flow, of tangents and of events that are watched."""
        return cls(
            tangents=_sizes(tangents) if tangents is not None and is_printed(tangents) else _NONE,
            events=len(events) if are_printed(events) else 0,
            n=flow.coordinates,
            blocks=len(flow.margin_scale),
            first_carried=flow.first_carried,
            carried=flow.carried,
            counted=flow.counted,
            width=2 * flow.coordinates + flow.written,
            rotates=tuple(flow.rotates.tolist()),
            active=() if flow.switching is None else flow.switching.active,
        )

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


def _sizes(tangents: Renormalisation) -> tuple[int, int, int, bool]:
    return tangents.columns, tangents.size, tangents.placed, tangents.orthogonal


def is_printed(tangents: Renormalisation) -> bool:
    """Whether printed code sees where tangents are to be renormalised."""
    return tangents.columns <= MOST_TANGENTS or not tangents.orthogonal


def are_printed(events: Sequence[Event]) -> bool:
    """Whether printed code sees where events may happen."""
    return all(event.function is not None for event in events)


class StepMemory:
    """The arrays of a frame, by name.

    Parameters
    ----------
    code
        A function whose argument ``%frame`` is the address of their addresses.
    shape
        Of rows of the workspace.
    """

    def __init__(self, code: Procedure, shape: Shape) -> None:
        self.code, self._shape = code, shape
        self._pointers: dict[str, str] = {}
        for place, name in enumerate(FRAME):
            entry = code.give(f"getelementptr {INTEGER}, ptr %frame, i64 {place}")
            self._pointers[name] = code.give(f"load ptr, ptr {entry}")

    def __getitem__(self, name: str) -> Reals:
        return Reals(self.code, self._pointers[name])

    def integers(self, name: str) -> Wholes:
        """An array of integers, or the entries of the pace that are integers."""
        return Wholes(self.code, self._pointers[name])

    def row(self, row: int, place: int = 0) -> Reals:
        """A row of the workspace, from one of its entries on."""
        return self["rows"].after(row * self._shape.width + place)

    @property
    def kernel(self) -> Called:
        """The functions of the flow."""
        found = Called(*(self._pointers[name] for name in Called._fields))
        if not self._shape.linked:
            return found
        self.code.declared |= {
            "clock": f"{INTEGER} @clock({DOUBLE}, ptr, ptr)",
            "rates": f"{INTEGER} @rates(ptr, ptr, ptr, ptr)",
        }
        return found._replace(clock="@clock", rates="@rates")

    def event(self, event: int) -> Called:
        """The functions of an event."""
        found = []
        for place in range(FUNCTION * event, FUNCTION * (event + 1)):
            entry = self.code.give(
                f"getelementptr {INTEGER}, ptr {self._pointers['functions']}, i64 {place}"
            )
            found.append(self.code.give(f"load ptr, ptr {entry}"))
        return Called(*found)

    def call_clock(self, time: Real, functions: Called | None = None) -> Whole:
        """Evaluate what depends on time alone; returns the statuses of the flow, or of others."""
        code, called = self.code, functions or self.kernel
        rest = f"ptr {called.parameters}, ptr {called.timed}"
        if code.lanes == 1:
            found = code.give(f"call {INTEGER} {called.clock}({DOUBLE} {time.text}, {rest})")
            return Whole(code, found)
        row = Reals(code, code.reserve(1))
        row[0] = time
        return self._statuses(f"{called.clock}(ptr {row.pointer}, {rest}, ")

    def call_rates(
        self, state: Reals, out: Reals | None = None, functions: Called | None = None
    ) -> Whole:
        """Evaluate a state, which is followed by what is written of it; returns the statuses."""
        code, called = self.code, functions or self.kernel
        out = out or state.after(2 * self._shape.n)
        given = [state.pointer, called.parameters, called.timed, out.pointer]
        call = f"{called.rates}({', '.join(f'ptr {pointer}' for pointer in given)}"
        if code.lanes == 1:
            return Whole(code, code.give(f"call {INTEGER} {call})"))
        return self._statuses(f"{call}, ")

    def _statuses(self, call: str) -> Whole:
        status = self.code.reserve(1)
        self.code.say(f"call void {call}ptr {status})")
        found: Whole = Wholes(self.code, status)[0]
        return found


class Called(NamedTuple):
    """Addresses of two functions, and of what both of them read and the second one, too."""

    clock: str
    rates: str
    parameters: str
    timed: str


def combined(weights: Sequence[Any], slopes: Sequence[Reals], i: Any) -> Real:
    """Weighted sum of an entry of some rows, without those whose weight is the number 0."""
    (weight, slope), *others = (
        pair for pair in zip(weights, slopes, strict=False) if isinstance(pair[0], Real) or pair[0]
    )
    total: Real = slope[i] * weight
    for weight, slope in others:
        total = fused(slope[i], weight, total)
    return total


KEEP, NODE, STEP_END = range(3)
"""When a row is evaluated: at the time of the row before, at its node, at the end of the step."""


def write_stages(
    tableau: Tableau, shape: Shape, memory: StepMemory, first: int, last: int
) -> Whole:
    """Write rows of the workspace; each is evaluated as soon as its state is known.

    The step goes from row 0, evaluated, over a time in the pace. Rows at its end are evaluated at
    that very time, so that the end of a step and the start of the next one are at the same time
    to the last bit. Returns the statuses, of a single state 0: others are returned at once, with
    the row in the upper half of the number.
    """
    code, n, pace = memory.code, shape.n, memory["pace"]
    t, h, end = (pace[entry] for entry in (FROM, LENGTH, TO))
    times, begun, status = clocks(tableau), memory.row(0), code.value(0)
    slopes = [memory.row(row, n) for row in range(last)]

    def met(before: Whole, found: Whole, row: int) -> Whole:
        """Statuses so far; a single state ends with one at once."""
        if code.lanes > 1:
            return choose(before == 0, found, before)
        with code.when(found != 0):
            code.leave(found + (row << HALF))
        return before

    for row in range(first, last + 1):
        state, weights = memory.row(row), tableau.extended_A[row].tolist()
        for i in code.entries(2 * n):
            state[i] = fused(h, combined(weights, slopes, i), begun[i])
        if times[row] != KEEP:
            node = fused(h, float(tableau.extended_c[row]), t) if times[row] == NODE else end
            status = met(status, memory.call_clock(node), 0)
        status = met(status, memory.call_rates(state), row)
    if first <= tableau.stages <= last:
        fine = is_sound(shape, memory.row(tableau.stages), 3 * n)
        status = met(status, choose_of(Whole, fine, 0, NOT_FINITE), 0)
    return status


def is_sound(shape: Shape, row: Reals, columns: int) -> Truth:
    """Whether the first columns of a row are numbers that a motion can have."""
    code = row.code
    sound = code.variable(True)
    for i in code.entries(columns):
        # Written so that nan, which compares false with everything, is caught.
        sound.set(sound & (abs(row[i]) < LARGEST_STATE))
    for i in range(shape.n):
        if shape.rotates[i]:
            sound.set(sound & (abs(row[i]) <= LARGEST_ANGLE))
    return code.value(sound)


def wrap(angles: Reals, turns: Wholes, i: int, where: Truth | None = None) -> None:
    """Bring an angle within one turn, in some lanes, and count the turns taken away."""
    angle = angles[i]
    beyond = abs(angle) > TWO_PI / 2
    if where is not None:
        beyond = where & beyond
    taken = choose(beyond, rounded(angle / TWO_PI), 0.0)
    within = fused(-taken, TWO_PI_TAIL, fused(-taken, TWO_PI, angle))
    angles[i] = choose(beyond, within, angle)
    turns[i] += taken.whole


def clocks(tableau: Tableau) -> NDArray[np.int64]:
    """When each row is evaluated; see `KEEP`."""
    c = tableau.extended_c
    found = np.where(c == 1.0, STEP_END, NODE)
    found[1:][c[1:] == c[:-1]] = KEEP
    # Before these rows, samples or another trial may have moved the clock.
    for row in (1, tableau.stages + 1):
        found[row : row + 1][c[row : row + 1] < 1.0] = NODE
    return found
