"""Kinetic energy T, potential energy V and generalised forces Q over the bodies' coordinates.

Centres of mass are differentiated as they stand (paper, Eqs. 2 and 3, with the translation of
every body).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import sympy as sp

from linkages.components.mechanism import Mechanism
from linkages.equations.places import Places
from linkages.equations.polar import Terms, components
from linkages.equations.symbols import Symbols


@dataclass(frozen=True)
class MassiveBody:
    """A body with a mass or a moment of inertia.

    Parameters
    ----------
    name
        Body name.
    coordinate
        Its angle or displacement.
    mass, inertia
        ``inertia`` is about the centre of mass; 0 for a body that does not turn.
    centre
        Position of the centre of mass.
    position
        The symbol that stands for it in print.
    """

    name: str
    coordinate: sp.Symbol
    mass: sp.Expr
    inertia: sp.Expr
    centre: Terms
    position: sp.Symbol


def massive_bodies(
    mechanism: Mechanism, symbols: Symbols, places: Places
) -> tuple[MassiveBody, ...]:
    """All bodies that have a part in the energies."""
    found = (
        MassiveBody(
            name=name,
            coordinate=symbols.coordinates[name],
            mass=symbols.parameter(body.mass),
            inertia=symbols.parameter(body.inertia),
            centre=places.centre(name),
            position=symbols.define("X", name),
        )
        for name, body in mechanism.bodies.items()
        if not (body.mass.absent and body.inertia.absent)
    )
    return tuple(found)


def kinetic_energy(bodies: Iterable[MassiveBody], rates: Mapping[sp.Symbol, sp.Symbol]) -> sp.Expr:
    """T = Σ ½ m v² + ½ J θ̇² in J.

    Parameters
    ----------
    bodies
        With their centres of mass.
    rates
        Whatever changes in time → the symbol of its rate.
    """
    energy = sp.S.Zero
    for body in bodies:
        if body.mass != 0:
            x, y = (time_derivative(value, rates) for value in components(body.centre))
            energy += body.mass * (x**2 + y**2) / 2
        energy += body.inertia * rates[body.coordinate] ** 2 / 2
    return energy


def time_derivative(expression: sp.Expr, rates: Mapping[sp.Symbol, sp.Symbol]) -> sp.Expr:
    """Chain rule over everything that changes in time."""
    return sp.Add(*(sp.diff(expression, q) * rate for q, rate in rates.items()))


def potential_energy(
    bodies: Iterable[MassiveBody], mechanism: Mechanism, symbols: Symbols
) -> sp.Expr:
    """V = −Σ m g·x in J, zero for centres of mass at the origin."""
    gravity = symbols.parameter(mechanism.gravity.x), symbols.parameter(mechanism.gravity.y)
    energy = sp.S.Zero
    for body in bodies:
        x, y = components(body.centre)
        energy -= sp.expand(body.mass * (gravity[0] * x + gravity[1] * y))
    turning = sorted(energy.atoms(sp.cos, sp.sin), key=sp.default_sort_key)
    varying = [*symbols.coordinates.values(), *turning]
    return sp.Add(*map(sp.factor_terms, sp.Add.make_args(sp.collect(energy, varying))))


def generalised_forces(
    mechanism: Mechanism, symbols: Symbols, efforts: Mapping[sp.Symbol, sp.Symbol]
) -> dict[sp.Symbol, sp.Expr]:
    """Q of every coordinate that a load or a drive acts on, in N·m or N.

    Parameters
    ----------
    mechanism, symbols
        Its loads, and the symbols of their numbers.
    efforts
        Driven coordinate → symbol of the unknown effort of its drive.
    """
    forces: dict[sp.Symbol, sp.Expr] = dict(efforts)
    for load in mechanism.forces:
        coordinate = symbols.coordinates[load.body]
        forces[coordinate] = forces.get(coordinate, sp.S.Zero) + symbols.parameter(load.force)
    return {coordinate: force for coordinate, force in forces.items() if force != 0}
