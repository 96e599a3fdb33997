"""Writes statements in languages with braces: C, and JavaScript."""

from __future__ import annotations

import re
from abc import abstractmethod
from collections.abc import Sequence

from linkages.kernel.code.printing import Language, call
from linkages.kernel.code.statements import Iterate, Routine
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.graph.several import MOST_ITERATIONS, SEVERAL, system_size


class Braced(Language):
    """What C and JavaScript have in common."""

    forms = "c"
    constant: str
    variable: str
    """How a number is declared that does not change, and one that does."""

    @abstractmethod
    def array(self, name: str, values: Sequence[str]) -> str:
        """The declaration of an array with some values."""

    @abstractmethod
    def several(self, name: str, node: Scalar) -> list[str]:
        """The declaration of an array with all results of an operation that has several."""

    def assigned(self, name: str, node: Scalar) -> list[str]:
        """A declaration with a value."""
        if node.operation in SEVERAL:
            return self.several(name, node)
        return [f"{self.constant} {name} = {self.operation(node)[0]};"]

    def stored(self, place: str, value: str) -> list[str]:
        """An assignment."""
        return [f"{place} = {value};"]

    def heading(self, title: str) -> list[str]:
        """A comment."""
        return ["", f"/* {title} */"]

    def checked(self, value: str, status: int) -> list[str]:
        """A condition, which nan does not meet."""
        return [f"if (!({value} >= 0.0)) return {status};"]

    def looped(self, loop: Iterate) -> list[str]:
        """A loop with an end for what does not converge."""
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
            self.array(loop.name, loop.unknowns),
        ]


class C(Braced):
    """Statements as C99."""

    absolute = "fabs"
    constant = "const double"
    variable = "double"

    def array(self, name: str, values: Sequence[str]) -> str:
        """An array with an initial value."""
        return f"const double {name}[{len(values)}] = {{{', '.join(values)}}};"

    def several(self, name: str, node: Scalar) -> list[str]:
        """An array that a function fills."""
        size = system_size(node) + 1 if node.operation == "solve" else 3
        found = self.solved(node) if node.operation == "solve" else self.interpolated(node)
        return [f"double {name}[{size}];", f"{found.removesuffix(')')}, {name});"]

    def solved(self, node: Scalar) -> str:
        """A call with the matrix, then the right-hand side."""
        entries = ", ".join(self.text(operand) for operand in node.operands)
        return call("solve", [str(system_size(node)), f"(double[]){{{entries}}}"])

    def interpolated(self, node: Scalar) -> str:
        """A call with the address of the table's numbers."""
        time, start, count, periodic = node.arguments
        place = f"p + {start.arguments[1]}"
        return call("spline", [self.text(time), place, str(count), str(int(periodic))])


class JavaScript(Braced):
    """Statements as JavaScript, with functions of ``Math`` by their names."""

    constant = "const"
    variable = "let"

    def array(self, name: str, values: Sequence[str]) -> str:
        """An array."""
        return f"const {name} = [{', '.join(values)}];"

    def several(self, name: str, node: Scalar) -> list[str]:
        """What a function returns."""
        found = self.solved(node) if node.operation == "solve" else self.interpolated(node)
        return [f"const {name} = {found};"]

    def solved(self, node: Scalar) -> str:
        """A call with the matrix, then the right-hand side."""
        entries = ", ".join(self.text(operand) for operand in node.operands)
        return call("solve", [str(system_size(node)), f"[{entries}]"])

    def interpolated(self, node: Scalar) -> str:
        """A call with the place of the table's numbers."""
        time, start, count, periodic = node.arguments
        numbers = ["p", str(start.arguments[1]), str(count), str(periodic).lower()]
        return call("spline", [self.text(time), *numbers])


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
