"""Instructions of LLVM's assembly language, for one state or several lanes.

Operations are those of IEEE 754 with one rounding each and no flags, so that nothing may be
reordered or contracted.

With W lanes an operand is a vector of W numbers, and entry r of lane l of an array stands at place
W·r + l. Each lane gets the bits that it would get alone.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping, Sequence


class Lines:
    """The body of a function, written line by line."""

    def __init__(self) -> None:
        self._reserved: list[str] = []
        self._lines: list[str] = []
        self._count = 0
        self.block = "entry"
        self.declared: dict[str, str] = {}

    @property
    def text(self) -> str:
        """All lines."""
        lines = (line for line in self._lines if line)  # without room that was not needed
        return "\n".join(["entry:", *self._reserved, *lines]) + "\n"

    @property
    def length(self) -> int:
        """Number of lines so far."""
        return len(self._lines)

    def emit(self, line: str) -> None:
        """Write an instruction without a result."""
        self._lines.append(f"  {line}")

    def assign(self, instruction: str) -> str:
        """Write an instruction; returns the name of its result."""
        name = self.name()
        self._lines.append(f"  {name} = {instruction}")
        return name

    def name(self) -> str:
        """A name for a value that is given later."""
        self._count += 1
        return f"%v{self._count - 1}"

    def placeholder(self) -> Callable[[str], None]:
        """Leave a line open; what is returned writes it."""
        place = len(self._lines)
        self._lines.append("")

        def fill(instruction: str) -> None:
            self._lines[place] = f"  {instruction}"

        return fill

    def assign_at_entry(self, instruction: str) -> str:
        """Write an instruction at the beginning of the function; returns the name of its result."""
        name = self.name()
        self._reserved.append(f"  {name} = {instruction}")
        return name

    def new_label(self, name: str) -> str:
        """A name for a block that no other has."""
        self._count += 1
        return f"{name}{self._count}"

    def begin_block(self, label: str) -> None:
        """Go on with a block."""
        self._lines.append(f"{label}:")
        self.block = label

    def branch(self, condition: str, yes: str, no: str) -> None:
        """Go on in one of two blocks, by a condition."""
        self.emit(f"br i1 {condition}, label %{yes}, label %{no}")


DOUBLE = "double"
INTEGER = "i64"
TRUTH = "i1"
ALIGNMENT = 64
"""Of arrays, in bytes: a line of the cache. Others work as well, and take longer."""


class Instructions(Lines):
    """The body of a function: arithmetic, conditions and memory.

    `strides` says how many numbers apart the entries of an argument are: W, if not given. With one
    lane it may be a column of an array of several.
    """

    def __init__(self, lanes: int = 1, strides: Mapping[str, int] | None = None) -> None:
        super().__init__()
        self.lanes = lanes
        self._strides = {f"%{name}": stride for name, stride in (strides or {}).items()}
        self.number, self.integer, self.truth = map(self.vector_type, (DOUBLE, INTEGER, TRUTH))
        self._sound, self._status = "", self.int_constant(0)

    def vector_type(self, kind: str) -> str:
        """Type of a value for each lane."""
        return kind if self.lanes == 1 else f"<{self.lanes} x {kind}>"

    def constant(self, value: float) -> str:
        """A number as an operand, to the last bit."""
        (bits,) = struct.unpack(">Q", struct.pack(">d", value))
        return self.splat(DOUBLE, f"0x{bits:016X}")

    def int_constant(self, value: int) -> str:
        """An integer as an operand."""
        return self.splat(INTEGER, str(value))

    def splat(self, kind: str, value: str) -> str:
        """A constant that is the same in all lanes."""
        return value if self.lanes == 1 else f"splat ({kind} {value})"

    @property
    def sound(self) -> str:
        """In which of several lanes no condition has been missed yet."""
        return self._sound or self.splat(TRUTH, "true")

    def resume(self) -> None:
        """Go on with the lanes whose status, as the function before left it, is 0."""
        if self.lanes > 1:
            self._status = self.assign(f"load {self.integer}, ptr %status, align 8")
            sound = f"icmp eq {self.integer} {self._status}, {self.int_constant(0)}"
            self._sound = self.assign(sound)

    def require(self, condition: str, status: int | str) -> None:
        """Return a status where a condition does not hold.

        Several lanes go on, and the status of each is the first that it missed. With one lane the
        status may be the name of an integer.
        """
        if self.lanes == 1:
            leave, go_on = self.new_label("leave"), self.new_label("on")
            self.branch(condition, go_on, leave)
            self.begin_block(leave)
            self.emit(f"ret i64 {status}")
            self.begin_block(go_on)
            return
        still = self.assign(f"and {self.truth} {self.sound}, {condition}")
        fails = self.assign(f"xor {self.truth} {self.sound}, {still}")
        self._status = self.select(
            fails, self.int_constant(int(status)), self._status, self.integer
        )
        self._sound = still

    def end(self) -> None:
        """Return: 0, or write the status of each lane to its row."""
        if self.lanes == 1:
            self.emit("ret i64 0")
            return
        self.emit(f"store {self.integer} {self._status}, ptr %status, align 8")
        self.emit("ret void")

    def broadcast_int(self, integer: str) -> str:
        """An integer that is the same in all lanes."""
        return self.per_lane(lambda _: integer, [], result=INTEGER)

    def int_operation(self, operation: str, a: str, b: str) -> str:
        """An operation on integers, such as ``add`` or ``shl``."""
        return self.assign(f"{operation} {self.integer} {a}, {b}")

    def select(self, condition: str, a: str, b: str, kind: str = "") -> str:
        """One of two values."""
        kind = kind or self.number
        return self.assign(f"select {self.truth} {condition}, {kind} {a}, {kind} {b}")

    def any_lane(self, condition: str) -> str:
        """Whether a condition holds in any lane, to branch by."""
        if self.lanes == 1:
            return condition
        name = f"llvm.vector.reduce.or.v{self.lanes}i1"
        self.declared[name] = f"i1 @{name}({self.truth})"
        return self.assign(f"call i1 @{name}({self.truth} {condition})")

    def call_intrinsic(self, name: str, *operands: str) -> str:
        """The result of an intrinsic function of numbers; its name without their type."""
        suffix = "f64" if self.lanes == 1 else f"v{self.lanes}f64"
        name = f"{name}.{suffix}"
        self.declared[name] = f"{self.number} @{name}({', '.join([self.number] * len(operands))})"
        given = ", ".join(f"{self.number} {operand}" for operand in operands)
        return self.assign(f"call {self.number} @{name}({given})")

    def call_library(self, name: str, *operands: str) -> str:
        """The result of a function of the C library, which takes one lane at a time."""
        self.declared[name] = f"{DOUBLE} @{name}({', '.join([DOUBLE] * len(operands))})"

        def one(_: int, *each: str) -> str:
            given = ", ".join(f"{DOUBLE} {operand}" for operand in each)
            return self.assign(f"call {DOUBLE} @{name}({given})")

        return self.per_lane(one, operands)

    def per_lane(
        self,
        function: Callable[..., str],
        operands: Sequence[str],
        given: str = DOUBLE,
        result: str = DOUBLE,
    ) -> str:
        """What a function of one lane gives for each."""
        if self.lanes == 1:
            return function(0, *operands)
        every = "poison"
        taken, put = self.vector_type(given), self.vector_type(result)
        for lane in range(self.lanes):
            each = [self.assign(f"extractelement {taken} {o}, i32 {lane}") for o in operands]
            one = f"{result} {function(lane, *each)}"
            every = self.assign(f"insertelement {put} {every}, {one}, i32 {lane}")
        return every

    def alloca(self, entries: int) -> str:
        """Address of an array of the function's own; what stands in it at first is unknown."""
        return self.assign_at_entry(
            f"alloca {DOUBLE}, i64 {entries * self.lanes}, align {ALIGNMENT}"
        )

    def address(self, array: str, offset: int | str) -> str:
        """Address of an entry of an array."""
        if offset == 0:
            return array
        stride = self._strides.get(array, self.lanes)
        row = DOUBLE
        if isinstance(offset, int):
            offset *= stride
        elif stride > 1:
            row = f"[{stride} x {DOUBLE}]"
        place = self.assign(f"getelementptr {row}, ptr {array}, i64 {offset}")
        self._strides[place] = stride
        return place

    def column(self, array: str, number: str, entries: int, width: int) -> str:
        """Address of a column of an array in blocks of `width` columns, with so many rows each."""
        block = self.assign(f"udiv {INTEGER} {number}, {width}")
        place = self.assign(f"urem {INTEGER} {number}, {width}")
        before = self.assign(f"mul {INTEGER} {block}, {width * entries}")
        place = self.assign(f"add {INTEGER} {before}, {place}")
        result = self.assign(f"getelementptr {DOUBLE}, ptr {array}, {INTEGER} {place}")
        self._strides[result] = width
        return result

    def load(self, array: str, offset: int | str) -> str:
        """An entry of an array."""
        place = self.address(array, offset)
        return self.assign(f"load {self.number}, ptr {place}{self._alignment}")

    def store(self, value: str, array: str, offset: int | str) -> None:
        """Set an entry of an array."""
        place = self.address(array, offset)
        self.emit(f"store {self.number} {value}, ptr {place}{self._alignment}")

    def room_for_stores(self) -> Callable[[str, str, int], None]:
        """Leave room here; what is returned sets an entry of an array, as `store` does."""
        fill, lines = self.placeholder(), list[str]()

        def store(value: str, array: str, offset: int) -> None:
            place, stride = self.name(), self._strides.get(array, self.lanes)
            lines.append(f"{place} = getelementptr {DOUBLE}, ptr {array}, i64 {offset * stride}")
            lines.append(f"store {self.number} {value}, ptr {place}{self._alignment}")
            fill("\n  ".join(lines))

        return store

    @property
    def _alignment(self) -> str:
        """Rows of lanes need not stand at multiples of their length."""
        return "" if self.lanes == 1 else ", align 8"

    def gather(self, array: str, offsets: str) -> str:
        """Entries of an array, for each lane another one of its own."""
        if self.lanes == 1:
            return self.load(array, offsets)
        row = f"[{self.lanes} x {DOUBLE}]"

        def one(lane: int, offset: str) -> str:
            place = self.assign(f"getelementptr {row}, ptr {array}, i64 {offset}, i64 {lane}")
            return self.assign(f"load {DOUBLE}, ptr {place}")

        return self.per_lane(one, [offsets], INTEGER)


class PhiLoop:
    """Repeats what is written before `repeat` as long as a condition holds, and changes values."""

    def __init__(self, code: Instructions, starts: Sequence[tuple[str, str]]) -> None:
        self._code, self._starts = code, starts
        self._before, self._label = code.block, code.new_label("again")
        code.emit(f"br label %{self._label}")
        code.begin_block(self._label)
        self.values = [code.name() for _ in starts]
        self._heads = [code.placeholder() for _ in starts]

    def repeat(self, condition: str, ends: Sequence[str]) -> None:
        """Begin again if a condition holds that is one for all lanes, with other values."""
        code, done = self._code, self._code.new_label("done")
        code.branch(condition, self._label, done)
        for head, name, (kind, start), end in zip(
            self._heads, self.values, self._starts, ends, strict=True
        ):
            head(f"{name} = phi {kind} [ {start}, %{self._before} ], [ {end}, %{code.block} ]")
        code.begin_block(done)
