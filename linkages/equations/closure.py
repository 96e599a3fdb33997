"""Vector-loop closure Φ(q) = 0: one vector equation per independent loop (paper, Eq. 1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from linkages.equations.places import Places
from linkages.equations.polar import Polar, Terms, collected, components
from linkages.equations.symbols import Symbols
from linkages.topology.blocks import Loop
from linkages.topology.topology import Topology


@dataclass(frozen=True)
class LoopEquation:
    """Two ways from the ground to the same place.

    Parameters
    ----------
    apex
        The joint at which the two sides meet, or the axis of a slider.
    left, right
        Sums of vectors, positive terms only; what both ways share is cancelled.
    unknowns
        The coordinates that this loop (with the others of its block) determines.
    """

    apex: str
    left: Terms
    right: Terms
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
    """Loops that determine some coordinates together.

    Parameters
    ----------
    loops
        Two scalar equations each.
    unknowns
        The coordinates; fewer than there are equations if some of these are redundant.
    """

    loops: tuple[LoopEquation, ...]
    unknowns: tuple[sp.Symbol, ...]

    @property
    def surplus(self) -> int:
        """Number of redundant equations."""
        return 2 * len(self.loops) - len(self.unknowns)


def closure(topology: Topology, symbols: Symbols, places: Places) -> tuple[BlockEquations, ...]:
    """One equation per independent loop, block by block in the order in which they are solved."""
    axes = {body.axis: f"the axis of {name}" for name, body in topology.mechanism.bodies.items()}
    found = []
    for block in topology.solved_blocks:
        unknowns = tuple(symbols.coordinates[name] for name in block.unknowns)
        loops = tuple(
            _loop_equation(loop, axes.get(loop.apex, loop.apex), unknowns, symbols, places)
            for loop in block.loops
        )
        found.append(BlockEquations(loops, unknowns))
    return tuple(found)


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
