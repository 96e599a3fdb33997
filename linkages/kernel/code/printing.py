"""Writes kernels as Python, for those who want to read them: straight-line assignments."""

from __future__ import annotations

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

_FUNCTION = '''

def {name}({arguments}):
    """{doc}"""
{body}
    return 0
'''


def write_module(doc: str, routines: Sequence[Routine]) -> str:
    """The text of a module with some functions."""
    return "".join([f'"""{doc}"""\n', *map(_function, routines)])


def _function(routine: Routine) -> str:
    return _FUNCTION.format(
        name=routine.name,
        arguments=", ".join(routine.arguments),
        doc=routine.doc,
        body="\n".join(f"    {line}" if line else "" for line in Python(routine.block).lines()),
    )


class Python:
    """Writes the statements of a block.

    Parameters
    ----------
    block
        What is written.
    """

    language: ClassVar[str] = "python"

    def __init__(self, block: StatementBlock) -> None:
        self._block = block

    def lines(self) -> list[str]:
        """One line for each statement, more for loops."""
        return [line for statement in self._block.statements for line in self._lines(statement)]

    def _lines(self, statement: Statement) -> list[str]:
        match statement:
            case Assign(name, node):
                return [f"{name} = {self._operation(node)[0]}"]
            case Store(entry, node):
                return [f"{_place(entry)} = {self.text(node)}"]
            case Heading(title):
                return ["", f"# {title}"]
            case Check(node, status):
                return [f"if not {self.text(node)} >= 0.0:", f"    return {status}"]
            case Iterate():
                return self._loop(statement)
            case _:
                assert_never(statement)

    def _loop(self, loop: Iterate) -> list[str]:
        iteration, names = loop.iteration, loop.unknowns
        first = [self.text(start) for start in loop.starts]
        body = Python(loop.body)
        updates = [f"d{iteration.block}_{k}" for k in range(len(names))]
        pairs = zip(updates, iteration.updates, strict=True)
        inner = [*body.lines(), *(f"{name} = {body.text(update)}" for name, update in pairs)]
        inner += [f"{name} += {update}" for name, update in zip(names, updates, strict=True)]
        inner += [f"if {_within(updates, iteration.scales, CLOSE)}:", "    break"]
        moved = [f"{name} - {text}" for name, text in zip(names, first, strict=True)]
        return [
            *(f"{name} = {text}" for name, text in zip(names, first, strict=True)),
            f"for _ in range({MOST_ITERATIONS}):",
            *(f"    {line}" if line else "" for line in inner),
            "else:",
            f"    return {loop.status}",
            f"if not ({_within(moved, iteration.scales, MOST_TURNED)}):",
            f"    return {loop.status}",
            f"{loop.name} = ({', '.join(names)},)",
        ]

    def text(self, node: Scalar) -> str:
        """The variable or expression that stands for a node."""
        return self._expression(node)[0]

    def _expression(self, node: Scalar) -> tuple[str, int]:
        """Text, and how strongly it binds."""
        place = self._block.places.get(node.index)
        return self._operation(node) if place is None else (_place(place), ATOM)

    def _operation(self, node: Scalar) -> tuple[str, int]:
        row = ELEMENTARY.get(node.operation)
        if row is not None:
            form = getattr(row, self.language) or row.operator
            if form is None:
                return _call(row.name, [self.text(operand) for operand in node.operands])
            return formed(form, [self._expression(operand) for operand in node.operands])
        match node.operation:
            case "constant":
                value = node.arguments[0]
                return repr(value), ATOM if value >= 0 else _NEGATIVE
            case "item":
                several, index = node.arguments
                return f"{self.text(several)}[{index}]", ATOM
            case "solve":
                name = f"solve{system_size(node)}"
                return _call(name, [self.text(operand) for operand in node.operands])
            case "spline":
                time, start, count, periodic = node.arguments
                numbers = ["p", str(start.arguments[1]), str(count), str(periodic)]
                return _call("spline", [self.text(time), *numbers])
        raise ValueError(f"no text for the operation {node.operation!r}")


def _call(name: str, arguments: Sequence[str]) -> tuple[str, int]:
    return f"{name}({', '.join(arguments)})", ATOM


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


def _within(values: Sequence[str], scales: Sequence[float], limit: float) -> str:
    """A condition that no value exceeds a limit in units of its scale; false for nan."""
    pairs = zip(values, scales, strict=True)
    return " and ".join(f"abs({value}) <= {limit * scale!r}" for value, scale in pairs)
