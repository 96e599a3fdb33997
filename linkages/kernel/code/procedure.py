"""The body of a printed function: what `Instructions` has, with variables, cases and loops."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from linkages.kernel.code.instructions import Instructions
from linkages.kernel.code.operands import Fields, Operand, Real, Truth, Whole

if TYPE_CHECKING:
    from linkages.kernel.code.printed import PrintedFunction


class Procedure(Instructions):
    """A function that works on numbers, integers and memory, for a single state.

    Parameters
    ----------
    result
        Kind of what it returns; None if that is nothing.

    Attributes
    ----------
    called
        Printed functions that it calls.
    """

    def __init__(self, result: type[Operand] | None) -> None:
        super().__init__()
        self._result = result
        self._loops: list[tuple[str, str]] = []
        self.called: list[PrintedFunction] = []

    def value(self, value: Any) -> Any:
        """A value now: of an operand, which may vary, or a number of Python's."""
        kinds: dict[type, type[Operand]] = {float: Real, int: Whole, bool: Truth}
        kind = type(value) if isinstance(value, Operand) else kinds[type(value)]
        return kind(self, kind.of(self, value))

    def variable(self, value: Any) -> Any:
        """A variable with a value at first."""
        now = self.value(value)
        found = type(now)(self, self.first(f"alloca {now.kind}"), varies=True)
        found.set(now)
        return found

    def leave(self, value: Any = None) -> None:
        """Return from the function."""
        if self._result is None:
            self._jump("ret void")
        else:
            self._jump(f"ret {self._result.kind} {self._result.of(self, value)}")

    def _jump(self, instruction: str) -> None:
        """Go elsewhere; nobody gets to what is written next, unless it begins with a label."""
        self.say(instruction)
        self.begin(self.new_label("never"))

    @contextmanager
    def when(self, condition: Any) -> Iterator[Case]:
        """Do what is written within where a condition holds."""
        yes, no = self.new_label("yes"), self.new_label("no")
        self.branch(Truth.of(self, condition), yes, no)
        self.begin(yes)
        case = Case(self)
        yield case
        case.end(no)
        self.begin(no)

    @contextmanager
    def count(self, end: Any) -> Iterator[Whole]:
        """Do what is written within for 0, 1, … below an integer."""
        head, body, following, done = map(self.new_label, ("head", "body", "following", "done"))
        last = Whole(self, Whole.of(self, end))
        index = self.variable(0)
        self.say(f"br label %{head}")
        self.begin(head)
        number = Whole(self, index.text)
        self.branch((number < last).text, body, done)
        self.begin(body)
        self._loops.append((following, done))
        yield number
        self._loops.pop()
        self.say(f"br label %{following}")
        self.begin(following)
        index.set(number + 1)
        self.say(f"br label %{head}")
        self.begin(done)

    @contextmanager
    def during(self, condition: Callable[[], Truth]) -> Iterator[None]:
        """Do what is written within again as long as a condition holds."""
        head, body, done = map(self.new_label, ("head", "body", "done"))
        self.say(f"br label %{head}")
        self.begin(head)
        self.branch(condition().text, body, done)
        self.begin(body)
        self._loops.append((head, done))
        yield
        self._loops.pop()
        self.say(f"br label %{head}")
        self.begin(done)

    def again(self) -> None:
        """Go on with the next round of the innermost loop."""
        self._jump(f"br label %{self._loops[-1][0]}")

    def stop(self) -> None:
        """Go on behind the innermost loop."""
        self._jump(f"br label %{self._loops[-1][1]}")

    def fields_at(self, address: Any, named: Any, words: int = 0, lasting: bool = True) -> Any:
        """The named tuple of integers so many words behind an address.

        `lasting` if the address is an argument.
        """
        write = self.first if lasting else self.give
        pointer = write(f"inttoptr i64 {address.text} to ptr")
        if words:
            pointer = write(f"getelementptr i64, ptr {pointer}, i64 {words}")
        return Fields(self, pointer, named, lasting)

    def call_at(self, address: Any, result: type[Operand], *given: Any) -> Any:
        """Call the function at an address."""
        pointer = self.give(f"inttoptr i64 {address.text} to ptr")
        texts = ", ".join(f"{each.kind} {each.text}" for each in given)
        return result(self, self.give(f"call {result.kind} {pointer}({texts})"))


class Case:
    """What is done where a condition holds, and maybe something else where it does not."""

    def __init__(self, code: Procedure) -> None:
        self._code, self._on = code, ""

    def end(self, target: str) -> None:
        """Go on behind it."""
        self._leave = self._code.later()
        self._leave(f"br label %{target}")

    @contextmanager
    def otherwise(self) -> Iterator[None]:
        """Do what is written within where the condition does not hold; follows at once."""
        on = self._code.new_label("on")
        self._leave(f"br label %{on}")
        yield
        self._code.say(f"br label %{on}")
        self._code.begin(on)
