"""Writes statements in LLVM's assembly language, a function per routine, or several if it is long.

A product that is used by one sum alone becomes a fused multiply-add with it. Nothing else is
contracted or reordered: bits do not depend on the machine or on the number of lanes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import and_
from typing import TypeAlias, assert_never

from linkages.components.contributed.functions import cubic
from linkages.kernel.code.elementary_functions import FUNCTIONS, cosine_and_sine
from linkages.kernel.code.instructions import DOUBLE, INTEGER, TRUTH, PhiLoop
from linkages.kernel.code.operands import Bool, Real, UniformInt, fma, maximum, minimum, select
from linkages.kernel.code.procedure import Procedure
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
    build_block,
)
from linkages.kernel.differentiation import CLOSE, MOST_ITERATIONS, MOST_TURNED, system_size
from linkages.kernel.scalars import Level, Scalar, ScalarGraph, reachable
from linkages.operations import ELEMENTARY


def solve(entries: Sequence[Real], size: int) -> list[Real]:
    """Solve a linear system, and its determinant, unrolled; rows are exchanged without branches."""
    rows = [[*entries[size * i : size * (i + 1)], entries[size * size + i]] for i in range(size)]
    sign: Real = entries[0].code.value(1.0)
    for k in range(size):
        for i in range(k + 1, size):
            larger = abs(rows[i][k]) > abs(rows[k][k])
            for j in range(k, size + 1):
                one, other = rows[k][j], rows[i][j]
                rows[k][j] = select(larger, other, one)
                rows[i][j] = select(larger, one, other)
            sign = select(larger, -sign, sign)
        for i in range(k + 1, size):
            factor = -(rows[i][k] / rows[k][k])
            for j in range(k + 1, size + 1):
                rows[i][j] = fma(factor, rows[k][j], rows[i][j])
    solution: dict[int, Real] = {}
    for k in reversed(range(size)):
        rest = rows[k][size]
        for j in range(k + 1, size):
            rest = fma(-rows[k][j], solution[j], rest)
        solution[k] = rest / rows[k][k]
    determinant = sign
    for k in range(size):
        determinant = determinant * rows[k][k]
    return [*(solution[k] for k in range(size)), determinant]


SPLINE = "spline"
"""Name of the function that interpolates tables, see `linkages.kernel.code.writer`."""

MANY = 1000
"""Statements up to which a routine is one function."""

LONGEST = 1000
"""Instructions from which on a longer one is continued in another function."""

FRAME = "%frame"
"""Array through which values pass from one piece of a routine to later ones."""

Values: TypeAlias = dict[int | str, Real | list[Real]]
"""Number of a node, or name of an iteration → its value, or all that it has."""


def triple_of(code: Procedure) -> str:
    """Type of what it returns: value, slope and curvature."""
    return "{" + ", ".join([code.number] * 3) + "}"


@dataclass
class Earlier:
    """What an earlier piece of a routine computed."""

    values: Real | list[Real]
    store: Callable[[str, str, int], None]  # writes a store behind them
    slot: int | None = None  # of the first in the frame; None before a later piece needs them


class Writer:
    """Writes the statements of a block; `values` has those of nodes by number, or lists."""

    def __init__(
        self,
        block: StatementBlock,
        code: Procedure,
        values: Values | None = None,
    ) -> None:
        self._block = block
        self._code = code
        self._values: Values = {} if values is None else values
        self._stores: dict[int | str, Callable[[str, str, int], None]] = {}
        self._earlier: dict[int | str, Earlier] = {}
        self.carried = 0  # numbers that pass from a piece to later ones
        self._turned: dict[int, tuple[Real, Real]] = {}
        self._entries: dict[Entry, Real] = {}

    def write(self) -> None:
        """Write all statements."""
        for statement in self._block.statements:
            self._write(statement)

    def write_pieces(self, begin: Callable[[], Procedure]) -> list[Procedure]:
        """Write all statements into pieces of bounded length; one alone where they are few.

        A value that a later piece needs passes through an entry of the array ``frame``.
        """
        pieces, longest = [self._code], LONGEST if len(self._block.statements) > MANY else math.inf
        for statement in self._block.statements:
            if self._code.length > longest:
                for key, store in self._stores.items():
                    self._earlier[key] = Earlier(self._values[key], store)
                for known in (self._values, self._stores, self._turned, self._entries):
                    known.clear()
                self._code = begin()
                self._code.resume()
                pieces.append(self._code)
            self._write(statement)
            if isinstance(statement, Assign):
                self._stores[statement.node.index] = self._code.room_for_stores()
            elif isinstance(statement, Iterate):
                self._stores[statement.name] = self._code.room_for_stores()
        return pieces

    def _known(self, key: int | str) -> Real | list[Real] | None:
        """A value that has been written, maybe in an earlier piece."""
        earlier = self._earlier.get(key)
        if earlier is not None and key not in self._values:
            several = isinstance(earlier.values, list)
            values = earlier.values if isinstance(earlier.values, list) else [earlier.values]
            if earlier.slot is None:
                earlier.slot = self.carried
                self.carried += len(values)
                for k, value in enumerate(values, earlier.slot):
                    earlier.store(value.text, FRAME, k)
            places = range(earlier.slot, earlier.slot + len(values))
            loaded = [Real(self._code, self._code.load(FRAME, place)) for place in places]
            self._values[key] = loaded if several else loaded[0]
        return self._values.get(key)

    def _write(self, statement: Statement) -> None:
        match statement:
            case Heading():
                pass  # for readers; nobody reads this
            case Assign(_, node):
                self._values[node.index] = self._operation(node)
            case Store(entry, node):
                self._code.store(self.value(node).text, f"%{entry.array}", entry.offset)
            case Check(node, status):
                self._code.require((self.value(node) >= 0.0).text, status)
            case Iterate():
                self._iterate(statement)
            case _:
                assert_never(statement)

    def value(self, node: Scalar) -> Real:
        """A node as an operand."""
        if node.constant is not None:
            return Real(self._code, self._code.constant(node.constant))
        result = self._known(node.index)
        if result is None:
            place = self._block.places.get(node.index)
            if isinstance(place, Entry):
                return self._entry(place)
            result = self._operation(node)  # part of the expression that uses it
        assert isinstance(result, Real)
        return result

    def _entry(self, entry: Entry) -> Real:
        if entry not in self._entries:
            alone = entry.array == "t" and self._code.lanes == 1
            text = "%t" if alone else self._code.load(f"%{entry.array}", entry.offset)
            self._entries[entry] = Real(self._code, text)
        return self._entries[entry]

    def _operation(self, node: Scalar) -> Real | list[Real]:
        code, operands = self._code, node.operands
        match node.operation:
            case "add":
                return self._sum(*operands)
            case "sub":
                return self._difference(*operands)
            case "neg":
                return -self.value(operands[0])
            case "sin" | "cos":
                return self._turn(operands[0])[node.operation == "sin"]
            case "tan":
                cosine, sine = self._turn(operands[0])
                return sine / cosine
            case "select":
                condition, first, second = map(self.value, operands)
                chosen: Real = select(condition >= 0.0, first, second)
                return chosen
            case "item":
                several, index = node.arguments
                return self._results(several)[index]
            case "solve":
                return solve([self.value(operand) for operand in operands], system_size(node))
            case "spline":
                time, start, count, periodic = node.arguments
                return self._interpolated(self.value(time), start.arguments[1], count, periodic)
            case name if name in FUNCTIONS:
                return FUNCTIONS[name](*map(self.value, operands))
            case name if (row := ELEMENTARY.get(name)) is not None:
                texts = [self.value(operand).text for operand in operands]
                if row.llvm is None:
                    return Real(code, code.call_library(name, *texts))
                if row.llvm.startswith("llvm."):
                    return Real(code, code.call_intrinsic(row.llvm, *texts))
                return Real(code, code.assign(f"{row.llvm} {code.number} {', '.join(texts)}"))
        raise ValueError(f"no instruction for the operation {node.operation!r}")

    def _turn(self, angle: Scalar) -> tuple[Real, Real]:
        """Cosine and sine of an angle, which are computed together."""
        if angle.index not in self._turned:
            self._turned[angle.index] = cosine_and_sine(self.value(angle))
        return self._turned[angle.index]

    def _results(self, several: Scalar) -> list[Real]:
        place = self._block.places[several.index]
        results = self._known(several.index)
        if results is None and isinstance(place, str):
            results = self._known(place)
        assert isinstance(results, list)
        return results

    def _product(self, node: Scalar) -> tuple[Real, Real] | None:
        """The factors of a product that nothing else uses."""
        inline = node.index not in self._values and node.index not in self._block.places
        if node.operation != "mul" or not inline:
            return None
        first, second = map(self.value, node.operands)
        return first, second

    def _sum(self, a: Scalar, b: Scalar) -> Real:
        for one, other in ((a, b), (b, a)):
            if factors := self._product(one):
                return fma(*factors, self.value(other))
        return self.value(a) + self.value(b)

    def _difference(self, a: Scalar, b: Scalar) -> Real:
        if factors := self._product(a):
            return fma(*factors, -self.value(b))
        if factors := self._product(b):
            return fma(-factors[0], factors[1], self.value(a))
        return self.value(a) - self.value(b)

    def _interpolated(self, time: Real, place: int, count: int, periodic: bool) -> list[Real]:
        code = self._code
        triple = triple_of(code)
        numbers = code.address("%p", place)
        result = code.assign(
            f"call {triple} @{SPLINE}({code.number} {time.text}, ptr {numbers}, {INTEGER} {count}, "
            f"{TRUTH} {str(periodic).lower()})"
        )
        parts = (code.assign(f"extractvalue {triple} {result}, {k}") for k in range(3))
        return [Real(code, part) for part in parts]

    def _iterate(self, loop: Iterate) -> None:
        """Newton's iteration; of several lanes, those that have come to an end stay there."""
        code, iteration = self._code, loop.iteration
        known = dict(self._values)
        known |= {node.index: self.value(node) for node in iteration.external}
        first = [self.value(start) for start in loop.starts]
        starts = [(INTEGER, "0"), *((code.number, start.text) for start in first)]
        if code.lanes > 1:
            starts.append((code.truth, (~Bool(code, code.sound)).text))
        turns = PhiLoop(code, starts)
        rounds, *values = turns.values[: 1 + len(first)]
        unknowns = [Real(code, value) for value in values]
        known |= {n.index: z for n, z in zip(iteration.iterates, unknowns, strict=True)}
        body = Writer(loop.body, code, known)
        body.write()
        updates = [body.value(update) for update in iteration.updates]
        moved = [z + update for z, update in zip(unknowns, updates, strict=True)]
        near = _within(updates, iteration.scales, CLOSE)
        if code.lanes > 1:
            ended = Bool(code, turns.values[-1])
            moved = [select(ended, z, end) for z, end in zip(unknowns, moved, strict=True)]
            near = ended | near
        count = code.assign(f"add {INTEGER} {rounds}, 1")
        fewer = code.assign(f"icmp ult {INTEGER} {count}, {MOST_ITERATIONS}")
        further = code.assign(f"and i1 {fewer}, {code.any_lane((~near).text)}")
        ends = [*moved, near] if code.lanes > 1 else moved
        turns.repeat(further, [count, *(end.text for end in ends)])
        code.require(near.text, loop.status)
        turned = [z - start for z, start in zip(moved, first, strict=True)]
        code.require(_within(turned, iteration.scales, MOST_TURNED).text, loop.status)
        self._values[loop.name] = moved


def _within(values: Sequence[Real], scales: Sequence[float], limit: float) -> Bool:
    """Whether no value exceeds a limit in units of its scale; false for nan."""
    near = [abs(v) <= limit * scale for v, scale in zip(values, scales, strict=True)]
    return reduce(and_, near)


def spline_function(code: Procedure) -> str:
    """Write the function of a time, knots, the number of intervals, and whether they repeat."""
    first, last = (Real(code, code.load("%p", place)) for place in (0, "%count"))
    time = _within_period(code, first, last)
    inner = minimum(maximum(time, first), last)
    low = _interval(code, inner)
    end = code.assign(f"add {INTEGER} %count, 1")
    coefficients = code.address("%p", end)
    place = code.int_operation("shl", low, code.int_constant(2))
    x = inner - Real(code, code.gather("%p", low))
    outside = time - inner
    further = [code.gather(code.address(coefficients, k), place) for k in range(4)]
    value, slope, curvature = _cubic(code, [x, outside, *(Real(code, each) for each in further)])
    results = (value, slope, select(outside != 0.0, 0.0, curvature))
    triple, kind = "poison", triple_of(code)
    for k, result in enumerate(results):
        triple = code.assign(f"insertvalue {kind} {triple}, {code.number} {result.text}, {k}")
    code.emit(f"ret {kind} {triple}")
    arguments = f"{code.number} %t, ptr %p, {INTEGER} %count, {TRUTH} %periodic"
    return f"{kind} @{SPLINE}({arguments})"


def _within_period(code: Procedure, first: Real, last: Real) -> Real:
    """The time, or where it stands in its period if there is one.

    It is exact, but for a negative time in the period before the first.
    """
    span = last - first
    past = Real(code, "%t") - first
    quotient = past / span
    periods = Real(code, code.call_intrinsic("llvm.floor", quotient.text))
    rest = fma(-periods, span, past)
    rest = select(rest < 0.0, rest + span, rest)  # the quotient was rounded up
    inside = (first + rest).text
    result = f"select {TRUTH} %periodic, {code.number} {inside}, {code.number} %t"
    return Real(code, code.assign(result))


def _interval(code: Procedure, inner: Real) -> str:
    """Number of the interval of a time, by as many bisections as the longest lane needs."""
    search = PhiLoop(
        code, [(code.integer, code.int_constant(0)), (code.integer, code.broadcast_int("%count"))]
    )
    low, high = search.values
    middle = code.int_operation("lshr", code.int_operation("add", low, high), code.int_constant(1))
    above = (Real(code, code.gather("%p", middle)) <= inner).text
    ends = (
        code.select(above, middle, low, code.integer),
        code.select(above, high, middle, code.integer),
    )
    apart = code.int_operation("sub", ends[1], ends[0])
    wide = code.assign(f"icmp sgt {code.integer} {apart}, {code.int_constant(1)}")
    search.repeat(code.any_lane(wide), ends)
    return ends[0]


def _cubic(code: Procedure, values: Sequence[Real]) -> list[Real]:
    """The formula of `linkages.components.contributed.functions.cubic`."""
    graph = ScalarGraph()
    inputs = [graph.input("y", k, Level.STATE) for k in range(len(values))]
    results = cubic(*inputs)
    known: Values = {node.index: value for node, value in zip(inputs, values, strict=True)}
    block = build_block(reachable(results), {node.index: "" for node in inputs}, results)
    writer = Writer(block, code, known)
    writer.write()
    return [writer.value(item) for item in results]


def write_assembly(routines: Sequence[Routine], lanes: int = 1) -> str:
    """The text of a module with some functions, which are called through their addresses.

    One state has ``int64 routine(double t, double *array…)``; several lanes have
    ``void routine(double *t, double *array…, int64 *status)``, where all arguments consist of rows
    of W numbers.
    """
    module = Module(lanes)
    for routine in routines:
        module.add(routine)
    return module.text


class Module:
    """Functions for one state or several lanes, and signatures of what they call outside."""

    def __init__(self, lanes: int = 1, strides: Mapping[str, int] | None = None) -> None:
        self._form = lanes, strides
        self._texts: list[str] = []
        self.declared: dict[str, str] = {}

    def instructions(self) -> Procedure:
        """A body for a function, to be filled and then defined."""
        return Procedure(UniformInt, *self._form)

    def define(self, signature: str, code: Procedure) -> None:
        """Add a function, such as ``internal double @square(double %x)``."""
        if code.text.endswith(":\n"):  # behind what it returns
            code.emit("unreachable")
        self.declared |= code.declared
        self._texts.append(f"define {signature} {{\n{code.text}}}\n")

    def add(self, routine: Routine, internal: bool = False) -> None:
        """Add a routine; `internal` if only this module calls it."""
        code = self.instructions()
        writer = Writer(routine.block, code)
        pieces = writer.write_pieces(self.instructions)
        scalars = ("t",) if code.lanes == 1 else ()
        kinds = {a: "double" if a in scalars else "ptr" for a in routine.arguments}
        if code.lanes > 1:
            kinds["status"] = "ptr"
        kind = INTEGER if code.lanes == 1 else "void"
        given = ", ".join(f"{kind} %{name}" for name, kind in kinds.items())
        for piece in pieces:
            piece.end()
        if len(pieces) > 1:
            code = self.instructions()
            frame = code.alloca(writer.carried)
            for number, piece in enumerate(pieces):
                name = f"{routine.name}.{number}"
                self.define(f"internal {kind} @{name}({given}, ptr noalias {FRAME})", piece)
                call = f"call {kind} @{name}({given}, ptr {frame})"
                if code.lanes > 1:
                    code.emit(call)
                    continue
                status = code.assign(call)
                code.require(code.assign(f"icmp eq {INTEGER} {status}, 0"), status)
            code.emit("ret void" if code.lanes > 1 else f"ret {INTEGER} 0")
        result = ("internal " if internal else "") + kind
        self.define(f"{result} @{routine.name}({given})", code)

    @property
    def text(self) -> str:
        """All functions and declarations."""
        texts, declared = list(self._texts), dict(self.declared)
        if any(f"@{SPLINE}(" in text for text in texts):
            code = self.instructions()
            texts.append(f"define internal {spline_function(code)} {{\n{code.text}}}\n")
            declared |= code.declared
        return "\n".join([*texts, *(f"declare {declared[name]}" for name in sorted(declared))])


def call_routine(code: Procedure, routine: Routine, given: Mapping[str, str]) -> str:
    """Write a call of a routine that has been added to the same module; returns its statuses."""
    operands = []
    for name in routine.arguments:
        kind, operand = "ptr", given[name]
        if name == "t":
            kind, operand = _passed(code, operand)
        operands.append(f"{kind} {operand}")
    if code.lanes == 1:
        return code.assign(f"call {INTEGER} @{routine.name}({', '.join(operands)})")
    status = code.alloca(1)
    code.emit(f"call void @{routine.name}({', '.join([*operands, f'ptr {status}'])})")
    return code.assign(f"load {code.integer}, ptr {status}, align 8")


def _passed(code: Procedure, time: str) -> tuple[str, str]:
    """Times as an argument: one is a number, several are a row."""
    if code.lanes == 1:
        return DOUBLE, time
    row = code.alloca(1)
    code.store(time, row, 0)
    return "ptr", row
