"""What the text of a step depends on beside its tableau, how it reaches memory, and its stages."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.code.instructions import DOUBLE, INTEGER, Instructions, PrintedLoop
from linkages.solvers.flow import Flow, Renormalisation
from linkages.solvers.loops.memory import (
    FRAME,
    FROM,
    FUNCTION,
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

UNROLLED = 16
"""Entries up to which a loop over them is written out."""


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

    def __init__(self, code: Instructions, shape: Shape) -> None:
        self._code, self._shape = code, shape
        self._found: dict[str, str] = {}
        for place, name in enumerate(FRAME):
            entry = code.give(f"getelementptr {INTEGER}, ptr %frame, i64 {place}")
            self._found[name] = code.give(f"load ptr, ptr {entry}")

    def __getitem__(self, name: str) -> str:
        return self._found[name]

    @property
    def kernel(self) -> Called:
        """The functions of the flow."""
        found = Called(*(self[name] for name in Called._fields))
        if not self._shape.linked:
            return found
        self._code.declared |= {
            "clock": f"{INTEGER} @clock({DOUBLE}, ptr, ptr)",
            "rates": f"{INTEGER} @rates(ptr, ptr, ptr, ptr)",
        }
        return found._replace(clock="@clock", rates="@rates")

    def event(self, event: int) -> Called:
        """The functions of an event."""
        found = []
        for place in range(FUNCTION * event, FUNCTION * (event + 1)):
            entry = self._code.give(
                f"getelementptr {INTEGER}, ptr {self['functions']}, i64 {place}"
            )
            found.append(self._code.give(f"load ptr, ptr {entry}"))
        return Called(*found)

    def row(self, row: int, place: int = 0) -> str:
        """Address of an entry of a row of the workspace."""
        return self._code.address(self["rows"], row * self._shape.width + place)

    def pace(self, entry: int) -> str:
        """An entry of the pace, a number."""
        return self._code.load(self["pace"], entry)

    def set_pace(self, value: str, entry: int) -> None:
        """Set such an entry."""
        self._code.store(value, self["pace"], entry)


def whole_row(code: Instructions, array: str, entry: int | str) -> str:
    """An entry of an array of integers."""
    return code.give(f"load {code.integer}, ptr {code.address(array, entry)}, align 8")


def set_whole(code: Instructions, value: str, array: str, entry: int | str) -> None:
    """Set an entry of an array of integers."""
    code.say(f"store {code.integer} {value}, ptr {code.address(array, entry)}, align 8")


def fold(
    code: Instructions,
    count: int,
    starts: Sequence[str],
    body: Callable[[int | str, list[str]], Sequence[str]],
) -> list[str]:
    """Numbers that are changed for one entry after the other: written out, or in a loop."""
    values = list(starts)
    if count <= UNROLLED:
        for entry in range(count):
            values = list(body(entry, values))
        return values
    loop = PrintedLoop(code, [("i64", "0"), *((code.number, start) for start in starts)])
    place, *before = loop.values
    found = list(body(place, before))
    following = code.give(f"add i64 {place}, 1")
    loop.repeat(code.give(f"icmp ult i64 {following}, {count}"), [following, *found])
    return found


def larger(code: Instructions, one: str, other: str) -> str:
    """The larger of two numbers; the first if one of them is nan."""
    return code.select(code.compare("ogt", other, one), other, one)


def smaller(code: Instructions, one: str, other: str) -> str:
    """The smaller of two numbers; the first if one of them is nan."""
    return code.select(code.compare("olt", other, one), other, one)


class Called(NamedTuple):
    """Addresses of two functions, and of what both of them read and the second one, too."""

    clock: str
    rates: str
    parameters: str
    timed: str


def call_clock(code: Instructions, memory: StepMemory, time: str) -> str:
    """Evaluate what depends on time alone; returns the statuses."""
    return call_at_time(code, memory.kernel, time)


def call_at_time(code: Instructions, functions: Called, time: str) -> str:
    """Evaluate of some functions what depends on time alone; returns the statuses."""
    rest = f"ptr {functions.parameters}, ptr {functions.timed}"
    if code.lanes == 1:
        return code.give(f"call {INTEGER} {functions.clock}({DOUBLE} {time}, {rest})")
    row = code.reserve(1)
    code.store(time, row, 0)
    return _statuses(code, f"{functions.clock}(ptr {row}, {rest}, ")


def call_rates(code: Instructions, memory: StepMemory, row: int, n: int) -> str:
    """Evaluate the kernel at the state in a row; returns the statuses."""
    return call_at(code, memory.kernel, memory.row(row), memory.row(row, 2 * n))


def call_at(code: Instructions, functions: Called, state: str, out: str) -> str:
    """Evaluate functions of a state; returns the statuses."""
    arguments = [state, functions.parameters, functions.timed, out]
    called = f"{functions.rates}({', '.join(f'ptr {a}' for a in arguments)}"
    if code.lanes == 1:
        return code.give(f"call {INTEGER} {called})")
    return _statuses(code, f"{called}, ")


def _statuses(code: Instructions, called: str) -> str:
    status = code.reserve(1)
    code.say(f"call void {called}ptr {status})")
    return code.give(f"load {code.integer}, ptr {status}, align 8")


KEEP, NODE, STEP_END = range(3)
"""When a row is evaluated: at the time of the row before, at its node, at the end of the step."""


class Stages:
    """Writes rows of the workspace; each is evaluated as soon as its state is known.

    The step goes from row 0, evaluated, over a time in the pace. Rows at its end are evaluated at
    that very time, so that the end of a step and the start of the next one are at the same time
    to the last bit.

    Parameters
    ----------
    code
        Where.
    tableau, shape, memory
        Of the step.
    """

    def __init__(
        self, code: Instructions, tableau: Tableau, shape: Shape, memory: StepMemory
    ) -> None:
        self._code, self._shape, self._memory = code, shape, memory
        self._weights, self._nodes = tableau.extended_A, tableau.extended_c
        self._clocks = clocks(tableau)
        self._end = tableau.stages

    def write(self, first: int, last: int) -> str:
        """Write rows first to last; returns statuses, of a single state 0: others are returned.

        What is returned with a status is the row in the upper half of the number.
        """
        code, memory = self._code, self._memory
        t, h, end = (memory.pace(entry) for entry in (FROM, LENGTH, TO))
        status = code.whole(0)
        for row in range(first, last + 1):
            self._combine(row, h)
            if self._clocks[row] == NODE:
                node = code.constant(self._nodes[row])
                status = self._met(status, call_clock(code, memory, code.fused(node, h, t)), 0)
            elif self._clocks[row] == STEP_END:
                status = self._met(status, call_clock(code, memory, end), 0)
            found = call_rates(code, memory, row, self._shape.n)
            status = self._met(status, found, row)
        if first <= self._end <= last:
            status = self._sound(status)
        return status

    def _combine(self, row: int, h: str) -> None:
        """The state in a row, from the derivatives in those before it."""
        code, memory, n = self._code, self._memory, self._shape.n
        terms = [
            (code.constant(weight), memory.row(stage, n))
            for stage, weight in enumerate(self._weights[row].tolist())
            if weight
        ]
        begun, target = memory.row(0), memory.row(row)

        def entry(i: int | str, _: list[str]) -> list[str]:
            (weight, slopes), *rest = terms
            slope = code.multiply(weight, code.load(slopes, i))
            for weight, slopes in rest:
                slope = code.fused(weight, code.load(slopes, i), slope)
            code.store(code.fused(h, slope, code.load(begun, i)), target, i)
            return []

        fold(code, 2 * n, (), entry)

    def _met(self, before: str, found: str, row: int) -> str:
        """Statuses so far; a single state ends with one at once."""
        code = self._code
        if code.lanes > 1:
            fine = code.give(f"icmp eq {code.integer} {before}, {code.whole(0)}")
            return code.select(fine, found, before, code.integer)
        leave, on = code.new_label("leave"), code.new_label("on")
        code.branch(code.give(f"icmp eq i64 {found}, 0"), on, leave)
        code.begin(leave)
        code.say(f"ret i64 {code.give(f'or i64 {found}, {row << 32}')}")
        code.begin(on)
        return before

    def _sound(self, status: str) -> str:
        """Statuses with that of ends which are not numbers that a motion can have."""
        code, shape = self._code, self._shape
        fine = is_sound(code, shape, self._memory.row(self._end), 3 * shape.n)
        found = code.select(fine, code.whole(0), code.whole(NOT_FINITE), code.integer)
        return self._met(status, found, 0)


def is_sound(code: Instructions, shape: Shape, row: str, columns: int) -> str:
    """Whether the first columns of a row are numbers that a motion can have."""
    one = code.constant(1.0)

    def entry(i: int | str, values: list[str]) -> list[str]:
        # Written so that nan, which compares false with everything, is caught.
        fine = code.compare("olt", code.absolute(code.load(row, i)), code.constant(LARGEST_STATE))
        return [code.select(fine, values[0], code.constant(0.0))]

    (sound,) = fold(code, columns, [one], entry)
    fine = code.compare("oeq", sound, one)
    for i in range(shape.n):
        if shape.rotates[i]:
            near = code.compare(
                "ole", code.absolute(code.load(row, i)), code.constant(LARGEST_ANGLE)
            )
            fine = code.all_of([fine, near])
    return fine


def wrap(code: Instructions, angles: str, i: int, turns: str, where: str | None = None) -> None:
    """Bring an angle within one turn, in some lanes; see `turns.wrap_angles`."""
    angle = code.load(angles, i)
    beyond = code.compare("ogt", code.absolute(angle), code.constant(TWO_PI / 2))
    if where is not None:
        beyond = code.all_of([where, beyond])
    taken = code.call("llvm.rint", code.divide(angle, code.constant(TWO_PI)))
    taken = code.select(beyond, taken, code.constant(0.0))
    back = code.negate(taken)
    within = code.fused(back, code.constant(TWO_PI), angle)
    within = code.fused(back, code.constant(TWO_PI_TAIL), within)
    code.store(code.select(beyond, within, angle), angles, i)
    whole = code.give(f"fptosi {code.number} {taken} to {code.integer}")
    set_whole(code, code.on_integers("add", whole_row(code, turns, i), whole), turns, i)


def clocks(tableau: Tableau) -> NDArray[np.int64]:
    """When each row is evaluated; see `KEEP`."""
    c = tableau.extended_c
    found = np.where(c == 1.0, STEP_END, NODE)
    found[1:][c[1:] == c[:-1]] = KEEP
    # Before these rows, samples or another trial may have moved the clock.
    for row in (1, tableau.stages + 1):
        found[row : row + 1][c[row : row + 1] < 1.0] = NODE
    return found
