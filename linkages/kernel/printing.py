"""Prints a graph of scalar operations as readable Python assignments."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping

from linkages.kernel.scalars import SEVERAL, Scalar
from linkages.kernel.several import CLOSE, MOST_ITERATIONS, MOST_TURNED, Iteration

_INFIX = {"add": ("+", 1), "sub": ("-", 1), "mul": ("*", 2), "div": ("/", 2)}
DEEPEST = 40
"""Operations nested in one expression: Python reads no more than 200 pairs of parentheses."""

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
        self._depth: dict[int, int] = {}
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
        if node.operation == "newton":
            self._write_iteration(node)
            return
        text = self._expression(node)
        depth = 1 + max((self._depth.get(o.index, 0) for o in node.operands), default=0)
        assign = assign or node.operation in SEVERAL or depth >= DEEPEST
        self._depth[node.index] = 0 if assign else depth
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

    def _write_iteration(self, node: Scalar) -> None:
        """A loop that leaves the unknowns in a tuple, or returns the number of its block."""
        iteration = node.arguments[-1]
        names = [f"z{iteration.block}_{k}" for k in range(len(iteration.iterates))]
        first = [self.text(operand) for operand in node.operands[: len(names)]]
        inner = {**{i: text for i, (text, _) in self._text.items()}}
        inner |= {n.index: name for n, name in zip(iteration.iterates, names, strict=True)}
        body = Statements(iteration.body, iteration.updates, inner)
        self.lines += ["", f"# block {iteration.block}: Newton's iteration"]
        self.lines += [f"{name} = {text}" for name, text in zip(names, first, strict=True)]
        self.lines.append(f"for _ in range({MOST_ITERATIONS}):")
        updates = [f"d{iteration.block}_{k}" for k in range(len(names))]
        lines = [*body.lines]
        lines += [f"{d} = {body.text(u)}" for d, u in zip(updates, iteration.updates, strict=True)]
        lines += [f"{name} += {d}" for name, d in zip(names, updates, strict=True)]
        lines += [f"if {_within(updates, iteration, CLOSE)}:", "    break"]
        self.lines += [f"    {line}" if line else "" for line in lines]
        failed = f"return {1 + iteration.block}"
        self.lines += ["else:", f"    {failed}"]
        moved = [f"{name} - {text}" for name, text in zip(names, first, strict=True)]
        self.lines += [f"if not ({_within(moved, iteration, MOST_TURNED)}):", f"    {failed}"]
        name = self._name(node)
        self.lines.append(f"{name} = ({', '.join(names)},)")
        self._text[node.index] = (name, _ATOM)

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
        if node.operation == "item":
            several, index = node.arguments
            return f"{self.text(several)}[{index}]", _ATOM
        arguments = [self._expression(operand) for operand in node.operands]
        if node.operation == "neg":
            return f"-{self._grouped(arguments[0], _NEGATION)}", _NEGATION
        texts = [text for text, _ in arguments]
        if node.operation == "select":
            condition, first, second = texts
            return f"({first} if {condition} >= 0.0 else {second})", _ATOM
        if node.operation == "spline":
            _, start, count, periodic = node.arguments
            texts = [texts[0], "p", str(start.arguments[1]), str(count), str(periodic)]
        return f"{function_name(node)}({', '.join(texts)})", _ATOM

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


def _within(values: list[str], iteration: Iteration, limit: float) -> str:
    """A condition that no value exceeds a limit in units of its scale; false for nan."""
    bounds = [limit * scale for scale in iteration.scales]
    pairs = zip(values, bounds, strict=True)
    return " and ".join(f"abs({value}) <= {bound!r}" for value, bound in pairs)


def function_name(node: Scalar) -> str:
    """What a function is called in generated code."""
    return f"solve{_size(node)}" if node.operation == "solve" else node.operation


def _size(node: Scalar) -> int:
    """Size of the linear system of a ``"solve"``, from its number of operands n² + n."""
    return int(len(node.operands) ** 0.5)


def write_functions(nodes: Iterable[Scalar]) -> str:
    """The functions that the statements of some nodes call."""
    nodes = list(nodes)
    inner = [n for node in nodes if node.operation == "newton" for n in node.arguments[-1].body]
    found = [n for n in (*nodes, *inner) if n.operation in ("solve", "spline")]
    sizes = sorted({_size(node) for node in found if node.operation == "solve"})
    parts = [_solver(size) for size in sizes]
    if any(node.operation == "spline" for node in found):
        parts.append(_SPLINE)
    return "".join(parts)


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
    return "\n\n@njit(**_inline)\n" + "\n".join(lines) + "\n"


_SPLINE = '''

@njit(**_inline)
def spline(t, p, place, count, periodic):
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
    c = place + count + 1 + 4 * low
    x = inner - p[place + low]
    slope = p[c + 2] + x * (2.0 * p[c + 1] + x * 3.0 * p[c])
    outside = t - inner
    curvature = 2.0 * p[c + 1] + 6.0 * p[c] * x if outside == 0.0 else 0.0
    value = p[c + 3] + x * (p[c + 2] + x * (p[c + 1] + x * p[c])) + outside * slope
    return value, slope, curvature
'''
