"""Instructions of LLVM's assembly language, one after the other.

Numbers are operands: names of values, or constants. All operations are those of IEEE 754 with one
rounding each and no flags, so that nothing may be reordered or contracted.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence

DOUBLE = "double"


def constant(value: float) -> str:
    """A number as an operand, to the last bit."""
    (bits,) = struct.unpack(">Q", struct.pack(">d", value))
    return f"0x{bits:016X}"


class Instructions:
    """The body of a function, written line by line.

    Attributes
    ----------
    block
        Name of the block that is being written.
    declared
        Signature of each function of the outside that is called.
    """

    def __init__(self) -> None:
        self._lines: list[str] = ["entry:"]
        self._count = 0
        self.block = "entry"
        self.declared: dict[str, str] = {}

    @property
    def text(self) -> str:
        """All lines."""
        return "\n".join(self._lines) + "\n"

    def say(self, line: str) -> None:
        """Write an instruction without a result."""
        self._lines.append(f"  {line}")

    def give(self, instruction: str) -> str:
        """Write an instruction; returns the name of its result."""
        name = self.name()
        self.say(f"{name} = {instruction}")
        return name

    def name(self) -> str:
        """A name for a value that is given later."""
        self._count += 1
        return f"%v{self._count - 1}"

    def later(self) -> Callable[[str], None]:
        """Leave a line open; what is returned writes it."""
        place = len(self._lines)
        self._lines.append("")

        def fill(instruction: str) -> None:
            self._lines[place] = f"  {instruction}"

        return fill

    def new_label(self, name: str) -> str:
        """A name for a block that no other has."""
        self._count += 1
        return f"{name}{self._count}"

    def begin(self, label: str) -> None:
        """Go on with a block."""
        self._lines.append(f"{label}:")
        self.block = label

    def branch(self, condition: str, yes: str, no: str) -> None:
        """Go on in one of two blocks."""
        self.say(f"br i1 {condition}, label %{yes}, label %{no}")

    def leave_unless(self, condition: str, status: int) -> None:
        """Return a status where a condition does not hold."""
        leave, go_on = self.new_label("leave"), self.new_label("on")
        self.branch(condition, go_on, leave)
        self.begin(leave)
        self.say(f"ret i64 {status}")
        self.begin(go_on)

    def binary(self, operation: str, a: str, b: str) -> str:
        """``fadd``, ``fsub``, ``fmul``, ``fdiv`` or ``frem``."""
        return self.give(f"{operation} {DOUBLE} {a}, {b}")

    def add(self, a: str, b: str) -> str:
        """The sum."""
        return self.binary("fadd", a, b)

    def subtract(self, a: str, b: str) -> str:
        """The difference."""
        return self.binary("fsub", a, b)

    def multiply(self, a: str, b: str) -> str:
        """The product."""
        return self.binary("fmul", a, b)

    def divide(self, a: str, b: str) -> str:
        """The quotient."""
        return self.binary("fdiv", a, b)

    def negate(self, a: str) -> str:
        """The opposite."""
        return self.give(f"fneg {DOUBLE} {a}")

    def fused(self, a: str, b: str, c: str) -> str:
        """The value a·b + c with one rounding."""
        return self.call("llvm.fma.f64", a, b, c)

    def absolute(self, a: str) -> str:
        """The absolute value."""
        return self.call("llvm.fabs.f64", a)

    def compare(self, relation: str, a: str, b: str) -> str:
        """A relation such as ``oge``, false if a number is nan."""
        return self.give(f"fcmp {relation} {DOUBLE} {a}, {b}")

    def select(self, condition: str, a: str, b: str, kind: str = DOUBLE) -> str:
        """One of two values."""
        return self.give(f"select i1 {condition}, {kind} {a}, {kind} {b}")

    def all_of(self, conditions: Sequence[str]) -> str:
        """Whether all conditions hold."""
        result = conditions[0]
        for condition in conditions[1:]:
            result = self.give(f"and i1 {result}, {condition}")
        return result

    def call(self, name: str, *operands: str) -> str:
        """The result of a function of numbers."""
        self.declared[name] = f"{DOUBLE} @{name}({', '.join([DOUBLE] * len(operands))})"
        given = ", ".join(f"{DOUBLE} {operand}" for operand in operands)
        return self.give(f"call {DOUBLE} @{name}({given})")

    def address(self, array: str, offset: int | str) -> str:
        """Address of an entry of an array."""
        if offset == 0:
            return array
        return self.give(f"getelementptr {DOUBLE}, ptr {array}, i64 {offset}")

    def load(self, array: str, offset: int | str) -> str:
        """An entry of an array."""
        return self.give(f"load {DOUBLE}, ptr {self.address(array, offset)}")

    def store(self, value: str, array: str, offset: int | str) -> None:
        """Set an entry of an array."""
        self.say(f"store {DOUBLE} {value}, ptr {self.address(array, offset)}")
