"""What a kernel does, step by step, in no particular language.

An operand of a statement stands in a place (an entry of an array, or a variable), or it is part of
the expression that uses it; so a backend writes expressions from a node down to what has a place.
`linkages.kernel.code.writer` writes text that is compiled, `linkages.kernel.code.languages` text
that people read.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

from linkages.kernel.differentiation import SEVERAL, Iteration
from linkages.kernel.scalars import Scalar

DEEPEST = 40
"""Operations nested in one expression: languages have limits (Python 200 pairs of parentheses)."""


class Entry(NamedTuple):
    """An entry of an array; the array ``"t"`` is the time, a number."""

    array: str
    offset: int


Place: TypeAlias = Entry | str
"""Where a value stands: an entry of an array, or the variable of this name."""


class Heading(NamedTuple):
    """What the statements that follow are about."""

    title: str


class Assign(NamedTuple):
    """A variable gets the value of a node, or all results of one of `SEVERAL`."""

    name: str
    node: Scalar


class Check(NamedTuple):
    """A value must not be negative or nan; otherwise the routine ends with a status.

    Nothing before it is undone, and many states at once may go on and keep a mask.
    """

    node: Scalar
    status: int


class Store(NamedTuple):
    """An entry of an array gets the value of a node."""

    entry: Entry
    node: Scalar


class Iterate(NamedTuple):
    """Newton's iteration; the variable `name` gets its unknowns, as one of `SEVERAL`.

    The body computes updates that are added to the unknowns until all are small; where they never
    are, or the sum of them is too large, the routine ends with the status.
    """

    name: str
    unknowns: tuple[str, ...]
    starts: tuple[Scalar, ...]
    body: StatementBlock
    iteration: Iteration
    status: int


Statement: TypeAlias = Heading | Assign | Check | Iterate | Store


@dataclass(frozen=True)
class StatementBlock:
    """Statements in their order; by the number of a node, where its value stands in the end."""

    statements: tuple[Statement, ...]
    places: Mapping[int, Place]


@dataclass(frozen=True)
class Routine:
    """A function of a kernel, which returns 0, or the status of what ended it early."""

    name: str
    doc: str
    arguments: Mapping[str, int]  # array → number of its entries; the time ``"t"`` is a number
    block: StatementBlock  # what it does

    @property
    def written(self) -> set[str]:
        """Arrays of which entries are stored."""
        return {s.entry.array for s in self.block.statements if isinstance(s, Store)}


def build_block(
    nodes: Iterable[Scalar],
    places: Mapping[int, Place],
    roots: Iterable[Scalar] = (),
    checks: Mapping[int, int] | None = None,
    stores: Mapping[Entry, Scalar] | None = None,
    names: Collection[str] = (),
) -> StatementBlock:
    """The statements that compute some nodes; one that is used once is a part of what uses it."""
    stores, checks = stores or {}, checks or {}
    builder = _Builder(places, checks, names)
    builder.add(nodes, {root.index for root in (*roots, *stores.values())} | checks.keys())
    statements = (*builder.statements, *(Store(*entry) for entry in stores.items()))
    return StatementBlock(statements, builder.places)


class _Builder:
    def __init__(
        self, places: Mapping[int, Place], checks: Mapping[int, int], names: Collection[str]
    ) -> None:
        self.places = dict(places)
        self.statements: list[Statement] = []
        self._checks = checks
        self._names = set(names)
        self._depth: dict[int, int] = {}
        self._section = ""

    def add(self, nodes: Iterable[Scalar], kept: set[int]) -> None:
        nodes = [node for node in nodes if node.index not in self.places and node.operands]
        uses = Counter(o.index for node in nodes for o in node.operands)
        for node in nodes:
            depth = 1 + max(self._depth.get(o.index, 0) for o in node.operands)
            if node.operation == "newton":
                self._iterate(node, node.arguments[-1])
            elif (
                uses[node.index] > 1
                or node.index in kept
                or node.operation in SEVERAL
                or depth >= DEEPEST
            ):
                self._assign(node)
            else:
                self._depth[node.index] = depth

    def _assign(self, node: Scalar) -> None:
        if node.section and node.section != self._section:
            self._section = node.section
            self.statements.append(Heading(node.section))
        self.statements.append(Assign(self._named(node), node))
        if node.index in self._checks:
            self.statements.append(Check(node, self._checks[node.index]))

    def _iterate(self, node: Scalar, loop: Iteration) -> None:
        unknowns = tuple(f"z{loop.block}_{k}" for k in range(len(loop.iterates)))
        inside = {n.index: name for n, name in zip(loop.iterates, unknowns, strict=True)}
        body = build_block(loop.body, self.places | inside, loop.updates, names=self._names)
        starts, name = node.operands[: len(unknowns)], self._named(node)
        self.statements.append(Heading(f"block {loop.block}: Newton's iteration"))
        self.statements.append(Iterate(name, unknowns, starts, body, loop, 1 + loop.block))

    def _named(self, node: Scalar) -> str:
        name = node.label or f"v{node.index}"
        if name in self._names:
            name = f"{name}_{node.index}"
        self._names.add(name)
        self.places[node.index] = name
        return name
