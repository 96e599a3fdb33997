"""Lengths of springs and dampers, and the energy that springs store."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import assert_never

import sympy as sp

from linkages.components.terms import (
    AxialDamper,
    AxialForce,
    Load,
    PointForce,
    Spring,
    Torque,
    TorsionSpring,
)
from linkages.equations.places import Places
from linkages.equations.polar import Terms, collected, derivative, dot
from linkages.equations.symbols import Symbols


@dataclass(frozen=True)
class Distance:
    """The distance of two joints that a spring or damper acts between.

    Parameters
    ----------
    symbol, rate
        Symbols of the distance and of its rate.
    between
        From its first to its second joint.
    """

    symbol: sp.Symbol
    rate: sp.Symbol
    between: Terms

    @property
    def length(self) -> sp.Expr:
        """The distance over the coordinates of the bodies."""
        return sp.sqrt(dot(self.between, self.between))

    def derivative(self, coordinate: sp.Symbol) -> sp.Expr:
        """Return the partial derivative: the unit vector times the derivative of the vector."""
        return dot(self.between, derivative(self.between, coordinate)) / self.symbol

    def speed(self, rates: Mapping[sp.Symbol, sp.Symbol]) -> sp.Expr:
        """Return its rate over the rates of the coordinates."""
        return sp.Add(*(self.derivative(q) * rate for q, rate in rates.items()))


def distances(
    loads: tuple[Load, ...], symbols: Symbols, places: Places
) -> dict[tuple[str, str], Distance]:
    """One for each pair of joints that a spring or damper acts between."""
    found: dict[tuple[str, str], Distance] = {}
    for load in loads:
        if not isinstance(load, Spring) or (load.first, load.second) in found:
            continue
        if load.stiffness.absent and load.damping.absent:
            continue
        back = (-term for term in places.joint(load.first))
        between = collected((*places.joint(load.second), *back), symbols.coordinates.values())
        symbol = symbols.define("D", load.first, load.second)
        found[load.first, load.second] = Distance(symbol, symbols.dotted(symbol), between)
    return found


def deflection(load: TorsionSpring, symbols: Symbols, places: Places) -> sp.Expr:
    """How far a torsional spring is turned."""
    return turned(load.body, load.reference, places) - symbols.parameter(load.angle)


def turned(body: str, reference: str | None, places: Places) -> sp.Expr:
    """The angle of a body against another one or the ground."""
    angle = places.orientation(body)
    return angle if reference is None else angle - places.orientation(reference)


def stored_energy(
    loads: tuple[Load, ...],
    between: Mapping[tuple[str, str], Distance],
    symbols: Symbols,
    places: Places,
) -> sp.Expr:
    """½ k (D − L)² and ½ k (θ − φ)² of all springs, over distances and coordinates, in J."""
    energy = sp.S.Zero
    for load in loads:
        match load:
            case Spring():
                if not load.stiffness.absent:
                    distance = between[load.first, load.second].symbol
                    longer = distance - symbols.parameter(load.length)
                    energy += symbols.parameter(load.stiffness) * longer**2 / 2
            case TorsionSpring():
                if not load.stiffness.absent:
                    longer = deflection(load, symbols, places)
                    energy += symbols.parameter(load.stiffness) * longer**2 / 2
            case AxialForce() | AxialDamper() | PointForce() | Torque():
                pass
            case _:
                assert_never(load)
    return energy
