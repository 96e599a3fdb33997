"""Writes kernels as Python that Numba compiles: one module of straight-line assignments."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import ClassVar, assert_never

from linkages.components.contributed.interpolation import cubic
from linkages.kernel.code.statements import (
    Assign,
    Block,
    Check,
    Entry,
    Heading,
    Iterate,
    Routine,
    Statement,
    Store,
    build_block,
)
from linkages.kernel.graph.scalars import Level, Scalar, ScalarGraph, reachable
from linkages.kernel.graph.several import CLOSE, MOST_ITERATIONS, MOST_TURNED, system_size
from linkages.operations import ATOM, ELEMENTARY, Form

_NEGATIVE = 3
"""How strongly negative numbers bind, as negations do."""

_HEADER = '''"""{doc}"""

{imports}from numba import carray, cfunc, njit, types

_array = types.CPointer(types.float64)
_options = {{"cache": True, "error_model": "numpy", "fastmath": {{"contract"}}}}
_inline = _options
'''

_FUNCTION = '''

@cfunc(types.int64({signature}), **_options)
def {name}({arguments}):
    """{doc}"""
{body}
    return 0
'''


def write_module(doc: str, routines: Sequence[Routine]) -> str:
    """The text of a module with some functions, which are called through their addresses."""
    called: set[str] = set()
    functions = [_function(routine, called) for routine in routines]
    known = sorted(called & ELEMENTARY.keys())
    imports = f"from math import {', '.join(known)}\n\n" if known else ""
    return "".join([_HEADER.format(doc=doc, imports=imports), definitions(called), *functions])


def _function(routine: Routine, called: set[str]) -> str:
    views = [f"{a} = carray({a}, ({size},))" for a, size in routine.arguments.items() if size]
    lines = [*views, *Python(routine.block, called).lines()]
    return _FUNCTION.format(
        name=routine.name,
        signature=", ".join("types.float64" if a == "t" else "_array" for a in routine.arguments),
        arguments=", ".join(routine.arguments),
        doc=routine.doc,
        body="\n".join(f"    {line}" if line else "" for line in lines),
    )


class Python:
    """Writes the statements of a block.

    Parameters
    ----------
    block
        What is written.
    called
        Gets the names of the functions that the text calls.
    """

    language: ClassVar[str] = "python"

    def __init__(self, block: Block, called: set[str]) -> None:
        self._block = block
        self._called = called

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
        body = Python(loop.body, self._called)
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
                return self._call(row.name, [self.text(operand) for operand in node.operands])
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
                return self._call(name, [self.text(operand) for operand in node.operands])
            case "spline":
                time, start, count, periodic = node.arguments
                numbers = ["p", str(start.arguments[1]), str(count), str(periodic)]
                return self._call("spline", [self.text(time), *numbers])
        raise ValueError(f"no text for the operation {node.operation!r}")

    def _call(self, name: str, arguments: Sequence[str]) -> tuple[str, int]:
        self._called.add(name)
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


def definitions(called: Iterable[str]) -> str:
    """The functions out of those called that Python does not have."""
    found = sorted({*called} - ELEMENTARY.keys(), key=lambda name: (len(name), name))
    texts = (_SPLINE if n == "spline" else _solver(int(n.removeprefix("solve"))) for n in found)
    return "".join(f"\n\n@njit(**_inline)\n{text}\n" for text in texts)


def _solver(size: int) -> str:
    """Elimination with row exchanges, unrolled."""
    span = range(size)
    entries = [f"a{i}_{j}" for i in span for j in span] + [f"b{i}" for i in span]
    lines = [f"def solve{size}({', '.join(entries)}):", '    """Solution and determinant."""']
    lines.append("    sign = 1.0")
    for k in span:
        for i in range(k + 1, size):
            row = [f"a{k}_{j}" for j in range(k, size)] + [f"b{k}"]
            other = [f"a{i}_{j}" for j in range(k, size)] + [f"b{i}"]
            lines.append(f"    if abs(a{i}_{k}) > abs(a{k}_{k}):")
            lines.append(f"        {', '.join(row + other)} = {', '.join(other + row)}")
            lines.append("        sign = -sign")
        for i in range(k + 1, size):
            lines.append(f"    f = a{i}_{k} / a{k}_{k}")
            lines += [f"    a{i}_{j} -= f * a{k}_{j}" for j in range(k + 1, size)]
            lines.append(f"    b{i} -= f * b{k}")
    for k in reversed(span):
        known = "".join(f" - a{k}_{j} * x{j}" for j in range(k + 1, size))
        lines.append(f"    x{k} = (b{k}{known}) / a{k}_{k}")
    pivots = " * ".join(f"a{k}_{k}" for k in span)
    lines.append(f"    return {', '.join(f'x{k}' for k in span)}, sign * {pivots}")
    return "\n".join(lines)


def _cubic() -> str:
    """Assignments of the formula of `linkages.components.contributed.interpolation.cubic`."""
    graph = ScalarGraph()
    names = ("x", "outside", "d", "c", "b", "a")
    inputs = [graph.input(name, 0, Level.STATE) for name in names]
    results = cubic(*inputs)
    for node, label in zip(results, ("value", "slope", "curvature"), strict=True):
        node.label = label
    places = {node.index: name for node, name in zip(inputs, names, strict=True)}
    return "\n    ".join(Python(build_block(reachable(results), places, results), set()).lines())


_SPLINE = f'''def spline(t, p, place, count, periodic):
    """Value and derivatives of piecewise cubics whose numbers stand in p from a place on."""
    first, last = p[place], p[place + count]
    if periodic:
        t = first + (t - first) % (last - first)
    inner = min(max(t, first), last)
    low, high = 0, count
    while high - low > 1:
        middle = (low + high) // 2
        if p[place + middle] <= inner:
            low = middle
        else:
            high = middle
    k = place + count + 1 + 4 * low
    d, c, b, a = p[k], p[k + 1], p[k + 2], p[k + 3]
    x, outside = inner - p[place + low], t - inner
    {_cubic()}
    return value, slope, curvature if outside == 0.0 else 0.0'''
