"""Kernels as text of other languages: C, JavaScript, Python.

Here stand what languages have in common, and Python; C and JavaScript stand beside this file.
"""

from __future__ import annotations

import re
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
from linkages.kernel.differentiation import (
    CLOSE,
    MOST_ITERATIONS,
    MOST_TURNED,
    SEVERAL,
    system_size,
)
from linkages.kernel.scalars import Scalar
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
    """Writes the statements of a block."""

    forms: ClassVar[str]
    """The column of `linkages.operations` with its own forms."""

    absolute: ClassVar[str] = "abs"
    both: ClassVar[str] = " && "
    truths: ClassVar[tuple[str, str]]
    numbers: ClassVar[str] = "p, {}"
    """How it writes an absolute value, that two conditions hold, false and true, and parameters
    from one of them on."""

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

    def interpolated(self, node: Scalar) -> str:
        """The call that interpolates a table, whose numbers are among the parameters."""
        time, start, count, periodic = node.arguments
        numbers = self.numbers.format(start.arguments[1])
        return call("spline", [self.text(time), numbers, str(count), self.truths[periodic]])

    def updated(self, loop: Iterate) -> tuple[list[str], list[tuple[str, str, str]], str, str]:
        """Lines of an iteration, (unknown, update, text), and conditions: settled, and not far."""
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
    truths = ("False", "True")

    def assigned(self, name: str, node: Scalar) -> list[str]:
        return [f"{name} = {self.operation(node)[0]}"]

    def stored(self, place: str, value: str) -> list[str]:
        return [f"{place} = {value}"]

    def heading(self, title: str) -> list[str]:
        return ["", f"# {title}"]

    def checked(self, value: str, status: int) -> list[str]:
        return [f"if not {value} >= 0.0:", f"    return {status}"]

    def solved(self, node: Scalar) -> str:
        return call(f"solve{system_size(node)}", [self.text(operand) for operand in node.operands])

    def looped(self, loop: Iterate) -> list[str]:
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
    """An operation as a language writes it, with no more parentheses than needed.

    Each operand, and the result, is a text and how strongly it binds.
    """
    pairs = zip(operands, form.operands, strict=False)
    texts = [text if bound >= least else f"({text})" for (text, bound), least in pairs]
    return form.template.format(*texts), form.strength


def _place(place: Entry | str) -> str:
    if isinstance(place, str):
        return place
    return "t" if place.array == "t" else f"{place.array}[{place.offset}]"


class Braced(Language):
    """What C and JavaScript have in common."""

    forms = "c"
    constant: str
    variable: str
    """How a number is declared that does not change, and one that does."""
    array: str
    entries: str
    """An array with a name and values, and values as an argument."""

    def solved(self, node: Scalar) -> str:
        entries = ", ".join(self.text(operand) for operand in node.operands)
        return call("solve", [str(system_size(node)), self.entries.format(entries)])

    @abstractmethod
    def several(self, name: str, node: Scalar) -> list[str]:
        """The declaration of an array with all results of an operation that has several."""

    def assigned(self, name: str, node: Scalar) -> list[str]:
        if node.operation in SEVERAL:
            return self.several(name, node)
        return [f"{self.constant} {name} = {self.operation(node)[0]};"]

    def stored(self, place: str, value: str) -> list[str]:
        return [f"{place} = {value};"]

    def heading(self, title: str) -> list[str]:
        return ["", f"/* {title} */"]

    def checked(self, value: str, status: int) -> list[str]:
        return [f"if (!({value} >= 0.0)) return {status};"]

    def looped(self, loop: Iterate) -> list[str]:
        body, unknowns, small, near = self.updated(loop)
        turn = f"turn{loop.iteration.block}"
        inner = [f"if ({turn} == {MOST_ITERATIONS}) return {loop.status};", *body]
        inner += [f"{self.constant} {update} = {text};" for _, update, text in unknowns]
        inner += [f"{name} += {update};" for name, update, _ in unknowns]
        inner.append(f"if ({small}) break;")
        pairs = zip(loop.unknowns, loop.starts, strict=True)
        counter = self.variable.replace("double", "int")
        return [
            *(f"{self.variable} {name} = {self.text(start)};" for name, start in pairs),
            f"for ({counter} {turn} = 0; ; {turn}++) {{",
            *(f"  {line}" if line else "" for line in inner),
            "}",
            f"if (!({near})) return {loop.status};",
            self.array.format(loop.name, ", ".join(loop.unknowns), len(loop.unknowns)),
        ]


class C(Braced):
    """Statements as C99."""

    absolute = "fabs"
    truths = ("0", "1")
    numbers = "p + {}"
    constant = "const double"
    variable = "double"
    array = "const double {0}[{2}] = {{{1}}};"
    entries = "(double[]){{{}}}"

    def several(self, name: str, node: Scalar) -> list[str]:
        size = system_size(node) + 1 if node.operation == "solve" else 3
        result = self.solved(node) if node.operation == "solve" else self.interpolated(node)
        return [f"double {name}[{size}];", f"{result.removesuffix(')')}, {name});"]


class JavaScript(Braced):
    """Statements as JavaScript, with functions of ``Math`` by their names."""

    truths = ("false", "true")
    constant = "const"
    variable = "let"
    array = "const {0} = [{1}];"
    entries = "[{}]"

    def several(self, name: str, node: Scalar) -> list[str]:
        result = self.solved(node) if node.operation == "solve" else self.interpolated(node)
        return [f"const {name} = {result};"]


def javascript_function(routine: Routine) -> str:
    """A routine as a function of JavaScript."""
    head = f"function {routine.name}({', '.join(routine.arguments)})"
    return _function(head, routine, JavaScript(routine.block).lines())


def c_function(routine: Routine) -> str:
    """A routine as a function of C."""
    given = [_argument(name, routine) for name in routine.arguments]
    lines = C(routine.block).lines()
    text = "\n".join(lines)
    unused = [f"(void){a};" for a in routine.arguments if not re.search(rf"\b{a}\b", text)]
    return _function(f"int {routine.name}({', '.join(given)})", routine, [*unused, *lines])


def _argument(name: str, routine: Routine) -> str:
    if name == "t":
        return "double t"
    return f"double *{name}" if name in routine.written else f"const double *{name}"


def _function(head: str, routine: Routine, lines: Sequence[str]) -> str:
    body = "\n".join(f"  {line}" if line else "" for line in [*lines, "return 0;"])
    return f"/* {routine.doc} */\n{head} {{\n{body}\n}}\n"
