"""Generalised forces Q of loads and drives: what they work on each coordinate of a body."""

from __future__ import annotations

from collections.abc import Mapping
from typing import assert_never

import sympy as sp

from linkages.components.functions import Function, Number
from linkages.components.terms import (
    AxialDamper,
    AxialForce,
    Load,
    PointForce,
    Spring,
    Torque,
    TorsionSpring,
)
from linkages.equations.laws import law_of
from linkages.equations.places import Places
from linkages.equations.polar import derivative
from linkages.equations.springs import Distance, turned
from linkages.equations.symbols import Symbols

Forces = dict[sp.Symbol, sp.Expr]


class GeneralisedForces:
    """Sums generalised forces over the coordinates of all bodies, in N·m or N.

    Springs are left out: their forces follow from the potential energy.

    Parameters
    ----------
    symbols, places
        Of the mechanism.
    between
        Distances that springs and dampers act along.
    """

    def __init__(
        self, symbols: Symbols, places: Places, between: Mapping[tuple[str, str], Distance]
    ) -> None:
        self._symbols = symbols
        self._places = places
        self._between = between

    def total(self, loads: tuple[Load, ...], efforts: Mapping[sp.Symbol, sp.Symbol]) -> Forces:
        """Q of every coordinate that a load or a drive acts on.

        Parameters
        ----------
        loads
            Of the mechanism.
        efforts
            Driven coordinate → symbol of the unknown effort of its drive.
        """
        total: Forces = dict(efforts)
        for load in loads:
            for coordinate, force in self._of(load).items():
                total[coordinate] = total.get(coordinate, sp.S.Zero) + force
        return {coordinate: force for coordinate, force in total.items() if force != 0}

    def _of(self, load: Load) -> Forces:
        symbols = self._symbols
        match load:
            case AxialForce():
                return {symbols.coordinates[load.body]: law_of(load.force, symbols)}
            case AxialDamper():
                coordinate = symbols.coordinates[load.body]
                return {coordinate: -symbols.parameter(load.damping) * symbols.rates[coordinate]}
            case PointForce():
                return self._at_joint(load)
            case Torque():
                angle = turned(load.body, load.reference, self._places)
                return self._along(angle, law_of(load.torque, symbols))
            case Spring():
                return self._damped(load)
            case TorsionSpring():
                angle = turned(load.body, load.reference, self._places)
                rate = sp.Add(*(sp.diff(angle, q) * dq for q, dq in symbols.rates.items()))
                return self._along(angle, -symbols.parameter(load.damping) * rate)
            case _:
                assert_never(load)

    def _along(self, angle: sp.Expr, torque: sp.Expr) -> Forces:
        """Of a torque that works on an angle."""
        return {q: torque * sp.diff(angle, q) for q in self._symbols.rates if angle.has(q)}

    def _damped(self, load: Spring) -> Forces:
        """−d Ḋ ∂D/∂q of the damper beside a spring."""
        if load.damping.absent:
            return {}
        distance = self._between[load.first, load.second]
        pull = -self._symbols.parameter(load.damping) * distance.rate
        return {q: pull * distance.derivative(q) for q in self._symbols.rates}

    def _at_joint(self, load: PointForce) -> Forces:
        """F·∂X/∂q of a force at a joint."""
        number = str(load.path[-1] + 1) if isinstance(load.path[-1], int) else load.joint
        x, y = (
            self._component(part, number, axis) for part, axis in zip(load.force, "xy", strict=True)
        )
        place = self._places.joint(load.joint)
        return {
            q: sp.Add(*(p.length * (x * sp.cos(p.angle) + y * sp.sin(p.angle)) for p in moved))
            for q in self._symbols.rates
            if (moved := derivative(place, q))
        }

    def _component(self, law: Function, number: str, axis: str) -> sp.Expr:
        if isinstance(law, Number):
            return self._symbols.parameter(law.parameter, ("F", number, axis))
        return law_of(law, self._symbols)
