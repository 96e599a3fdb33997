"""What a kernel does, step by step, in no particular language.

A `Block` is a sequence of statements about nodes of a graph, and the places where values stand. An
operand of a statement stands in a place (an entry of an array, or a variable), or it is part of the
expression that uses it; so a backend writes expressions from a node down to what has a place.
`linkages.kernel.printing` is the backend that writes Python for Numba.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

from linkages.kernel.scalars import Scalar
from linkages.kernel.several import SEVERAL, Iteration

DEEPEST = 40
"""Operations nested in one expression: Python reads no more than 200 pairs of parentheses."""


class Entry(NamedTuple):
    """An entry of an array; the array ``"t"`` is the time, a number."""

    array: str
    place: int


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

    Nothing before it is undone, and nothing after it matters: many states at once may go on and
    keep a mask.
    """

    node: Scalar
    status: int


class Store(NamedTuple):
    """An entry of an array gets the value of a node."""

    entry: Entry
    node: Scalar


class Iterate(NamedTuple):
    """Newton's iteration; a variable gets its unknowns, one result after the other.

    Parameters
    ----------
    name
        Of the variable.
    unknowns
        Variables of the unknowns within the body.
    starts
        Where they start.
    body
        Computes the updates of `iteration`, which are added to the unknowns until all are small.
    iteration
        Updates, scales and the number of the block.
    """

    name: str
    unknowns: tuple[str, ...]
    starts: tuple[Scalar, ...]
    body: Block
    iteration: Iteration

    @property
    def status(self) -> int:
        """What the routine ends with where the iteration finds nothing, or too far away."""
        return 1 + self.iteration.block


Statement: TypeAlias = Heading | Assign | Check | Iterate | Store


@dataclass(frozen=True)
class Block:
    """Statements in the order in which they are carried out.

    Parameters
    ----------
    statements
        What is done.
    places
        Number of a node → where its value stands, before or after the statements.
    """

    statements: tuple[Statement, ...]
    places: Mapping[int, Place]


@dataclass(frozen=True)
class Routine:
    """A function of a kernel. It returns 0, or the status of what ended it early.

    Parameters
    ----------
    name, doc
        What it is called, and what it does.
    arguments
        Array → number of its entries; the time ``"t"`` is a number.
    block
        What it does.
    """

    name: str
    doc: str
    arguments: Mapping[str, int]
    block: Block


def build_block(
    nodes: Iterable[Scalar],
    places: Mapping[int, Place],
    roots: Iterable[Scalar] = (),
    checks: Mapping[int, int] | None = None,
    stores: Mapping[Entry, Scalar] | None = None,
    names: Collection[str] = (),
) -> Block:
    """The statements that compute some nodes.

    A node that is used once is part of the expression that uses it; the others get a variable, with
    their label if they have one.

    Parameters
    ----------
    nodes
        In an order in which they can be computed.
    places
        Number of a node → where its value stands already.
    roots
        Nodes that must end up in a variable of their own.
    checks
        Number of a node → status with which the routine ends if it is negative.
    stores
        What is stored at the end.
    names
        Variables that exist already.
    """
    stores = stores or {}
    builder = _Builder(places, checks or {}, names)
    builder.add(nodes, {root.index for root in (*roots, *stores.values())})
    statements = (*builder.statements, *(Store(*entry) for entry in stores.items()))
    return Block(statements, builder.places)


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
        kept = kept | self._checks.keys()
        for node in nodes:
            if node.operation == "newton":
                self._iterate(node)
                continue
            depth = 1 + max(self._depth.get(o.index, 0) for o in node.operands)
            named = uses[node.index] > 1 or node.index in kept or node.operation in SEVERAL
            if named or depth >= DEEPEST:
                self._assign(node)
            else:
                self._depth[node.index] = depth

    def _assign(self, node: Scalar) -> None:
        if node.section != self._section:
            self._section = node.section
            self.statements.append(Heading(node.section))
        self.statements.append(Assign(self._named(node), node))
        if node.index in self._checks:
            self.statements.append(Check(node, self._checks[node.index]))

    def _iterate(self, node: Scalar) -> None:
        iteration: Iteration = node.arguments[-1]
        unknowns = tuple(f"z{iteration.block}_{k}" for k in range(len(iteration.iterates)))
        inside = {n.index: name for n, name in zip(iteration.iterates, unknowns, strict=True)}
        body = build_block(
            iteration.body, self.places | inside, iteration.updates, names=self._names
        )
        starts = node.operands[: len(unknowns)]
        self.statements.append(Heading(f"block {iteration.block}: Newton's iteration"))
        self.statements.append(Iterate(self._named(node), unknowns, starts, body, iteration))

    def _named(self, node: Scalar) -> str:
        name = node.label or f"v{node.index}"
        if name in self._names:
            name = f"{name}_{node.index}"
        self._names.add(name)
        self.places[node.index] = name
        return name
