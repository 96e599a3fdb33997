"""Prints a graph of scalar operations as readable Python assignments."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping

from linkages.kernel.scalars import Scalar

_INFIX = {"add": ("+", 1), "sub": ("-", 1), "mul": ("*", 2), "div": ("/", 2)}
_ATOM = 4
_NEGATION = 3


class Statements:
    """Straight-line code for some nodes, given what is known already.

    A node that is used once is written into the expression that uses it; the others get a
    variable, with its label if it has one.

    Parameters
    ----------
    nodes
        The nodes to compute, in an order in which they can be computed.
    roots
        Nodes that must end up in a variable of their own.
    known
        Node index → text that stands for it.
    checks
        Node index → lines to insert after its assignment, given its text.
    """

    def __init__(
        self,
        nodes: Iterable[Scalar],
        roots: Iterable[Scalar],
        known: Mapping[int, str],
        checks: Mapping[int, Callable[[str], list[str]]] | None = None,
    ) -> None:
        self._text: dict[int, tuple[str, int]] = {i: (text, _ATOM) for i, text in known.items()}
        self._used_names: set[str] = set()
        self._checks = checks or {}
        nodes = [node for node in nodes if node.index not in known]
        uses = Counter(o.index for node in nodes for o in node.operands)
        kept = {root.index for root in roots} | self._checks.keys()
        self.lines: list[str] = []
        self._section = ""
        for node in nodes:
            self._write(node, assign=uses[node.index] > 1 or node.index in kept)

    def text(self, node: Scalar) -> str:
        """The variable or expression that stands for a node."""
        return self._expression(node)[0]

    def _write(self, node: Scalar, assign: bool) -> None:
        text = self._expression(node)
        if not node.operands or not assign:
            self._text[node.index] = text
            return
        if node.section != self._section:
            self._section = node.section
            self.lines += ["", f"# {node.section}"]
        name = self._name(node)
        self.lines.append(f"{name} = {text[0]}")
        self._text[node.index] = (name, _ATOM)
        if node.index in self._checks:
            self.lines += self._checks[node.index](name)

    def _name(self, node: Scalar) -> str:
        name = node.label or f"v{node.index}"
        if name in self._used_names:
            name = f"{name}_{node.index}"
        self._used_names.add(name)
        return name

    def _expression(self, node: Scalar) -> tuple[str, int]:
        if node.index in self._text:
            return self._text[node.index]
        if node.constant is not None:
            return repr(node.constant), _ATOM if node.constant >= 0 else _NEGATION
        if node.operation in _INFIX:
            return self._infix(node)
        arguments = [self._expression(operand) for operand in node.operands]
        if node.operation == "neg":
            return f"-{self._grouped(arguments[0], _NEGATION)}", _NEGATION
        return f"{node.operation}({', '.join(text for text, _ in arguments)})", _ATOM

    def _infix(self, node: Scalar) -> tuple[str, int]:
        sign, strength = _INFIX[node.operation]
        left, right = (self._expression(operand) for operand in node.operands)
        # the right-hand side keeps its parentheses: floating-point operations do not associate
        return (
            f"{self._grouped(left, strength)} {sign} {self._grouped(right, strength + 1)}",
            strength,
        )

    @staticmethod
    def _grouped(text: tuple[str, int], strength: int) -> str:
        return text[0] if text[1] >= strength else f"({text[0]})"
