"""Graph of scalar operations: what a kernel computes, before it is compiled or evaluated.

Equal operations on equal arguments are one node, exact zeros and ones are folded away, and each
node knows what it depends on: nothing, parameters, time or the state.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from enum import IntEnum
from threading import Lock
from typing import TYPE_CHECKING

from linkages.operations import ELEMENTARY, value_of

if TYPE_CHECKING:
    from linkages.kernel.differentiation import Iteration

_SECTION: ContextVar[str] = ContextVar("section", default="")


@contextmanager
def section(title: str) -> Iterator[None]:
    """Nodes that are new within it stand under a heading of generated code; also a decorator."""
    token = _SECTION.set(title)
    try:
        yield
    finally:
        _SECTION.reset(token)


class Level(IntEnum):
    """What a value depends on; a node has the highest level among its arguments."""

    CONSTANT = 0
    PARAMETERS = 1
    TIME = 2
    STATE = 3


class Scalar:
    """One node of a `ScalarGraph`; supports the arithmetic operators.

    `operation` is ``"constant"`` (its argument is the value), ``"input"`` (name and index),
    ``"item"``, which picks one of several results, or a row of `linkages.operations.ELEMENTARY` or
    of `linkages.kernel.differentiation.SEVERAL`. Plain numbers and descriptions follow argument
    nodes.
    """

    __slots__ = (
        "arguments", "constant", "graph", "index", "label", "level", "operands", "operation",
        "section",
    )  # fmt: skip

    def __init__(
        self, graph: ScalarGraph, operation: str, arguments: tuple, level: Level, index: int
    ) -> None:
        self.graph = graph
        self.operation = operation
        self.arguments = arguments
        self.constant: float | None = arguments[0] if operation == "constant" else None
        self.operands = tuple(a for a in arguments if isinstance(a, Scalar))
        self.level = level
        self.index = index
        self.label: str | None = None
        self.section = _SECTION.get()

    def __add__(self, other: Scalar | float) -> Scalar:
        return self.graph.add(self, self.graph.lift(other))

    __radd__ = __add__  # a sum is one node in either order

    def __sub__(self, other: Scalar | float) -> Scalar:
        return self.graph.subtract(self, self.graph.lift(other))

    def __rsub__(self, other: float) -> Scalar:
        return self.graph.subtract(self.graph.lift(other), self)

    def __mul__(self, other: Scalar | float) -> Scalar:
        return self.graph.multiply(self, self.graph.lift(other))

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar | float) -> Scalar:
        return self.graph.divide(self, self.graph.lift(other))

    def __rtruediv__(self, other: float) -> Scalar:
        return self.graph.divide(self.graph.lift(other), self)

    def __neg__(self) -> Scalar:
        return self.graph.negate(self)

    def __repr__(self) -> str:
        return f"<{self.label or self.index}: {self.operation}>"


class ScalarGraph:
    """Creates nodes and keeps each only once."""

    def __init__(self) -> None:
        self.nodes: list[Scalar] = []
        self._known: dict[tuple, Scalar] = {}
        self._making = Lock()
        self.zero = self.number(0.0)
        self.one = self.number(1.0)

    def _node(self, operation: str, arguments: tuple, level: Level) -> Scalar:
        identity = tuple(a.index if isinstance(a, Scalar) else a for a in arguments)
        key = (operation, *identity)
        node = self._known.get(key)
        if node is not None:
            return node
        with self._making:  # threads share the equations of a structure
            if key not in self._known:
                node = Scalar(self, operation, arguments, level, len(self.nodes))
                self.nodes.append(node)
                self._known[key] = node
            return self._known[key]

    def _operation(self, operation: str, *arguments: object) -> Scalar:
        # what cannot be folded, such as a system of constants, is computed with the parameters
        levels = (a.level for a in arguments if isinstance(a, Scalar))
        return self._node(operation, arguments, max(Level.PARAMETERS, *levels))

    def number(self, value: float) -> Scalar:
        """A constant; −0.0 counts as 0.0."""
        return self._node("constant", (float(value) + 0.0,), Level.CONSTANT)

    def _folded(self, value: float, operation: str, *arguments: Scalar) -> Scalar:
        """A constant, or the operation itself where it is not finite: no text stands for that."""
        return (
            self.number(value) if math.isfinite(value) else self._operation(operation, *arguments)
        )

    def lift(self, value: Scalar | float) -> Scalar:
        """A node for a plain number; nodes stay as they are."""
        return value if isinstance(value, Scalar) else self.number(value)

    def input(self, name: str, index: int, level: Level) -> Scalar:
        """Entry `index` of the kernel argument `name`."""
        return self._node("input", (name, index), level)

    def add(self, a: Scalar, b: Scalar) -> Scalar:
        """The sum a + b."""
        if a.constant == 0.0:
            return b
        if b.constant == 0.0:
            return a
        if a.constant is not None and b.constant is not None:
            return self._folded(a.constant + b.constant, "add", a, b)
        if b.operation == "neg":
            return self.subtract(a, b.arguments[0])
        if a.operation == "neg":
            return self.subtract(b, a.arguments[0])
        return self._operation("add", *sorted((a, b), key=lambda node: node.index))

    def subtract(self, a: Scalar, b: Scalar) -> Scalar:
        """The difference a − b."""
        if b.constant == 0.0:
            return a
        if a is b:
            return self.zero
        if a.constant == 0.0:
            return self.negate(b)
        if a.constant is not None and b.constant is not None:
            return self._folded(a.constant - b.constant, "sub", a, b)
        if b.operation == "neg":
            return self.add(a, b.arguments[0])
        if a.operation == "neg":
            return self.negate(self.add(a.arguments[0], b))
        return self._operation("sub", a, b)

    def multiply(self, a: Scalar, b: Scalar) -> Scalar:
        """The product a·b."""
        if a.constant is not None and b.constant is not None:
            return self._folded(a.constant * b.constant, "mul", a, b)
        for x, y in ((a, b), (b, a)):
            if x.constant == 0.0:
                return self.zero
            if x.constant == 1.0:
                return y
            if x.constant == -1.0:
                return self.negate(y)
        if a.operation == "neg":
            return self.negate(self.multiply(a.arguments[0], b))
        if b.operation == "neg":
            return self.negate(self.multiply(a, b.arguments[0]))
        return self._operation("mul", *sorted((a, b), key=lambda node: node.index))

    def divide(self, a: Scalar, b: Scalar) -> Scalar:
        """The quotient a/b."""
        if a.constant == 0.0:
            return self.zero
        if b.constant == 1.0:
            return a
        if a.constant is not None and b.constant:
            return self._folded(a.constant / b.constant, "div", a, b)
        if a.operation == "neg":
            return self.negate(self.divide(a.arguments[0], b))
        return self._operation("div", a, b)

    def negate(self, a: Scalar) -> Scalar:
        """The opposite −a."""
        if a.constant is not None:
            return self.number(-a.constant)
        if a.operation == "neg":
            return a.arguments[0]
        if a.operation == "sub":
            return self._operation("sub", a.arguments[1], a.arguments[0])
        return self._operation("neg", a)

    def apply(self, name: str, *operands: Scalar | float) -> Scalar:
        """An elementary operation out of `linkages.operations`, folded where it can be."""
        if name not in ELEMENTARY:
            raise ValueError(f"no elementary operation {name!r}")
        nodes = [self.lift(operand) for operand in operands]
        if name in _FOLDED:
            return _FOLDED[name](self, *nodes)
        constants = [node.constant for node in nodes if node.constant is not None]
        if len(constants) < len(nodes):
            return self._operation(name, *nodes)
        try:
            value = value_of(name, *constants)
        except (ValueError, ArithmeticError):
            value = math.nan
        return self._folded(value, name, *nodes)

    def sqrt(self, a: Scalar) -> Scalar:
        """The square root."""
        return self.apply("sqrt", a)

    def sin(self, a: Scalar) -> Scalar:
        """The sine of an angle in radians."""
        return self.apply("sin", a)

    def cos(self, a: Scalar) -> Scalar:
        """The cosine of an angle in radians."""
        return self.apply("cos", a)

    def select(self, condition: Scalar, first: Scalar, second: Scalar) -> Scalar:
        """The first value where the condition is not negative, otherwise the second."""
        if first is second:
            return first
        if condition.constant is not None:
            return first if condition.constant >= 0.0 else second
        return self._operation("select", condition, first, second)

    def solve(self, matrix: Sequence[Sequence[Scalar]], right: Sequence[Scalar]) -> list[Scalar]:
        """The solution of a square linear system, by elimination with row exchanges."""
        solution = self._operation("solve", *(a for row in matrix for a in row), *right)
        return [self.item(solution, index) for index in range(len(right))]

    def determinant(self, matrix: Sequence[Sequence[Scalar]]) -> Scalar:
        """The determinant of a square matrix."""
        right = [self.zero] * len(matrix)
        solution = self._operation("solve", *(a for row in matrix for a in row), *right)
        return self.item(solution, len(matrix))

    def newton(self, iteration: Iteration, start: Sequence[Scalar]) -> list[Scalar]:
        """The fixed point of a Newton iteration from given values."""
        needed = (*start, *iteration.external)
        solution = self._operation("newton", *needed, iteration)
        return [self.item(solution, index) for index in range(len(start))]

    def spline(self, time: Scalar, place: int, count: int, periodic: bool) -> list[Scalar]:
        """Value, first and second derivative of a piecewise cubic whose numbers are parameters."""
        first = self.input("p", place, Level.PARAMETERS)
        return self.spline_from(time, first, count, periodic)

    def spline_from(self, time: Scalar, first: Scalar, count: int, periodic: bool) -> list[Scalar]:
        """The same, with the first of its numbers as an input of any array."""
        value = self._operation("spline", time, first, count, periodic)
        return [self.item(value, order) for order in range(3)]

    def item(self, several: Scalar, index: int) -> Scalar:
        """One of the results of an operation that has several."""
        return self._node("item", (several, index), several.level)

    def total(self, terms: Iterable[Scalar]) -> Scalar:
        """The sum of all terms, from the first to the last."""
        result = self.zero
        for term in terms:
            result = result + term
        return result


_FOLDED: dict[str, Callable[..., Scalar]] = {
    "add": ScalarGraph.add,
    "sub": ScalarGraph.subtract,
    "mul": ScalarGraph.multiply,
    "div": ScalarGraph.divide,
    "neg": ScalarGraph.negate,
    "select": ScalarGraph.select,
}
"""Operations that are folded by more than computing with constants."""


def reachable(roots: Iterable[Scalar]) -> list[Scalar]:
    """All nodes that the roots need, in an order in which they can be computed."""
    result: set[int] = set()
    stack = list(roots)
    nodes: list[Scalar] = []
    while stack:
        node = stack.pop()
        if node.index in result:
            continue
        result.add(node.index)
        nodes.append(node)
        stack.extend(node.operands)
    return sorted(nodes, key=lambda node: node.index)


@dataclass(frozen=True)
class Vector:
    """A vector in the plane."""

    x: Scalar
    y: Scalar

    def __add__(self, other: Vector) -> Vector:
        return Vector(self.x + other.x, self.y + other.y)

    def __sub__(self, other: Vector) -> Vector:
        return Vector(self.x - other.x, self.y - other.y)

    def __neg__(self) -> Vector:
        return Vector(-self.x, -self.y)

    def __mul__(self, factor: Scalar | float) -> Vector:
        return Vector(self.x * factor, self.y * factor)

    def dot(self, other: Vector) -> Scalar:
        """Scalar product."""
        return self.x * other.x + self.y * other.y

    def cross(self, other: Vector) -> Scalar:
        """The third component of the vector product."""
        return self.x * other.y - self.y * other.x

    @property
    def turned(self) -> Vector:
        """The vector turned by +90°."""
        return Vector(-self.y, self.x)

    @property
    def square(self) -> Scalar:
        """Squared length."""
        return self.dot(self)

    def times(self, other: Vector) -> Vector:
        """Product as complex numbers: turned by the angle of `other`, stretched by its length."""
        return Vector(self.x * other.x - self.y * other.y, self.y * other.x + self.x * other.y)

    def label(self, name: str) -> Vector:
        """Name both components in the generated kernel."""
        for node, suffix in ((self.x, "x"), (self.y, "y")):
            if node.label is None and node.operands:
                node.label = f"{name}{suffix}"
        return self


def components(vectors: Iterable[Vector]) -> list[Scalar]:
    """X and y of one vector after the other."""
    return [component for vector in vectors for component in (vector.x, vector.y)]
