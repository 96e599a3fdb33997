"""A graph of scalar operations: what a kernel computes, before it is printed or evaluated.

Nodes are shared (equal operations on equal arguments are one node), exact zeros and ones are
folded away, and each node knows what it depends on: nothing, parameters, time or the state.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from enum import IntEnum

import numpy as np


class Level(IntEnum):
    """What a value depends on; a node has the highest level among its arguments."""

    CONSTANT = 0
    PARAMETERS = 1
    TIME = 2
    STATE = 3


class Scalar:
    """One node of a `ScalarGraph`; supports the arithmetic operators.

    Attributes
    ----------
    operation
        ``"constant"``, ``"input"``, ``"add"``, ``"sub"``, ``"mul"``, ``"div"``, ``"neg"``,
        ``"sqrt"``, ``"sin"``, ``"cos"``, ``"atan2"``.
    arguments
        Argument nodes; for a constant its value, for an input its name and index.
    label
        Name that the printed kernel gives it, if any.
    """

    __slots__ = ("arguments", "graph", "index", "label", "level", "operation", "section")

    def __init__(
        self, graph: ScalarGraph, operation: str, arguments: tuple, level: Level, index: int
    ) -> None:
        self.graph = graph
        self.operation = operation
        self.arguments = arguments
        self.level = level
        self.index = index
        self.label: str | None = None
        self.section = graph.section

    @property
    def constant(self) -> float | None:
        """Its value if it is a constant."""
        return self.arguments[0] if self.operation == "constant" else None

    @property
    def operands(self) -> tuple[Scalar, ...]:
        """The nodes that it is computed from."""
        return () if self.operation in ("constant", "input") else self.arguments

    def __add__(self, other: Scalar | float) -> Scalar:
        return self.graph.add(self, self.graph.lift(other))

    def __radd__(self, other: float) -> Scalar:
        return self.graph.add(self.graph.lift(other), self)

    def __sub__(self, other: Scalar | float) -> Scalar:
        return self.graph.subtract(self, self.graph.lift(other))

    def __rsub__(self, other: float) -> Scalar:
        return self.graph.subtract(self.graph.lift(other), self)

    def __mul__(self, other: Scalar | float) -> Scalar:
        return self.graph.multiply(self, self.graph.lift(other))

    def __rmul__(self, other: float) -> Scalar:
        return self.graph.multiply(self.graph.lift(other), self)

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
        self.section = ""
        self._known: dict[tuple, Scalar] = {}
        self.zero = self.number(0.0)
        self.one = self.number(1.0)

    def _node(self, operation: str, arguments: tuple, level: Level) -> Scalar:
        identity = tuple(a.index if isinstance(a, Scalar) else a for a in arguments)
        key = (operation, *identity)
        node = self._known.get(key)
        if node is None:
            node = Scalar(self, operation, arguments, level, len(self.nodes))
            self.nodes.append(node)
            self._known[key] = node
        return node

    def _operation(self, operation: str, *arguments: Scalar) -> Scalar:
        return self._node(operation, arguments, max(a.level for a in arguments))

    def number(self, value: float) -> Scalar:
        """A constant; −0.0 counts as 0.0."""
        return self._node("constant", (float(value) + 0.0,), Level.CONSTANT)

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
            return self.number(a.constant + b.constant)
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
            return self.number(a.constant - b.constant)
        if b.operation == "neg":
            return self.add(a, b.arguments[0])
        if a.operation == "neg":
            return self.negate(self.add(a.arguments[0], b))
        return self._operation("sub", a, b)

    def multiply(self, a: Scalar, b: Scalar) -> Scalar:
        """The product a·b."""
        if a.constant is not None and b.constant is not None:
            return self.number(a.constant * b.constant)
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
            return self.number(a.constant / b.constant)
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

    def sqrt(self, a: Scalar) -> Scalar:
        """The square root."""
        return self._function("sqrt", a)

    def sin(self, a: Scalar) -> Scalar:
        """The sine of an angle in radians."""
        return self._function("sin", a)

    def cos(self, a: Scalar) -> Scalar:
        """The cosine of an angle in radians."""
        return self._function("cos", a)

    def _function(self, name: str, a: Scalar) -> Scalar:
        if a.constant is not None:
            return self.number(getattr(math, name)(a.constant))
        return self._operation(name, a)

    def atan2(self, y: Scalar, x: Scalar) -> Scalar:
        """The angle of the vector (x, y), in [−π, π]."""
        if x.constant is not None and y.constant is not None:
            return self.number(math.atan2(y.constant, x.constant))
        return self._operation("atan2", y, x)

    def total(self, terms: Iterable[Scalar]) -> Scalar:
        """The sum of all terms, from the first to the last."""
        result = self.zero
        for term in terms:
            result = result + term
        return result


def reachable(roots: Iterable[Scalar]) -> list[Scalar]:
    """All nodes that the roots need, in an order in which they can be computed."""
    found: set[int] = set()
    stack = list(roots)
    nodes: list[Scalar] = []
    while stack:
        node = stack.pop()
        if node.index in found:
            continue
        found.add(node.index)
        nodes.append(node)
        stack.extend(node.operands)
    return sorted(nodes, key=lambda node: node.index)


_NUMPY = {
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": np.divide,
    "neg": np.negative,
    "sqrt": np.sqrt,
    "sin": np.sin,
    "cos": np.cos,
    "atan2": np.arctan2,
}


class Evaluator:
    """Evaluates nodes with NumPy, for one state or for many at once.

    Intermediate values are dropped after their last use, so memory is that of the widest cut.

    Parameters
    ----------
    roots
        The nodes wanted.
    """

    def __init__(self, roots: Iterable[Scalar]) -> None:
        self._roots = tuple(roots)
        self._nodes = reachable(self._roots)
        kept = {root.index for root in self._roots}
        last = {o.index: node.index for node in self._nodes for o in node.operands}
        self._drop: dict[int, list[int]] = {}
        for argument, user in last.items():
            if argument not in kept:
                self._drop.setdefault(user, []).append(argument)

    def __call__(self, **inputs: np.ndarray) -> list[np.ndarray]:
        """Values of the roots.

        Parameters
        ----------
        inputs
            Input name → array whose first axis is the input's index; further axes broadcast.

        Returns
        -------
        One array per root. Where an argument of a square root is negative the value is nan.
        """
        values: dict[int, np.ndarray] = {}
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            for node in self._nodes:
                if node.operation == "constant":
                    values[node.index] = node.arguments[0]
                elif node.operation == "input":
                    name, index = node.arguments
                    values[node.index] = inputs[name][index]
                else:
                    arguments = [values[o.index] for o in node.arguments]
                    values[node.index] = _NUMPY[node.operation](*arguments)
                for index in self._drop.get(node.index, ()):
                    del values[index]
        return [np.asarray(values[root.index], dtype=float) for root in self._roots]
