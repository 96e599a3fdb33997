"""Plane vectors as sums of length∠angle."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import sympy as sp

RIGHT_ANGLE = sp.pi / 2


@dataclass(frozen=True)
class Polar:
    """The vector length∠angle; angle in radians, counter-clockwise from +x."""

    length: sp.Expr
    angle: sp.Expr

    def __neg__(self) -> Polar:
        return Polar(-self.length, self.angle)

    @property
    def components(self) -> tuple[sp.Expr, sp.Expr]:
        """Its x and y components."""
        return self.length * sp.cos(self.angle), self.length * sp.sin(self.angle)

    def derivative(self, coordinate: sp.Symbol) -> Terms:
        """Return the partial derivative by its angle and by its length, without zeros."""
        turned = Polar(self.length * sp.diff(self.angle, coordinate), self.angle + RIGHT_ANGLE)
        grown = Polar(sp.diff(self.length, coordinate), self.angle)
        return tuple(term for term in (turned, grown) if term.length != 0)


Terms = tuple[Polar, ...]


def in_frame(angle: sp.Expr, x: sp.Expr, y: sp.Expr) -> Terms:
    """Return the vector with components x and y in a frame turned by an angle."""
    terms = Polar(x, angle), Polar(y, angle + RIGHT_ANGLE)
    return tuple(term for term in terms if term.length != 0)


def components(terms: Iterable[Polar]) -> tuple[sp.Expr, sp.Expr]:
    """Return the x and y components of a sum."""
    pairs = [term.components for term in terms]
    return sp.Add(*(x for x, _ in pairs)), sp.Add(*(y for _, y in pairs))


def derivative(terms: Iterable[Polar], coordinate: sp.Symbol) -> Terms:
    """Return the partial derivative of a sum, without zeros."""
    return tuple(part for term in terms for part in term.derivative(coordinate))


def dot(a: Terms, b: Terms) -> sp.Expr:
    """Scalar product of two sums."""
    return sp.Add(*(p.length * q.length * sp.cos(p.angle - q.angle) for p in a for q in b))


def cross(a: Terms, b: Terms) -> sp.Expr:
    """Third component of the vector product of two sums."""
    return sp.Add(*(p.length * q.length * sp.sin(q.angle - p.angle) for p in a for q in b))


def collected(terms: Iterable[Polar], apart: Iterable[sp.Symbol]) -> Terms:
    """Return the same sum with equal directions added up and zeros left out.

    Parameters
    ----------
    terms
        Their order is kept.
    apart
        Displacements: a term with one of these is not added to the constants of its direction.
    """
    alone = set(apart)
    lengths: dict[tuple[sp.Expr, frozenset], sp.Expr] = {}
    for term in terms:
        key = (term.angle, frozenset(term.length.free_symbols & alone))
        lengths[key] = lengths.get(key, sp.S.Zero) + term.length
    return tuple(Polar(length, key[0]) for key, length in lengths.items() if length != 0)
