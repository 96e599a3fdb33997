"""Modules in LLVM's assembly language: a function of straight-line code per routine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from linkages.kernel.code.instructions import DOUBLE, INTEGER, Instructions
from linkages.kernel.code.splines import spline_function
from linkages.kernel.code.statements import Routine
from linkages.kernel.code.writer import SPLINE, Writer


def write_assembly(routines: Sequence[Routine], lanes: int = 1) -> str:
    """The text of a module with some functions, which are called through their addresses.

    Parameters
    ----------
    routines
        What they do.
    lanes
        Number W of states side by side. One state has ``int64 routine(double t, double *array…)``;
        several have ``void routine(double *t, double *array…, int64 *status)``, where all arrays,
        the times and the statuses consist of rows of W numbers.
    """
    module = Module(lanes)
    for routine in routines:
        module.add(routine)
    return module.text


class Module:
    """Functions for one state or several lanes, and what they call.

    Parameters
    ----------
    lanes, strides
        As `Instructions` has them.

    Attributes
    ----------
    declared
        Signature of each function of the outside that is called.
    """

    def __init__(self, lanes: int = 1, strides: Mapping[str, int] | None = None) -> None:
        self._form = lanes, strides
        self._texts: list[str] = []
        self.declared: dict[str, str] = {}

    def instructions(self) -> Instructions:
        """A body for a function, to be filled and then defined."""
        return Instructions(*self._form)

    def define(self, signature: str, code: Instructions) -> None:
        """Add a function, such as ``internal double @square(double %x)``."""
        self.declared |= code.declared
        self._texts.append(f"define {signature} {{\n{code.text}}}\n")

    def add(self, routine: Routine, internal: bool = False) -> None:
        """Add a routine; `internal` if only this module calls it."""
        code = self.instructions()
        Writer(routine.block, code).write()
        code.end()
        scalars = ("t",) if code.lanes == 1 else ()
        arguments = [f"{'double' if a in scalars else 'ptr'} %{a}" for a in routine.arguments]
        if code.lanes > 1:
            arguments.append("ptr %status")
        result = ("internal " if internal else "") + ("i64" if code.lanes == 1 else "void")
        self.define(f"{result} @{routine.name}({', '.join(arguments)})", code)

    @property
    def text(self) -> str:
        """All functions and declarations."""
        texts, declared = list(self._texts), dict(self.declared)
        if any(f"@{SPLINE}(" in text for text in texts):
            code = self.instructions()
            texts.append(f"define internal {spline_function(code)} {{\n{code.text}}}\n")
            declared |= code.declared
        return "\n".join([*texts, *(f"declare {declared[name]}" for name in sorted(declared))])


def call_routine(code: Instructions, routine: Routine, given: Mapping[str, str]) -> str:
    """Write a call of a routine that has been added to the same module; returns its statuses.

    Parameters
    ----------
    code
        Where.
    routine
        What is called.
    given
        Argument → address of an array, or the time itself.
    """
    operands = []
    for name in routine.arguments:
        kind, operand = "ptr", given[name]
        if name == "t":
            kind, operand = _passed(code, operand)
        operands.append(f"{kind} {operand}")
    if code.lanes == 1:
        return code.give(f"call {INTEGER} @{routine.name}({', '.join(operands)})")
    status = code.reserve(1)
    code.say(f"call void @{routine.name}({', '.join([*operands, f'ptr {status}'])})")
    return code.give(f"load {code.integer}, ptr {status}, align 8")


def _passed(code: Instructions, time: str) -> tuple[str, str]:
    """Times as an argument: one is a number, several are a row."""
    if code.lanes == 1:
        return DOUBLE, time
    row = code.reserve(1)
    code.store(time, row, 0)
    return "ptr", row
