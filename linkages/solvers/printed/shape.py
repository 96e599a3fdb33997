"""What the text of a step depends on beside its tableau, and how it reaches memory."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from linkages.kernel.code.instructions import DOUBLE, INTEGER, Instructions, PrintedLoop
from linkages.solvers.flow import Flow
from linkages.solvers.renormalisation import Renormalisation
from linkages.solvers.steps.views import FRAME

UNROLLED = 16
"""Entries up to which a loop over them is written out."""


@dataclass(frozen=True)
class Shape:
    """What stands where in a row of the workspace; see `linkages.solvers.steps.views.SystemView`.

    The last of the n coordinates are those of tangents: so many, of so many entries, of which so
    many are lengths themselves (see `linkages.solvers.renormalisation`).
    """

    n: int
    blocks: int
    first_carried: int
    carried: int
    counted: int
    width: int
    rotates: tuple[bool, ...]
    tangents: tuple[int, int, int] = (0, 0, 0)

    @classmethod
    def of(cls, flow: Flow, tangents: Renormalisation | None = None) -> Shape:
        """That of a flow, and of tangents that are looked at one by one."""
        alone = tangents is not None and (tangents.columns == 1 or not tangents.orthogonal)
        return cls(
            tangents=_sizes(tangents) if tangents is not None and alone else (0, 0, 0),
            n=flow.coordinates,
            blocks=len(flow.margin_scale),
            first_carried=flow.first_carried,
            carried=flow.carried,
            counted=flow.counted,
            width=2 * flow.coordinates + flow.written,
            rotates=tuple(bool(rotates) for rotates in flow.rotates),
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
    def cosines(self) -> int:
        """Place of the cosines of dependent angles; sines and speeds follow."""
        return self.settled + 2 * self.carried


def _sizes(tangents: Renormalisation) -> tuple[int, int, int]:
    return tangents.columns, tangents.size, tangents.placed


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
    """Numbers that are changed for one entry after the other: written out, or in a loop.

    Parameters
    ----------
    code
        Where.
    count
        Number of entries.
    starts
        The numbers at first.
    body
        Number of an entry, and the numbers before it → those behind it.
    """
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


def call_clock(code: Instructions, memory: StepMemory, time: str) -> str:
    """Evaluate what depends on time alone; returns the statuses."""
    rest = f"ptr {memory['parameters']}, ptr {memory['timed']}"
    if code.lanes == 1:
        return code.give(f"call {INTEGER} {memory['clock']}({DOUBLE} {time}, {rest})")
    row = code.reserve(1)
    code.store(time, row, 0)
    return _statuses(code, f"{memory['clock']}(ptr {row}, {rest}, ")


def call_rates(code: Instructions, memory: StepMemory, row: int, n: int) -> str:
    """Evaluate the kernel at the state in a row; returns the statuses."""
    arguments = [memory.row(row), memory["parameters"], memory["timed"], memory.row(row, 2 * n)]
    called = f"{memory['rates']}({', '.join(f'ptr {a}' for a in arguments)}"
    if code.lanes == 1:
        return code.give(f"call {INTEGER} {called})")
    return _statuses(code, f"{called}, ")


def _statuses(code: Instructions, called: str) -> str:
    status = code.reserve(1)
    code.say(f"call void {called}ptr {status})")
    return code.give(f"load {code.integer}, ptr {status}, align 8")
