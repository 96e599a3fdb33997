"""The lines of a function in LLVM's assembly language, in their order."""

from __future__ import annotations

from collections.abc import Callable


class Lines:
    """The body of a function, written line by line.

    Attributes
    ----------
    block
        Name of the block that is being written.
    declared
        Signature of each function of the outside that is called.
    """

    def __init__(self) -> None:
        self._reserved: list[str] = []
        self._lines: list[str] = []
        self._count = 0
        self.block = "entry"
        self.declared: dict[str, str] = {}

    @property
    def text(self) -> str:
        """All lines."""
        return "\n".join(["entry:", *self._reserved, *self._lines]) + "\n"

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

    def first(self, instruction: str) -> str:
        """Write an instruction at the beginning of the function; returns the name of its result."""
        name = self.name()
        self._reserved.append(f"  {name} = {instruction}")
        return name

    def new_label(self, name: str) -> str:
        """A name for a block that no other has."""
        self._count += 1
        return f"{name}{self._count}"

    def begin(self, label: str) -> None:
        """Go on with a block."""
        self._lines.append(f"{label}:")
        self.block = label

    def branch(self, condition: str, yes: str, no: str) -> None:
        """Go on in one of two blocks, by a condition."""
        self.say(f"br i1 {condition}, label %{yes}, label %{no}")
