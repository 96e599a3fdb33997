"""Functions of Python that write themselves in LLVM's assembly language.

One is called with operands, once, and what it does with them is what the function does when it
runs: operators write instructions (`operands`), `Procedure` has cases and loops. Where it calls
another one, a call is written. Python's own cases and loops decide what is written.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, get_type_hints

from linkages.kernel.code.operands import Fields, Operand
from linkages.kernel.code.procedure import Procedure


class PrintedFunction:
    """A function that writes itself.

    Parameters
    ----------
    function
        Its first argument is the `Procedure` that it writes, of which callers do not know. The
        others are a `Real`, `Whole` or `Truth`, as annotations say, or the named tuple of integers
        at an address.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function
        self.__doc__, self.__name__ = function.__doc__, function.__name__
        module = function.__module__.rpartition(".")[2]
        self.name = f"{module}.{function.__name__}"

    @cached_property
    def _hints(self) -> dict[str, Any]:
        hints = get_type_hints(self._function)
        del hints[next(iter(hints))]  # the procedure
        return hints

    @property
    def _result(self) -> Any:
        found = self._hints["return"]
        return None if found is type(None) else found

    @property
    def _given(self) -> dict[str, Any]:
        return {name: hint for name, hint in self._hints.items() if name != "return"}

    def __call__(self, *given: Any) -> Any:
        """Write a call."""
        code = next(one.code for one in given if isinstance(one, (Operand, Fields)))
        hints = self._given
        if len(given) != len(hints):
            raise TypeError(f"{self.name} takes {len(hints)} arguments, found {len(given)}")
        texts = [_passed(code, hint, one) for hint, one in zip(hints.values(), given, strict=True)]
        code.called.append(self)
        call = f'@"{self.name}"({", ".join(texts)})'
        if self._result is None:
            code.say(f"call void {call}")
            return None
        return self._result(code, code.give(f"call {self._result.kind} {call}"))

    def define(self, name: str = "") -> tuple[str, Procedure]:
        """Its text, for this module alone or under a name, and its body."""
        code, hints, result = Procedure(self._result), self._given, self._result
        given = [_received(code, argument, hint) for argument, hint in hints.items()]
        found = self._function(code, *given)
        if result is None or found is not None:
            code.leave(found)
        code.say("unreachable")
        kinds = ", ".join(f"{_kind(hint)} %{argument}" for argument, hint in hints.items())
        shown = f"@{name}" if name else f'@"{self.name}"'
        scope = "" if name else "internal "
        kind = "void" if result is None else result.kind
        return f"define {scope}{kind} {shown}({kinds}) {{\n{code.text}}}\n", code


def printed(function: Callable[..., Any]) -> PrintedFunction:
    """Make a function write itself."""
    return PrintedFunction(function)


def text_of(function: PrintedFunction) -> str:
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


def _kind(hint: Any) -> str:
    return "ptr" if hasattr(hint, "_fields") else str(hint.kind)


def _passed(code: Procedure, hint: Any, given: Any) -> str:
    if hasattr(hint, "_fields"):
        return f"ptr {given.pointer}"
    return f"{hint.kind} {hint.of(code, given)}"


def _received(code: Procedure, argument: str, hint: Any) -> Any:
    if hasattr(hint, "_fields"):
        return Fields(code, f"%{argument}", hint)
    return hint(code, f"%{argument}")
