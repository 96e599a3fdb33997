"""Numbers of a definition as nodes of a graph: what components compute from them, to be printed."""

from __future__ import annotations

from typing import Any

from linkages.design.dual_numbers import FollowedNumber, value_of
from linkages.kernel.scalars import Scalar
from linkages.operations import COMPOSITE, ELEMENTARY


class TracedNumber(FollowedNumber):
    """A number with the node that says how it follows from those of the definition.

    Parameters
    ----------
    value
        As the definition has it.
    node
        The same of any numbers.
    conditions
        Gets what must not be negative for the same to follow from other numbers, where somebody
        compares them.
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
        value = float(ELEMENTARY[name].value(*map(value_of, operands)))
        return known.beside(value, known.node.graph.apply(name, *map(_node, operands)))

    @classmethod
    def at_least(cls, one: Any, other: Any) -> bool:
        """Compare values, and keep as a condition that the answer stays what it is."""
        known, found = _traced((one, other)), super().at_least(one, other)
        first, second = (known.node.graph.lift(_node(number)) for number in (one, other))
        known.conditions.append(first - second if found else second - first)
        return found

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
