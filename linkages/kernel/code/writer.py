"""Writes statements in LLVM's assembly language.

Operations keep the order of the graph; a product that is used by one sum alone becomes a fused
multiply-add with it. Nothing else is contracted or reordered, so that equal inputs give equal bits,
whatever the machine, its instruction set and the number of lanes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import assert_never

from linkages.kernel.code.functions import FUNCTIONS
from linkages.kernel.code.instructions import INTEGER, TRUTH, Instructions, PrintedLoop
from linkages.kernel.code.statements import (
    Assign,
    Check,
    Entry,
    Heading,
    Iterate,
    Statement,
    StatementBlock,
    Store,
)
from linkages.kernel.code.systems import solve
from linkages.kernel.code.trigonometry import cosine_and_sine
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.graph.several import CLOSE, MOST_ITERATIONS, MOST_TURNED, system_size
from linkages.operations import ELEMENTARY

SPLINE = "spline"
"""Name of the function that interpolates tables, see `linkages.kernel.code.splines`."""


def triple_of(code: Instructions) -> str:
    """Type of what it returns: value, slope and curvature."""
    return "{" + ", ".join([code.number] * 3) + "}"


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
        self,
        block: StatementBlock,
        code: Instructions,
        values: dict[int, str | list[str]] | None = None,
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
                sound = self._code.compare("oge", self.value(node), self._code.constant(0.0))
                self._code.require(sound, status)
            case Iterate():
                self._iterate(statement)
            case _:
                assert_never(statement)

    def value(self, node: Scalar) -> str:
        """A node as an operand."""
        if node.constant is not None:
            return self._code.constant(node.constant)
        found = self._values.get(node.index)
        if found is None:
            place = self._block.places.get(node.index)
            if isinstance(place, Entry):
                return self._entry(place)
            found = self._operation(node)  # part of the expression that uses it
        assert isinstance(found, str)
        return found

    def _entry(self, entry: Entry) -> str:
        if entry.array == "t" and self._code.lanes == 1:
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
                return self._turn(operands[0])[node.operation == "sin"]
            case "tan":
                cosine, sine = self._turn(operands[0])
                return code.divide(sine, cosine)
            case "select":
                condition, first, second = map(self.value, operands)
                sound = code.compare("oge", condition, code.constant(0.0))
                return code.select(sound, first, second)
            case "item":
                several, index = node.arguments
                return self._results(several)[index]
            case "solve":
                return solve(code, [self.value(o) for o in operands], system_size(node))
            case "spline":
                time, start, count, periodic = node.arguments
                return self._interpolated(self.value(time), start.arguments[1], count, periodic)
            case name if name in FUNCTIONS:
                return FUNCTIONS[name](code, *map(self.value, operands))
            case name if (row := ELEMENTARY.get(name)) is not None:
                values = [self.value(operand) for operand in operands]
                if row.llvm is None:
                    return code.library(name, *values)
                if row.llvm.startswith("llvm."):
                    return code.call(row.llvm, *values)
                return code.binary(row.llvm, *values)
        raise ValueError(f"no instruction for the operation {node.operation!r}")

    def _turn(self, angle: Scalar) -> tuple[str, str]:
        """Cosine and sine of an angle, which are computed together."""
        if angle.index not in self._turned:
            self._turned[angle.index] = cosine_and_sine(self._code, self.value(angle))
        return self._turned[angle.index]

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
        code = self._code
        triple = triple_of(code)
        numbers = code.address("%p", place)
        result = code.give(
            f"call {triple} @{SPLINE}({code.number} {time}, ptr {numbers}, {INTEGER} {count}, "
            f"{TRUTH} {str(periodic).lower()})"
        )
        return [code.give(f"extractvalue {triple} {result}, {k}") for k in range(3)]

    def _iterate(self, loop: Iterate) -> None:
        """Newton's iteration; of several lanes, those that have come to an end stay there."""
        code, iteration = self._code, loop.iteration
        known: dict[int, str | list[str]] = dict(self._values)
        known |= {node.index: self.value(node) for node in iteration.external}
        first = [self.value(start) for start in loop.starts]
        starts = [(INTEGER, "0"), *((code.number, start) for start in first)]
        if code.lanes > 1:
            starts.append((code.truth, code.opposite(code.sound)))
        turns = PrintedLoop(code, starts)
        rounds, *unknowns = turns.values[: 1 + len(first)]
        known |= {n.index: z for n, z in zip(iteration.iterates, unknowns, strict=True)}
        body = Writer(loop.body, code, known)
        body.write()
        updates = [body.value(update) for update in iteration.updates]
        moved = [code.add(z, update) for z, update in zip(unknowns, updates, strict=True)]
        near = _within(code, updates, iteration.scales, CLOSE)
        if code.lanes > 1:
            ended = turns.values[-1]
            moved = [code.select(ended, z, end) for z, end in zip(unknowns, moved, strict=True)]
            near = code.any_of(ended, near)
        count = code.give(f"add {INTEGER} {rounds}, 1")
        fewer = code.give(f"icmp ult {INTEGER} {count}, {MOST_ITERATIONS}")
        further = code.give(f"and i1 {fewer}, {code.in_any_lane(code.opposite(near))}")
        turns.repeat(further, [count, *moved, *([near] if code.lanes > 1 else [])])
        code.require(near, loop.status)
        turned = [code.subtract(z, start) for z, start in zip(moved, first, strict=True)]
        code.require(_within(code, turned, iteration.scales, MOST_TURNED), loop.status)
        self._loops[loop.name] = moved


def _within(
    code: Instructions, values: Sequence[str], scales: Sequence[float], limit: float
) -> str:
    """Whether no value exceeds a limit in units of its scale; false for nan."""
    pairs = zip(values, scales, strict=True)
    return code.all_of(
        [code.compare("ole", code.absolute(v), code.constant(limit * scale)) for v, scale in pairs]
    )
