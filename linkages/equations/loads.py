"""Generalised forces of loads, and the energy that they store, along what they are measured by."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import assert_never

import sympy as sp

from linkages.components.contributed.functions import Function, Internal, Measured, Number
from linkages.components.contributed.measures import (
    BodyAxis,
    Coordinate,
    Distance,
    Load,
    Measure,
    Slide,
    Turn,
)
from linkages.equations.laws import law_of
from linkages.equations.places import Places
from linkages.equations.polar import Terms, collected, derivative, dot
from linkages.equations.symbols import Symbols

Forces = dict[sp.Symbol, sp.Expr]


@dataclass(frozen=True)
class Length:
    """The distance of two joints that a load acts along.

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


Slopes = Mapping[sp.Symbol, Sequence[tuple[sp.Expr, sp.Expr]]]
"""Coordinate of a body → the derivative by it, as a sum of products of two factors."""


@dataclass(frozen=True)
class MeasureSymbols:
    """What a load acts along: its value, its rate, and its derivatives."""

    value: sp.Expr
    rate: sp.Expr
    slopes: Slopes


class ActingLoads:
    """The loads of a mechanism.

    Parameters
    ----------
    loads
        Those of exact zeros have no part in anything.
    symbols, places
        Of the mechanism.

    Attributes
    ----------
    lengths
        Two joints → their distance, for each pair that a load acts between.
    """

    def __init__(self, loads: tuple[Load, ...], symbols: Symbols, places: Places) -> None:
        self._loads = [load for load in loads if not load.absent]
        self._symbols = symbols
        self._places = places
        self.lengths: dict[tuple[str, str], Length] = {}
        for load in self._loads:
            for measure in (load.measure, *load.sensed):
                if isinstance(measure, Distance):
                    self._add_length(measure)

    def _add_length(self, measure: Distance) -> None:
        ends = measure.first, measure.second
        if ends in self.lengths:
            return
        back = (-term for term in self._places.joint(measure.first))
        way = (*self._places.joint(measure.second), *back)
        symbol = self._symbols.define("D", *ends)
        between = collected(way, self._symbols.coordinates.values())
        self.lengths[ends] = Length(symbol, self._symbols.dotted(symbol), between)

    def stored_energy(self) -> sp.Expr:
        """Potential energy, such as ½ k (D − L)² and ½ k (θ − φ)², in J."""
        return sp.Add(*(self._law(load.energy, self._along(load.measure)) for load in self._loads))

    def generalised_forces(self, efforts: Mapping[sp.Symbol, sp.Symbol]) -> Forces:
        """Q of every coordinate that a load or a drive acts on, in N·m or N.

        What follows from the stored energy is left out.

        Parameters
        ----------
        efforts
            Driven coordinate → symbol of the unknown effort of its drive.
        """
        total: Forces = dict(efforts)
        for _, same in groupby(self._loads, key=lambda load: (load.path, _joint(load))):
            found = [(load, self._along(load.measure)) for load in same]
            parts = [(self._force(load, along), along) for load, along in found]
            for q in self._symbols.rates:
                total[q] = total.get(q, sp.S.Zero) + _work(parts, q)
        return {coordinate: force for coordinate, force in total.items() if force != 0}

    def internal_rates(self) -> dict[sp.Symbol, sp.Expr]:
        """Internal state → its rate, a function of the state and of time."""
        return {
            self._symbols.internal[state.name]: self._law(state.rate, self._along(load.measure))
            for load in self._loads
            for state in load.states
        }

    def _force(self, load: Load, along: MeasureSymbols) -> sp.Expr:
        """What works along a measure beyond the stored energy."""
        if isinstance(load.measure, Coordinate | BodyAxis) and isinstance(load.law, Number):
            entry = load.path[-1]
            number = str(entry + 1) if isinstance(entry, int) else load.measure.joint
            notation = ("F", number, "xy"[load.measure.axis])
            return self._symbols.parameter(load.law.parameter, notation)
        return self._law(load.working, along)

    def _law(self, law: Function, along: MeasureSymbols) -> sp.Expr:
        def measured(found: Measured | Internal) -> sp.Expr:
            if isinstance(found, Internal):
                return self._symbols.internal[found.name]
            of = along if found.measure is None else self._along(found.measure)
            return of.rate if found.order else of.value

        return law_of(law, self._symbols, measured)

    def _along(self, measure: Measure) -> MeasureSymbols:
        places, rates = self._places, self._symbols.rates
        slopes: Slopes = {}
        match measure:
            case Distance(first, second):
                length = self.lengths[first, second]
                slopes = {q: [(sp.S.One, length.derivative(q))] for q in rates}
                return MeasureSymbols(length.symbol, length.rate, slopes)
            case Turn(body, reference):
                value = places.orientation(body)
                if reference is not None:
                    value -= places.orientation(reference)
            case Slide(body):
                value = places.coordinate(body)
            case Coordinate(joint, axis):
                place, part = places.joint(joint), (sp.cos, sp.sin)[axis]
                value = sp.Add(*(term.components[axis] for term in place))
                slopes = {
                    q: [(p.length, part(p.angle)) for p in derivative(place, q)] for q in rates
                }
            case BodyAxis(joint, body, axis):
                value, part = sp.S.NaN, (sp.cos, sp.sin)[axis]
                place, turned = places.joint(joint), places.orientation(body)
                slopes = {
                    q: [(p.length, part(p.angle - turned)) for p in derivative(place, q)]
                    for q in rates
                }
            case _:
                assert_never(measure)
        slopes = slopes or {q: [(sp.S.One, sp.diff(value, q))] for q in rates}
        rate = sp.Add(*(a * b * rates[q] for q, terms in slopes.items() for a, b in terms))
        return MeasureSymbols(value, rate, slopes)


def _work(parts: Sequence[tuple[sp.Expr, MeasureSymbols]], coordinate: sp.Symbol) -> sp.Expr:
    """Forces times slopes; both components of a force at a joint turn the same lengths."""
    total = sp.S.Zero
    for terms in zip(*(along.slopes[coordinate] for _, along in parts), strict=True):
        turned = (f * factor for (f, _), (_, factor) in zip(parts, terms, strict=True))
        total += terms[0][0] * sp.Add(*turned)
    return total


def _joint(load: Load) -> str | None:
    return load.measure.joint if isinstance(load.measure, Coordinate | BodyAxis) else None
