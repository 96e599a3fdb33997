"""What the text of a step depends on beside its tableau, and how it reaches memory."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from linkages.kernel.code.instructions import DOUBLE, INTEGER, Instructions, PrintedLoop
from linkages.solvers.events import Event
from linkages.solvers.flow import Flow
from linkages.solvers.renormalisation import Renormalisation
from linkages.solvers.steps.memory import FRAME, FUNCTION

MOST_TANGENTS = 8
"""Tangents that are made orthogonal to see how far they are apart: texts grow with their square."""

_NONE = (0, 0, 0, False)

UNROLLED = 16
"""Entries up to which a loop over them is written out."""


@dataclass(frozen=True)
class Shape:
    """What stands where in a row of the workspace; see `linkages.solvers.steps.memory.SystemView`.

    The last of the n coordinates are those of tangents: so many, of so many entries, of which so
    many are lengths themselves, orthogonal or not (see `linkages.solvers.renormalisation`).
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
