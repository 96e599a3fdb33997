"""Numbers of a definition as nodes of a graph: what components compute from them, to be printed."""

from __future__ import annotations

from typing import Any

from linkages.design.sensitivity.followed import FollowedNumber, value_of
from linkages.kernel.graph.scalars import Level, Scalar, ScalarGraph
from linkages.operations import COMPOSITE, ELEMENTARY


class Trace:
    """What is known of the numbers that are followed together.

    Attributes
    ----------
    graph
        Its inputs ``numbers`` are the numbers.
    conditions
        What must not be negative for the same to follow from other numbers, since somebody compared
        them.
    """

    def __init__(self) -> None:
        self.graph = ScalarGraph()
        self.conditions: list[Scalar] = []

    def number(self, place: int, value: float) -> TracedNumber:
        """A number of the definition by its place among all of them."""
        return TracedNumber(self, value, self.graph.input("numbers", place, Level.PARAMETERS))


class TracedNumber(FollowedNumber):
    """A number with the node that says how it follows from those of the definition."""

    __slots__ = ("node", "trace")

    def __init__(self, trace: Trace, value: float, node: Scalar) -> None:
        self.trace, self.value, self.node = trace, value, node

    def __repr__(self) -> str:
        return f"TracedNumber({self.value!r})"

    @classmethod
    def applied(cls, name: str, *operands: Any) -> TracedNumber:
        """The same operation of nodes."""
        trace = _trace(operands)
        value = float(ELEMENTARY[name].value(*map(value_of, operands)))
        return cls(trace, value, trace.graph.apply(name, *map(_node, operands)))

    @classmethod
    def at_least(cls, one: Any, other: Any) -> bool:
        """Compare values, and keep as a condition that the answer stays what it is."""
        trace, found = _trace((one, other)), super().at_least(one, other)
        first, second = (trace.graph.lift(_node(number)) for number in (one, other))
        trace.conditions.append(first - second if found else second - first)
        return found

    def raised(self, exponent: float) -> TracedNumber:
        """A whole power by products, others by exponential and logarithm."""
        if exponent != int(exponent):
            return (self.log() * exponent).exp()
        node = COMPOSITE["power"].expanded(self.trace.graph.apply, self.node, int(exponent))
        return TracedNumber(self.trace, self.value**exponent, self.trace.graph.lift(node))


def _trace(operands: tuple[Any, ...]) -> Trace:
    return next(number.trace for number in operands if isinstance(number, TracedNumber))


def _node(number: Any) -> Scalar | float:
    return number.node if isinstance(number, TracedNumber) else float(number)
