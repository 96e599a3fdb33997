"""How parameters of a kernel and its initial state follow from numbers of the definition file.

They are nodes of a graph: what components compute from numbers is recorded, to be printed.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import Any

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.mechanisms.registry import unit_at
from linkages.design.sensitivities import written_unit
from linkages.kernel.code.statements import Entry, Routine, build_block
from linkages.kernel.dual_numbers import FollowedNumber
from linkages.kernel.dual_numbers import value_of as number_of
from linkages.kernel.inputs import structure_key
from linkages.kernel.number_effects import (
    Number,
    initial_values,
    moved,
    tabulated,
    terms_with,
    value_of,
    written,
)
from linkages.kernel.scalars import Level, Scalar, ScalarGraph, reachable
from linkages.kernel.system import System
from linkages.operations import COMPOSITE, ELEMENTARY


class TracedNumber(FollowedNumber):
    """A number with the node that says how it follows from those of the definition.

    `value`: as the definition has it.
    `node`: the same of any numbers.
    `conditions`: gets what must not be negative for the same to follow from other numbers, where
    somebody compares them.
    """

    __slots__ = ("conditions", "node")

    def __init__(self, value: float, node: Scalar, conditions: list[Scalar]) -> None:
        self.value, self.node, self.conditions = value, node, conditions

    def __repr__(self) -> str:
        return f"TracedNumber({self.value!r}, {self.node!r})"

    @classmethod
    def applied(cls, name: str, *operands: Any) -> TracedNumber:
        """The same operation of nodes."""
        known = _traced(operands)
        value = float(ELEMENTARY[name].value(*map(number_of, operands)))
        return known.beside(value, known.node.graph.apply(name, *map(_node, operands)))

    @classmethod
    def at_least(cls, one: Any, other: Any) -> bool:
        """Compare values, and keep as a condition that the answer stays what it is."""
        known, result = _traced((one, other)), super().at_least(one, other)
        first, second = (known.node.graph.lift(_node(number)) for number in (one, other))
        known.conditions.append(first - second if result else second - first)
        return result

    def raised(self, exponent: float) -> TracedNumber:
        """A whole power by products, others by exponential and logarithm."""
        if exponent != int(exponent):
            return (self.log() * exponent).exp()
        graph = self.node.graph
        power = COMPOSITE["power"].expanded(graph.apply, self.node, int(exponent))
        return self.beside(self.value**exponent, graph.lift(power))

    def beside(self, value: float, node: Scalar) -> TracedNumber:
        """Another number that follows from the same definition."""
        return TracedNumber(value, node, self.conditions)


def _traced(operands: tuple[Any, ...]) -> TracedNumber:
    return next(number for number in operands if isinstance(number, TracedNumber))


def _node(number: Any) -> Scalar | float:
    return number.node if isinstance(number, TracedNumber) else float(number)


NUDGED = 1e-3
"""Relative change of a number that shows whether its value is structure, as a right angle is."""

REFUSED = -1
"""Status where other numbers do not lead to parameters in the same way."""


@dataclass(frozen=True)
class FileNumber:
    """A number of the definition file that a program may change.

    `value`, `unit`: in SI.
    `written`, `size`: the unit that the file has it in, and what one of that is in SI.
    """

    path: str  # dotted
    value: float
    unit: str
    written: str
    size: float


@dataclass(frozen=True)
class Feed:
    """What follows from numbers of a definition file."""

    numbers: tuple[FileNumber, ...]  # those that may change
    routine: Routine  # ``feed(numbers, p, y)``: fills parameters and the initial state


def feed_of(system: System, used: Collection[Scalar]) -> Feed:
    """How a kernel follows from numbers.

    Left out are numbers that are structure (zeros, right angles and ratios of one remove terms),
    those of tables, and those that nothing depends on.
    """
    mechanism = system.mechanism
    places = system.model.inputs.parameters
    live = {node.arguments[1] for node in used if node.arguments[0] == "p"}
    rows = {name: row for row, name in enumerate(system.layout.coordinates)}
    result: list[Number] = []
    for number in written(mechanism):
        if not _is_structure(mechanism, number):
            entries = _followed(mechanism, [number], places, rows).entries
            if any(entry.array == "y" or entry.offset in live for entry in entries):
                result.append(number)
    traced = _followed(mechanism, result, places, rows)
    sizes = {"numbers": len(result), "p": len(places), "y": 3 * len(rows)}
    nodes = reachable([*traced.entries.values(), *traced.conditions])
    inputs = {n.index: Entry(*n.arguments) for n in nodes if n.operation == "input"}
    checks = {node.index: REFUSED for node in traced.conditions if node.operands}
    block = build_block(nodes, inputs, checks=checks, stores=traced.entries)
    doc = "Parameters and initial state from numbers of the definition file."
    routine = Routine("feed", doc, sizes, block)
    return Feed(tuple(_file_number(mechanism, number) for number in result), routine)


def _file_number(mechanism: Mechanism, number: Number) -> FileNumber:
    unit = unit_at(mechanism.definition, number.path)
    value = value_of(mechanism, number)
    return FileNumber(number.path, value, unit, *written_unit(mechanism, number.path))


def _is_structure(mechanism: Mechanism, number: Number) -> bool:
    """Whether the equations would be others if the number were a little different."""

    def nudged(value: Any) -> float:
        return float(value) * (1.0 + NUDGED) if value else NUDGED

    own = mechanism.terms_of(mechanism.components[number.component])
    other = terms_with(mechanism, number.component, [(number, nudged)])
    return structure_key(own) != structure_key(other)


@dataclass(frozen=True)
class _Traced:
    entries: dict[Entry, Scalar]
    conditions: Sequence[Scalar]


def _followed(
    mechanism: Mechanism,
    numbers: Sequence[Number],
    places: Any,
    rows: dict[str, int],
) -> _Traced:
    """What follows from numbers, as nodes of their own graph, by where it is stored."""
    graph, conditions = ScalarGraph(), list[Scalar]()
    entries: dict[Entry, Scalar] = {}

    def traced(place: int) -> Callable[[Any], Any]:
        node = graph.input("numbers", place, Level.PARAMETERS)
        return lambda value: TracedNumber(float(value), node, conditions)

    for component in sorted({number.component for number in numbers}):
        own = [(n, traced(k)) for k, n in enumerate(numbers) if n.component == component]
        terms = terms_with(mechanism, component, own)
        if any(tabulated(terms)):  # their coefficients are not followed
            continue
        for path, value in moved(terms):
            if path in places and isinstance(value, TracedNumber):
                entries[Entry("p", places[path])] = value.node
        for name, position, rate in initial_values(terms):
            for first, value in ((0, position), (len(rows), rate)):
                if name in rows and isinstance(value, FollowedNumber):
                    assert isinstance(value, TracedNumber)
                    entries[Entry("y", first + rows[name])] = value.node
    return _Traced(entries, conditions)
