"""Writes kernels as text of a language, for people and for other programs: one line a statement.

Here stand what languages have in common, and Python; C and JavaScript stand beside this file.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar, assert_never

from linkages.kernel.code.statements import (
    Assign,
    Check,
    Entry,
    Heading,
    Iterate,
    Routine,
    Statement,
    StatementBlock,
    Store,
)
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.graph.several import CLOSE, MOST_ITERATIONS, MOST_TURNED, system_size
from linkages.operations import ATOM, ELEMENTARY, Form

_NEGATIVE = 3
"""How strongly negative numbers bind, as negations do."""

_OPERAND = Form("{}", 1, (2,))
"""Whatever is subtracted."""

_FUNCTION = '''

def {name}({arguments}):
    """{doc}"""
{body}
    return 0
'''


def write_module(doc: str, routines: Sequence[Routine]) -> str:
    """The text of a module with some functions."""
    return "".join([f'"""{doc}"""\n', *map(python_function, routines)])


def python_function(routine: Routine, language: type[Language] | None = None) -> str:
    """A routine as a function of Python, as a way of writing it has it; `Python` if not given."""
    lines = (language or Python)(routine.block).lines()
    return _FUNCTION.format(
        name=routine.name,
        arguments=", ".join(routine.arguments),
        doc=routine.doc,
        body="\n".join(f"    {line}" if line else "" for line in lines),
    )


class Language(ABC):
    """Writes the statements of a block.

    Parameters
    ----------
    block
        What is written.
    """

    forms: ClassVar[str]
    """The column of `linkages.operations` with its own forms."""

    absolute: ClassVar[str] = "abs"
    both: ClassVar[str] = " && "
    """How it writes an absolute value, and that two conditions hold."""

    def __init__(self, block: StatementBlock) -> None:
        self._block = block

    def lines(self) -> list[str]:
        """One line for each statement, more for loops."""
        return [line for statement in self._block.statements for line in self._lines(statement)]

    def _lines(self, statement: Statement) -> list[str]:
        match statement:
            case Assign(name, node):
                return self.assigned(name, node)
            case Store(entry, node):
                return self.stored(_place(entry), self.text(node))
            case Heading(title):
                return self.heading(title)
            case Check(node, status):
                return self.checked(self.text(node), status)
            case Iterate():
                return self.looped(statement)
            case _:
                assert_never(statement)

    @abstractmethod
    def assigned(self, name: str, node: Scalar) -> list[str]:
        """A variable gets the value of a node."""

    @abstractmethod
    def stored(self, place: str, value: str) -> list[str]:
        """An entry of an array gets a value."""

    @abstractmethod
    def heading(self, title: str) -> list[str]:
        """A comment."""

    @abstractmethod
    def checked(self, value: str, status: int) -> list[str]:
        """The routine ends where a value is negative or nan."""

    @abstractmethod
    def looped(self, loop: Iterate) -> list[str]:
        """Newton's iteration."""

    @abstractmethod
    def solved(self, node: Scalar) -> str:
        """The call that solves a linear system."""

    @abstractmethod
    def interpolated(self, node: Scalar) -> str:
        """The call that interpolates a table."""

    def updated(self, loop: Iterate) -> tuple[list[str], list[tuple[str, str, str]], str, str]:
        """Parts of an iteration.

        Returns
        -------
        The lines of its body; the names of unknowns, of updates and what those are; the conditions
        that the updates are small, and that the unknowns did not move far.
        """
        iteration, body = loop.iteration, type(self)(loop.body)
        names = [f"d{iteration.block}_{k}" for k in range(len(loop.unknowns))]
        texts = [body.text(update) for update in iteration.updates]
        moved = [
            f"{name} - {formed(_OPERAND, [self.expression(start)])[0]}"
            for name, start in zip(loop.unknowns, loop.starts, strict=True)
        ]
        small = self._within(names, iteration.scales, CLOSE)
        near = self._within(moved, iteration.scales, MOST_TURNED)
        return body.lines(), list(zip(loop.unknowns, names, texts, strict=True)), small, near

    def _within(self, values: Sequence[str], scales: Sequence[float], limit: float) -> str:
        """A condition that no value exceeds a limit in units of its scale; false for nan."""
        pairs = zip(values, scales, strict=True)
        return self.both.join(f"{self.absolute}({v}) <= {limit * scale!r}" for v, scale in pairs)

    def text(self, node: Scalar) -> str:
        """The variable or expression that stands for a node."""
        return self.expression(node)[0]

    def expression(self, node: Scalar) -> tuple[str, int]:
        """Text, and how strongly it binds."""
        place = self._block.places.get(node.index)
        return self.operation(node) if place is None else (_place(place), ATOM)

    def operation(self, node: Scalar) -> tuple[str, int]:
        """The same of a node as if it stood nowhere."""
        row = ELEMENTARY.get(node.operation)
        if row is not None:
            form = getattr(row, self.forms) or row.operator
            if form is None:
                return call(row.name, [self.text(operand) for operand in node.operands]), ATOM
            return formed(form, [self.expression(operand) for operand in node.operands])
        match node.operation:
            case "constant":
                value = node.arguments[0]
                return repr(value), ATOM if value >= 0 else _NEGATIVE
            case "item":
                several, index = node.arguments
                return f"{self.text(several)}[{index}]", ATOM
            case "solve":
                return self.solved(node), ATOM
            case "spline":
                return self.interpolated(node), ATOM
        raise ValueError(f"no text for the operation {node.operation!r}")


class Python(Language):
    """Statements as Python."""

    forms = "python"
    both = " and "

    def assigned(self, name: str, node: Scalar) -> list[str]:
        """An assignment."""
        return [f"{name} = {self.operation(node)[0]}"]

    def stored(self, place: str, value: str) -> list[str]:
        """An assignment."""
        return [f"{place} = {value}"]

    def heading(self, title: str) -> list[str]:
        """A comment."""
        return ["", f"# {title}"]

    def checked(self, value: str, status: int) -> list[str]:
        """A condition."""
        return [f"if not {value} >= 0.0:", f"    return {status}"]

    def solved(self, node: Scalar) -> str:
        """A function for each size."""
        return call(f"solve{system_size(node)}", [self.text(operand) for operand in node.operands])

    def interpolated(self, node: Scalar) -> str:
        """A function that finds its numbers among the parameters."""
        time, start, count, periodic = node.arguments
        numbers = ["p", str(start.arguments[1]), str(count), str(periodic)]
        return call("spline", [self.text(time), *numbers])

    def looped(self, loop: Iterate) -> list[str]:
        """A loop with an end for what does not converge."""
        body, unknowns, small, near = self.updated(loop)
        inner = [*body, *(f"{update} = {text}" for _, update, text in unknowns)]
        inner += [f"{name} += {update}" for name, update, _ in unknowns]
        inner += [f"if {small}:", "    break"]
        pairs = zip(loop.unknowns, loop.starts, strict=True)
        return [
            *(f"{name} = {self.text(start)}" for name, start in pairs),
            f"for _ in range({MOST_ITERATIONS}):",
            *(f"    {line}" if line else "" for line in inner),
            "else:",
            f"    return {loop.status}",
            f"if not ({near}):",
            f"    return {loop.status}",
            f"{loop.name} = ({', '.join(loop.unknowns)},)",
        ]


def call(name: str, arguments: Sequence[str]) -> str:
    """A call of a function."""
    return f"{name}({', '.join(arguments)})"


def formed(form: Form, operands: Sequence[tuple[str, int]]) -> tuple[str, int]:
    """An operation as a language writes it, its operands with no more parentheses than needed.

    Each operand, and what is returned, is a text and how strongly it binds.
    """
    pairs = zip(operands, form.operands, strict=False)
    texts = [text if bound >= least else f"({text})" for (text, bound), least in pairs]
    return form.template.format(*texts), form.strength


def _place(place: Entry | str) -> str:
    if isinstance(place, str):
        return place
    return "t" if place.array == "t" else f"{place.array}[{place.offset}]"
