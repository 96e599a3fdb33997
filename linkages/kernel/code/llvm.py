"""Writes kernels in LLVM's assembly language: one function of straight-line code per routine.

Operations keep the order of the graph; a product that is used by one sum alone becomes a fused
multiply-add with it. Nothing else is contracted or reordered, so that equal inputs give equal bits,
whatever the machine and its instruction set.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import assert_never

from linkages.components.contributed.interpolation import cubic
from linkages.kernel.code.instructions import Instructions, constant
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
from linkages.kernel.code.trigonometry import cosine_and_sine
from linkages.kernel.graph.scalars import Level, Scalar, ScalarGraph, reachable
from linkages.kernel.graph.several import CLOSE, MOST_ITERATIONS, MOST_TURNED, system_size
from linkages.operations import ELEMENTARY


def write_assembly(routines: Sequence[Routine]) -> str:
    """The text of a module with some functions, which are called through their addresses."""
    texts: list[str] = []
    declared: dict[str, str] = {}
    for routine in routines:
        code = Instructions()
        Writer(routine.block, code).write()
        code.say("ret i64 0")
        declared |= code.declared
        arguments = ", ".join(f"{'double' if a == 't' else 'ptr'} %{a}" for a in routine.arguments)
        texts.append(f"define i64 @{routine.name}({arguments}) {{\n{code.text}}}\n")
    if any("@spline(" in text for text in texts):
        text, further = _spline()
        texts.append(text)
        declared |= further
    return "\n".join([*texts, *(f"declare {declared[name]}" for name in sorted(declared))])


class Writer:
    """Writes the statements of a block.

    Parameters
    ----------
    block
        What is written.
    code
        Where.
    values
        Number of a node → its value, of an operation with several results all of them; of what
        stands in variables already.
    """

    def __init__(
        self, block: Block, code: Instructions, values: dict[int, str | list[str]] | None = None
    ) -> None:
        self._block = block
        self._code = code
        self._values = {} if values is None else values
        self._loops: dict[str, list[str]] = {}
        self._turned: dict[int, tuple[str, str]] = {}
        self._entries: dict[Entry, str] = {}

    def write(self) -> None:
        """Write all statements."""
        for statement in self._block.statements:
            self._write(statement)

    def _write(self, statement: Statement) -> None:
        match statement:
            case Heading():
                pass  # for readers; nobody reads this
            case Assign(_, node):
                self._values[node.index] = self._operation(node)
            case Store(entry, node):
                self._code.store(self.value(node), f"%{entry.array}", entry.offset)
            case Check(node, status):
                sound = self._code.compare("oge", self.value(node), constant(0.0))
                self._code.leave_unless(sound, status)
            case Iterate():
                self._iterate(statement)
            case _:
                assert_never(statement)

    def value(self, node: Scalar) -> str:
        """A node as an operand."""
        if node.constant is not None:
            return constant(node.constant)
        found = self._values.get(node.index)
        if found is None:
            place = self._block.places.get(node.index)
            if isinstance(place, Entry):
                return self._entry(place)
            found = self._operation(node)  # part of the expression that uses it
        assert isinstance(found, str)
        return found

    def _entry(self, entry: Entry) -> str:
        if entry.array == "t":
            return "%t"
        if entry not in self._entries:
            self._entries[entry] = self._code.load(f"%{entry.array}", entry.offset)
        return self._entries[entry]

    def _operation(self, node: Scalar) -> str | list[str]:
        code, operands = self._code, node.operands
        match node.operation:
            case "add":
                return self._sum(*operands)
            case "sub":
                return self._difference(*operands)
            case "neg":
                return code.negate(self.value(operands[0]))
            case "sin" | "cos":
                angle = operands[0]
                if angle.index not in self._turned:
                    self._turned[angle.index] = cosine_and_sine(code, self.value(angle))
                return self._turned[angle.index][node.operation == "sin"]
            case "select":
                condition, first, second = map(self.value, operands)
                return code.select(code.compare("oge", condition, constant(0.0)), first, second)
            case "item":
                several, index = node.arguments
                return self._results(several)[index]
            case "solve":
                return solved(code, [self.value(o) for o in operands], system_size(node))
            case "spline":
                time, start, count, periodic = node.arguments
                return self._interpolated(self.value(time), start.arguments[1], count, periodic)
            case name if name in ELEMENTARY:
                instruction = ELEMENTARY[name].llvm or name
                values = [self.value(operand) for operand in operands]
                if instruction in ("fmul", "fdiv"):
                    return code.binary(instruction, *values)
                return code.call(instruction, *values)
        raise ValueError(f"no instruction for the operation {node.operation!r}")

    def _results(self, several: Scalar) -> list[str]:
        """All results of an operation that has several."""
        place = self._block.places[several.index]
        found = self._loops.get(place) if isinstance(place, str) else None
        results = found or self._values[several.index]
        assert isinstance(results, list)
        return results

    def _product(self, node: Scalar) -> tuple[str, str] | None:
        """The factors of a product that nothing else uses."""
        inline = node.index not in self._values and node.index not in self._block.places
        if node.operation != "mul" or not inline:
            return None
        first, second = map(self.value, node.operands)
        return first, second

    def _sum(self, a: Scalar, b: Scalar) -> str:
        for one, other in ((a, b), (b, a)):
            if factors := self._product(one):
                return self._code.fused(*factors, self.value(other))
        return self._code.add(self.value(a), self.value(b))

    def _difference(self, a: Scalar, b: Scalar) -> str:
        code = self._code
        if factors := self._product(a):
            return code.fused(*factors, code.negate(self.value(b)))
        if factors := self._product(b):
            return code.fused(code.negate(factors[0]), factors[1], self.value(a))
        return code.subtract(self.value(a), self.value(b))

    def _interpolated(self, time: str, place: int, count: int, periodic: bool) -> list[str]:
        numbers = self._code.address("%p", place)
        result = self._code.give(
            f"call {_TRIPLE} @spline(double {time}, ptr {numbers}, i64 {count}, "
            f"i1 {str(periodic).lower()})"
        )
        return [self._code.give(f"extractvalue {_TRIPLE} {result}, {k}") for k in range(3)]

    def _iterate(self, loop: Iterate) -> None:
        """Newton's iteration: a block that goes on with itself."""
        code, iteration = self._code, loop.iteration
        known: dict[int, str | list[str]] = dict(self._values)
        known |= {node.index: self.value(node) for node in iteration.external}
        first = [self.value(start) for start in loop.starts]
        before = code.block
        again, more, done = (code.new_label(name) for name in ("again", "more", "done"))
        code.say(f"br label %{again}")
        code.begin(again)
        unknowns, rounds = [code.name() for _ in first], code.name()
        heads = [code.later() for _ in (*unknowns, rounds)]
        known |= {n.index: z for n, z in zip(iteration.iterates, unknowns, strict=True)}
        body = Writer(loop.body, code, known)
        body.write()
        updates = [body.value(update) for update in iteration.updates]
        moved = [code.add(z, update) for z, update in zip(unknowns, updates, strict=True)]
        code.branch(_within(code, updates, iteration.scales, CLOSE), done, more)
        code.begin(more)
        count = code.give(f"add i64 {rounds}, 1")
        code.leave_unless(code.give(f"icmp ult i64 {count}, {MOST_ITERATIONS}"), loop.status)
        code.say(f"br label %{again}")
        for head, z, start, end in zip(heads, unknowns, first, moved, strict=False):
            head(f"{z} = phi double [ {start}, %{before} ], [ {end}, %{code.block} ]")
        heads[-1](f"{rounds} = phi i64 [ 0, %{before} ], [ {count}, %{code.block} ]")
        code.begin(done)
        turned = [code.subtract(z, start) for z, start in zip(moved, first, strict=True)]
        code.leave_unless(_within(code, turned, iteration.scales, MOST_TURNED), loop.status)
        self._loops[loop.name] = moved


def _within(
    code: Instructions, values: Sequence[str], scales: Sequence[float], limit: float
) -> str:
    """Whether no value exceeds a limit in units of its scale; false for nan."""
    pairs = zip(values, scales, strict=True)
    return code.all_of(
        [code.compare("ole", code.absolute(v), constant(limit * scale)) for v, scale in pairs]
    )


def solved(code: Instructions, entries: Sequence[str], size: int) -> list[str]:
    """Write the solution of a linear system, and the determinant.

    Elimination with row exchanges, unrolled; rows are exchanged without branches.
    """
    rows = [[*entries[size * i : size * (i + 1)], entries[size * size + i]] for i in range(size)]
    sign = constant(1.0)
    for k in range(size):
        for i in range(k + 1, size):
            larger = code.compare("ogt", code.absolute(rows[i][k]), code.absolute(rows[k][k]))
            for j in range(k, size + 1):
                one, other = rows[k][j], rows[i][j]
                rows[k][j] = code.select(larger, other, one)
                rows[i][j] = code.select(larger, one, other)
            sign = code.select(larger, code.negate(sign), sign)
        for i in range(k + 1, size):
            factor = code.negate(code.divide(rows[i][k], rows[k][k]))
            for j in range(k + 1, size + 1):
                rows[i][j] = code.fused(factor, rows[k][j], rows[i][j])
    solution = [""] * size
    for k in reversed(range(size)):
        rest = rows[k][size]
        for j in range(k + 1, size):
            rest = code.fused(code.negate(rows[k][j]), solution[j], rest)
        solution[k] = code.divide(rest, rows[k][k])
    determinant = sign
    for k in range(size):
        determinant = code.multiply(determinant, rows[k][k])
    return [*solution, determinant]


_TRIPLE = "{double, double, double}"


def _spline() -> tuple[str, dict[str, str]]:
    """A function: value and derivatives of piecewise cubics whose numbers stand in p.

    Also returned is what it calls.
    """
    code = Instructions()
    end = code.give("add i64 %count, 1")
    first, last = code.load("%p", 0), code.load("%p", "%count")
    time = _within_period(code, first, last)
    inner = code.select(code.compare("ogt", first, time), first, time)
    inner = code.select(code.compare("olt", last, inner), last, inner)
    low = _interval(code, inner)
    coefficients = code.give(f"add i64 {end}, {code.give(f'shl i64 {low}, 2')}")
    numbers = code.address("%p", coefficients)
    x = code.subtract(inner, code.load("%p", low))
    outside = code.subtract(time, inner)
    values = [x, outside, *(code.load(numbers, k) for k in range(4))]
    value, slope, curvature = _cubic(code, values)
    beyond = code.compare("une", outside, constant(0.0))
    results = (value, slope, code.select(beyond, constant(0.0), curvature))
    triple = "undef"
    for k, result in enumerate(results):
        triple = code.give(f"insertvalue {_TRIPLE} {triple}, double {result}, {k}")
    code.say(f"ret {_TRIPLE} {triple}")
    arguments = "double %t, ptr %p, i64 %count, i1 %periodic"
    return f"define internal {_TRIPLE} @spline({arguments}) {{\n{code.text}}}\n", code.declared


def _within_period(code: Instructions, first: str, last: str) -> str:
    """The time, or where it stands in its period if there is one."""
    span = code.subtract(last, first)
    rest = code.binary("frem", code.subtract("%t", first), span)
    negative = code.compare("olt", rest, constant(0.0))
    rest = code.select(negative, code.add(rest, span), rest)
    return code.select("%periodic", code.add(first, rest), "%t")


def _interval(code: Instructions, inner: str) -> str:
    """Number of the interval in which a time lies, by bisection."""
    before = code.block
    search, halve, found = (code.new_label(name) for name in ("search", "halve", "found"))
    code.say(f"br label %{search}")
    code.begin(search)
    low, high = code.name(), code.name()
    heads = code.later(), code.later()
    apart = code.give(f"sub i64 {high}, {low}")
    code.branch(code.give(f"icmp sgt i64 {apart}, 1"), halve, found)
    code.begin(halve)
    middle = code.give(f"lshr i64 {code.give(f'add i64 {low}, {high}')}, 1")
    above = code.compare("ole", code.load("%p", middle), inner)
    ends = code.select(above, middle, low, "i64"), code.select(above, high, middle, "i64")
    code.say(f"br label %{search}")
    for head, name, start, end in zip(heads, (low, high), ("0", "%count"), ends, strict=True):
        head(f"{name} = phi i64 [ {start}, %{before} ], [ {end}, %{code.block} ]")
    code.begin(found)
    return low


def _cubic(code: Instructions, values: Sequence[str]) -> list[str]:
    """The formula of `linkages.components.contributed.interpolation.cubic`."""
    graph = ScalarGraph()
    inputs = [graph.input("y", k, Level.STATE) for k in range(len(values))]
    results = cubic(*inputs)
    known: dict[int, str | list[str]] = {
        node.index: value for node, value in zip(inputs, values, strict=True)
    }
    block = build_block(reachable(results), dict.fromkeys(known, ""), results)
    writer = Writer(block, code, known)
    writer.write()
    return [writer.value(result) for result in results]
