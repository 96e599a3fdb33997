"""Compiled functions written in Python: variables, branches and loops.

One is called with operands, once, and its operators write instructions. Where it calls another one,
a call is written. Python's own branches and loops decide what is written.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from typing import Any, get_type_hints

from linkages.kernel.code.instructions import Instructions
from linkages.kernel.code.operands import Bool, Int, Operand, Place, Real, UniformInt

UNROLLED = 16
"""Entries up to which a loop over them is written out."""


class Procedure(Instructions):
    """A function that works on numbers, integers and memory.

    Several lanes go the same way: addresses and indices are the same for all of them, values are
    not.
    """

    def __init__(
        self, result: type[Operand] | None, lanes: int = 1, strides: Mapping[str, int] | None = None
    ) -> None:
        super().__init__(lanes, strides)
        self._result = result
        self._loops: list[tuple[str, str]] = []
        self.called: list[TracedFunction] = []

    def value(self, value: Any) -> Any:
        """A value now: of an operand, which may vary, or a number of Python's."""
        kinds: dict[type, type[Operand]] = {bool: Bool, int: Int, float: Real}
        if isinstance(value, Operand):
            kind = type(value)
        else:
            kind = next(kind for python, kind in kinds.items() if isinstance(value, python))
        return kind(self, kind.of(self, value))

    def variable(self, value: Any) -> Any:
        """A variable with a value at first."""
        now = self.value(value)
        result = type(now)(self, self.assign_at_entry(f"alloca {now.lane_type}"), varies=True)
        result.set(now)
        return result

    def return_(self, value: Any = None) -> None:
        """Return from the function."""
        if self._result is None or value is None:
            self._jump("ret void")
        else:
            self._jump(f"ret {self._result.kind} {self._result.of(self, value)}")

    def return_if(self, condition: Any, value: Any = None) -> None:
        """Return from the function where a condition holds."""
        with self.if_(condition):
            self.return_(value)

    def break_if(self, condition: Any) -> None:
        """Go on behind the innermost loop where a condition holds."""
        with self.if_(condition):
            self.break_()

    def _jump(self, instruction: str) -> None:
        """Go elsewhere; nobody gets to what is written next, unless it begins with a label."""
        self.emit(instruction)
        self.begin_block(self.new_label("never"))

    @contextmanager
    def if_(self, condition: Any) -> Iterator[IfBlock]:
        """Do what is written within where a condition holds, in any lane."""
        yes, no = self.new_label("yes"), self.new_label("no")
        self.branch(self.any_lane(Bool.of(self, condition)), yes, no)
        self.begin_block(yes)
        case = IfBlock(self)
        yield case
        case.end(no)
        self.begin_block(no)

    @contextmanager
    def for_range(self, end: Any) -> Iterator[Int]:
        """Do what is written within for 0, 1, … below an integer."""
        head, body, following, done = map(self.new_label, ("head", "body", "following", "done"))
        last = Int(self, Int.of(self, end))
        index = self.variable(0)
        self.emit(f"br label %{head}")
        self.begin_block(head)
        number = Int(self, index.text)
        self.branch((number < last).text, body, done)
        self.begin_block(body)
        self._loops.append((following, done))
        yield number
        self._loops.pop()
        self.emit(f"br label %{following}")
        self.begin_block(following)
        index.set(number + 1)
        self.emit(f"br label %{head}")
        self.begin_block(done)

    def for_entries(self, count: int) -> Iterator[Any]:
        """Write what follows for 0, 1, … below a number: out, or as a loop if they are many.

        What it changes are variables.
        """
        if count <= UNROLLED:
            yield from range(count)
            return
        index = self.assign_at_entry("alloca i64")
        self.emit(f"store i64 0, ptr {index}")
        head, done = self.new_label("head"), self.new_label("done")
        self.emit(f"br label %{head}")
        self.begin_block(head)
        number = self.assign(f"load i64, ptr {index}")
        yield UniformInt(self, number)
        following = self.assign(f"add i64 {number}, 1")
        self.emit(f"store i64 {following}, ptr {index}")
        self.branch(self.assign(f"icmp ult i64 {following}, {count}"), head, done)
        self.begin_block(done)

    @contextmanager
    def while_(self, condition: Callable[[], Bool]) -> Iterator[None]:
        """Do what is written within again as long as a condition holds."""
        head, body, done = map(self.new_label, ("head", "body", "done"))
        self.emit(f"br label %{head}")
        self.begin_block(head)
        self.branch(condition().text, body, done)
        self.begin_block(body)
        self._loops.append((head, done))
        yield
        self._loops.pop()
        self.emit(f"br label %{head}")
        self.begin_block(done)

    def continue_(self) -> None:
        """Go on with the next round of the innermost loop."""
        self._jump(f"br label %{self._loops[-1][0]}")

    def break_(self) -> None:
        """Go on behind the innermost loop."""
        self._jump(f"br label %{self._loops[-1][1]}")


class IfBlock:
    """What is done where a condition holds, and maybe something else where it does not."""

    def __init__(self, code: Procedure) -> None:
        self._code, self._on = code, ""

    def end(self, target: str) -> None:
        """Go on behind it."""
        self._leave = self._code.placeholder()
        self._leave(f"br label %{target}")

    @contextmanager
    def else_(self) -> Iterator[None]:
        """Do what is written within where the condition does not hold; follows at once."""
        on = self._code.new_label("on")
        self._leave(f"br label %{on}")
        yield
        self._code.emit(f"br label %{on}")
        self._code.begin_block(on)


class TracedFunction:
    """A function that writes itself; annotations tell the kinds of what follows its `Procedure`."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function
        self.__doc__, self.__name__ = function.__doc__, function.__name__
        module = function.__module__.rpartition(".")[2]
        self.name = f"{module}.{function.__name__}"

    @cached_property
    def _hints(self) -> dict[str, Any]:
        hints = get_type_hints(self.function)
        del hints[next(iter(hints))]  # the procedure
        return hints

    @property
    def _result(self) -> Any:
        result = self._hints["return"]
        return None if result is type(None) else result

    @property
    def _given(self) -> dict[str, Any]:
        return {name: hint for name, hint in self._hints.items() if name != "return"}

    def __call__(self, *given: Any) -> Any:
        """Write a call."""
        code = next(one.code for one in given if isinstance(one, (Operand, Place)))
        hints = self._given
        if len(given) != len(hints):
            raise TypeError(f"{self.name} takes {len(hints)} arguments, found {len(given)}")
        pairs = zip(hints.values(), given, strict=True)
        texts = [f"{hint.kind} {hint.of(code, one)}" for hint, one in pairs]
        code.called.append(self)
        call = f'@"{self.name}"({", ".join(texts)})'
        if self._result is None:
            code.emit(f"call void {call}")
            return None
        return self._result(code, code.assign(f"call {self._result.kind} {call}"))

    def define(self, name: str = "") -> tuple[str, Procedure]:
        """Its text, for this module alone or under a name, and its body."""
        code, hints, result = Procedure(self._result), self._given, self._result
        given = [hint(code, f"%{argument}") for argument, hint in hints.items()]
        found = self.function(code, *given)
        if result is None or found is not None:
            code.return_(found)
        code.emit("unreachable")
        kinds = ", ".join(f"{hint.kind} %{argument}" for argument, hint in hints.items())
        shown = f"@{name}" if name else f'@"{self.name}"'
        scope = "" if name else "internal "
        kind = "void" if result is None else result.kind
        return f"define {scope}{kind} {shown}({kinds}) {{\n{code.text}}}\n", code


def traced(function: Callable[..., Any]) -> TracedFunction:
    """Make a function write itself."""
    return TracedFunction(function)


def text_of(function: TracedFunction) -> str:
    """The text of a module with a function, under its own name, and all that it calls."""
    text, code = function.define(function.__name__)
    texts, declared, waiting = {"": text}, dict(code.declared), list(code.called)
    while waiting:
        one = waiting.pop()
        if one.name not in texts:
            texts[one.name], code = one.define()
            declared |= code.declared
            waiting += code.called
    return "\n".join([*texts.values(), *(f"declare {declared[name]}" for name in sorted(declared))])
