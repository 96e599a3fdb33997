"""Positions, vector-loop closure and velocity coefficients, kept as symbols, which stay short."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import sympy as sp

from linkages.components.contributed.terms import Body, Parameter, Relation
from linkages.equations.expressions import (
    Polar,
    Symbols,
    Terms,
    collected,
    components,
    cross,
    derivative,
    in_frame,
    law_of,
)
from linkages.topology.assur_groups import Loop, Step
from linkages.topology.decomposition import leaders_first
from linkages.topology.topology import Topology


class Places:
    """Positions along the bodies that place each joint, and how bodies are turned."""

    def __init__(self, topology: Topology, symbols: Symbols) -> None:
        self._topology = topology
        self._mechanism = topology.mechanism
        self._symbols = symbols
        self._followed: dict[str, sp.Expr] = {}

    def _body(self, name: str) -> Body:
        return self._mechanism.bodies[name]

    def joint(self, label: str) -> Terms:
        """Position of a joint, or of the axis point of a slider."""
        steps, start = self._topology.path(label)
        anchor = self._symbols.pair(self._mechanism.anchors[start])
        return (*in_frame(sp.S.Zero, *anchor), *self.along(steps))

    def along(self, steps: Iterable[Step]) -> Terms:
        """Sum of the vectors along bodies."""
        return tuple(term for step in steps for term in self._step(step))

    def centre(self, name: str) -> Terms:
        """Position of a centre of mass; a slider's is its first joint."""
        body = self._body(name)
        first = next(iter(body.points))
        if body.guide is None:
            entry = self._topology.entry[name]
            start = self._mechanism.attachments[name][entry]
            return (*self.joint(entry), *self._within(name, start, body.centre))
        if body.guide.body is None:
            axis = body.axis
            return (*self.joint(axis), *self._step(Step(name, axis, first)))
        return self.joint(first)

    def orientation(self, name: str) -> sp.Expr:
        """The angle of a body's frame in radians; that of a guide up to whole turns."""
        body, guides = self._topology.turning(name)
        angle = sp.S.Zero if body is None else self.coordinate(body)
        for guide in reversed(guides):
            angle += self._angle(guide.angle, whole_turns=False)
        return angle

    def turning(self, name: str | None) -> sp.Expr:
        """Angular speed of a body (None: the ground)."""
        if name is None:
            return sp.S.Zero
        angle = self.orientation(name)
        return sp.Add(*(sp.diff(angle, q) * rate for q, rate in self._symbols.rates.items()))

    def coordinate(self, name: str) -> sp.Expr:
        """A body's own coordinate: its angle in radians, or its displacement in metres."""
        if name in self._topology.followers:
            for follower in leaders_first([name], self._topology.leaders, self._followed):
                self._followed[follower] = self._following(follower)
            return self._followed[name]
        return self._symbols.coordinates[name]

    def _following(self, name: str) -> sp.Expr:
        """It is offset + Σ ratio·q_other, or offset + f(Σ ratio·q_other)."""
        relation, turns = self._topology.followers[name], self._body(name).rotates
        offset = (self._angle if turns else self._symbols.parameter)(relation.offset)
        if relation.profile is None:
            return self._summed(relation) + offset
        return law_of(relation.profile, self._symbols, lambda _: self._summed(relation)) + offset

    def _summed(self, relation: Relation) -> sp.Expr:
        total = sp.S.Zero
        for other, ratio in relation.parts:
            factor = sp.S.One if ratio.value == 1.0 else self._symbols.parameter(ratio)
            total += factor * self.coordinate(other)
        return total

    def _angle(self, angle: Parameter, whole_turns: bool = True) -> sp.Expr:
        """A constant angle; exact multiples of 90° are structure, as a zero is elsewhere."""
        quarters = angle.value / (math.pi / 2)
        if quarters != round(quarters):
            return self._symbols.parameter(angle)
        count = round(quarters)
        return (count if whole_turns else count % 4) * sp.pi / 2

    def _step(self, step: Step) -> Terms:
        """Along a body; a slider's axis point lies at its first joint, less the displacement."""
        places, own = self._mechanism.attachments[step.body], self._body(step.body).axis
        slid: Terms = ()
        if own in (step.start, step.end):
            along = Polar(self.coordinate(step.body), self.orientation(step.body))
            slid = (along if step.start == own else -along,)
        origin = next(iter(places.values()))
        within = self._within(
            step.body, places.get(step.start, origin), places.get(step.end, origin)
        )
        return (*slid, *within)

    def _within(
        self, name: str, start: tuple[Parameter, Parameter], end: tuple[Parameter, Parameter]
    ) -> Terms:
        (x0, y0), (x, y) = self._symbols.pair(start), self._symbols.pair(end)
        return in_frame(self.orientation(name), x - x0, y - y0)


@dataclass(frozen=True)
class LoopEquation:
    """Two ways from the ground to the same place, as positive terms without what both share."""

    apex: str  # the joint at which the two sides meet, or the axis of a slider
    left: Terms
    right: Terms
    # The coordinates that this loop (with the others of its block) determines
    unknowns: tuple[sp.Symbol, ...]

    @property
    def terms(self) -> Terms:
        """Left minus right side: vectors that add up to zero."""
        return (*self.left, *(-term for term in self.right))

    @property
    def residual(self) -> tuple[sp.Expr, sp.Expr]:
        """The two scalar equations Φ, x then y, in metres."""
        return components(self.terms)


@dataclass(frozen=True)
class BlockEquations:
    """Loops that determine some coordinates together."""

    loops: tuple[LoopEquation, ...]  # two scalar equations each
    # The coordinates; fewer than there are equations if some of these are redundant
    unknowns: tuple[sp.Symbol, ...]

    @property
    def surplus(self) -> int:
        """Number of redundant equations."""
        return 2 * len(self.loops) - len(self.unknowns)


def closure(topology: Topology, symbols: Symbols, places: Places) -> tuple[BlockEquations, ...]:
    """One equation per independent loop, block by block in the order in which they are solved."""
    axes = {body.axis: f"the axis of {name}" for name, body in topology.mechanism.bodies.items()}
    result = []
    for block in topology.solved_blocks:
        unknowns = tuple(symbols.coordinates[name] for name in block.unknowns)
        loops = tuple(
            _loop_equation(loop, axes.get(loop.apex, loop.apex), unknowns, symbols, places)
            for loop in block.loops
        )
        result.append(BlockEquations(loops, unknowns))
    return tuple(result)


def _loop_equation(
    loop: Loop, apex: str, unknowns: Sequence[sp.Symbol], symbols: Symbols, places: Places
) -> LoopEquation:
    """Once around: from the ground through the loop, and from its other end back."""
    out = (*places.joint(loop.start), *places.along(loop.steps))
    back = places.joint(loop.end)
    around = collected((*out, *(-term for term in reversed(back))), symbols.coordinates.values())
    left = tuple(term for term in around if not _negative(term))
    right = tuple(-term for term in reversed(around) if _negative(term))
    if _first_body(right, symbols) < _first_body(left, symbols):
        left, right = right, left
    return LoopEquation(apex, left, right, tuple(unknowns))


def _negative(term: Polar) -> bool:
    return bool(term.length.could_extract_minus_sign())


def _first_body(terms: Terms, symbols: Symbols) -> int:
    """Place in the file of the body that comes first there."""
    order = {coordinate: i for i, coordinate in enumerate(symbols.coordinates.values())}
    used = {s for term in terms for s in term.length.free_symbols | term.angle.free_symbols}
    return min((order[s] for s in used if s in order), default=len(order))


Row = tuple[sp.Expr, ...]
Rows = dict[sp.Symbol, Row]


@dataclass(frozen=True)
class Definition:
    """A symbol and what it stands for."""

    symbol: sp.Symbol
    value: sp.Expr


@dataclass(frozen=True)
class SymbolicLinearSystem:
    """``matrix`` · K = ``right`` for the velocity coefficients of a block."""

    # K: a row for each unknown, a column for each generalised coordinate that moves them
    coefficients: sp.Matrix
    matrix: sp.Matrix  # Φ_z: a row for each scalar equation
    right: sp.Matrix  # −Φ_q, with earlier velocity coefficients
    # Number of redundant equations: those that follow from the others at positions where the loops
    # close
    surplus: int


@dataclass(frozen=True)
class BlockCoefficients:
    """The velocity coefficients of one block: formulas, or a linear system."""

    definitions: tuple[Definition, ...] = ()
    system: SymbolicLinearSystem | None = None


def solve_block(block: BlockEquations, known: Rows, symbols: Symbols) -> BlockCoefficients:
    """Velocity coefficients of a block from those of what comes before; adds them to `known`."""
    if len(block.loops) == 1 and len(block.unknowns) == 2:
        return BlockCoefficients(definitions=_by_cramer(block.loops[0], known, symbols))
    return BlockCoefficients(system=_linear_system(block, known, symbols))


def _by_cramer(loop: LoopEquation, known: Rows, symbols: Symbols) -> tuple[Definition, ...]:
    """With a and b the derivatives of the loop by its unknowns and w the one by what is known,
    K_a a + K_b b + w = 0 gives K_a = −(w × b)/(a × b).
    """  # noqa: D205
    first, second = loop.unknowns
    given = _given(loop, known)
    definitions: list[Definition] = []
    rows: Rows = {}
    for unknown, other in ((first, second), (second, first)):
        b = derivative(loop.terms, other)
        determinant = cross(derivative(loop.terms, unknown), b)
        values = [
            -sp.Add(*(known[w][i] * cross(terms, b) for w, terms in given.items())) / determinant
            for i in range(_count(known))
        ]
        result = [_named(value, i, unknown, symbols) for i, value in enumerate(values)]
        rows[unknown] = tuple(sp.S.Zero if d is None else d.symbol for d in result)
        definitions += [d for d in result if d is not None]
    known.update(rows)
    return tuple(definitions)


def _linear_system(
    block: BlockEquations, known: Rows, symbols: Symbols
) -> SymbolicLinearSystem | None:
    matrix: list[list[sp.Expr]] = []
    right: list[list[sp.Expr]] = []
    for loop in block.loops:
        columns = [components(derivative(loop.terms, unknown)) for unknown in block.unknowns]
        given = {w: components(terms) for w, terms in _given(loop, known).items()}
        for axis in (0, 1):
            matrix.append([column[axis] for column in columns])
            right.append(
                [
                    -sp.Add(*(known[w][i] * value[axis] for w, value in given.items()))
                    for i in range(_count(known))
                ]
            )
    moving = [i for i in range(_count(known)) if any(row[i] != 0 for row in right)]
    rows = []
    for unknown in block.unknowns:
        values = [_symbol(i, unknown, symbols) if i in moving else sp.S.Zero
                  for i in range(_count(known))]  # fmt: skip
        known[unknown] = tuple(values)
        rows.append([values[i] for i in moving])
    if not moving:
        return None
    return SymbolicLinearSystem(
        coefficients=sp.Matrix(rows),
        matrix=sp.Matrix(matrix),
        right=sp.Matrix([[row[i] for i in moving] for row in right]),
        surplus=block.surplus,
    )


def _given(loop: LoopEquation, known: Rows) -> dict[sp.Symbol, Terms]:
    return {w: terms for w in known if (terms := derivative(loop.terms, w))}


def _count(known: Rows) -> int:
    return len(next(iter(known.values()), ()))


def _named(value: sp.Expr, index: int, unknown: sp.Symbol, symbols: Symbols) -> Definition | None:
    if value == 0:
        return None
    return Definition(_symbol(index, unknown, symbols), sp.factor(value, deep=False))


def _symbol(index: int, unknown: sp.Symbol, symbols: Symbols) -> sp.Symbol:
    (body,) = symbols.notations[unknown].subscripts
    return symbols.define("K", body, str(index + 1))
