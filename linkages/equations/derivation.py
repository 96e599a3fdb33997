"""All equations of a mechanism."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from linkages.equations.closure import BlockEquations, LoopEquation, closure
from linkages.equations.coefficients import Definition
from linkages.equations.contacts import contact_forces, require_forces_of_the_state
from linkages.equations.energies import (
    MassiveBody,
    gravitational_energy,
    kinetic_energy,
    massive_bodies,
)
from linkages.equations.lagrange import ReducedEquations, reduce
from linkages.equations.laws import law_of
from linkages.equations.loads import ActingLoads
from linkages.equations.places import Places
from linkages.equations.symbols import Symbols
from linkages.topology.topology import Topology


@dataclass(frozen=True)
class SymbolicEquations:
    """Closure, energies, forces and Lagrange's equations of a mechanism.

    Parameters
    ----------
    title
        Name of the mechanism.
    symbols
        All symbols, with the values of parameters.
    coordinates
        One per body, in the order of the file: angle or displacement. A body that a weld or gear
        turns has none of its own.
    driven, free, dependent
        Coordinates by what determines them.
    followers
        Angles of the bodies that welds and gears turn.
    drives
        Driven coordinate → its law, a function of time.
    efforts
        Driven coordinate → unknown effort of its drive (N·m, N).
    blocks
        Vector equations, one per independent loop, and what they determine together.
    bodies
        Bodies with mass and their centres of mass.
    loads
        What acts; `elastic` and `forces` refer to its `lengths`.
    contacts
        Distances, rates, forces and slips of clearances that open, each from what stands before it.
    kinetic_energy
        T in J, over the coordinates of all bodies.
    gravitational, elastic
        The parts of the potential energy V in J.
    forces
        Generalised forces Q over the coordinates of all bodies, their rates, and time; others are
        zero.
    lagrange
        The same over the generalised coordinates.
    internal
        Internal state → its rate, over the coordinates, their rates, internal states and time.
    """

    title: str
    symbols: Symbols
    coordinates: tuple[sp.Symbol, ...]
    driven: tuple[sp.Symbol, ...]
    free: tuple[sp.Symbol, ...]
    dependent: tuple[sp.Symbol, ...]
    followers: tuple[Definition, ...]
    drives: dict[sp.Symbol, sp.Expr]
    efforts: dict[sp.Symbol, sp.Symbol]
    blocks: tuple[BlockEquations, ...]
    bodies: tuple[MassiveBody, ...]
    loads: ActingLoads
    contacts: tuple[Definition, ...]
    kinetic_energy: sp.Expr
    gravitational: sp.Expr
    elastic: sp.Expr
    forces: dict[sp.Symbol, sp.Expr]
    lagrange: ReducedEquations
    internal: dict[sp.Symbol, sp.Expr]

    @property
    def loops(self) -> tuple[LoopEquation, ...]:
        """All loops, in the order in which blocks are solved."""
        return tuple(loop for block in self.blocks for loop in block.loops)

    @property
    def closure(self) -> tuple[sp.Expr, ...]:
        """Φ: two scalar equations per loop, in metres."""
        return tuple(value for loop in self.loops for value in loop.residual)

    @property
    def potential_energy(self) -> sp.Expr:
        """V in J, over the coordinates of all bodies."""
        return self.gravitational + self.expanded(self.elastic)

    @property
    def intermediate(self) -> tuple[Definition, ...]:
        """Distances and their rates, each from what stands before it."""
        found, rates = self.loads.lengths.values(), self.symbols.rates
        lengths = [Definition(d.symbol, d.length) for d in found]
        speeds = (Definition(d.rate, d.speed(rates)) for d in found)
        return (*lengths, *speeds, *self.contacts)

    def expanded(self, expression: sp.Expr) -> sp.Expr:
        """An expression over coordinates and rates, without lengths of loads."""
        for definition in reversed(self.intermediate):
            expression = expression.subs(definition.symbol, definition.value)
        return expression


def derive(topology: Topology) -> SymbolicEquations:
    """Derive the equations of an analysed mechanism.

    Parameters
    ----------
    topology
        Its blocks give the loops and their order.
    """
    mechanism = topology.mechanism
    require_forces_of_the_state(mechanism)
    symbols = Symbols(mechanism, tuple(topology.slaves))
    places = Places(topology, symbols)
    driven, free, dependent = (
        tuple(symbols.coordinates[name] for name in names if name in symbols.coordinates)
        for names in (topology.driven, topology.free, topology.dependent)
    )
    blocks = closure(topology, symbols, places)
    bodies = massive_bodies(mechanism, symbols, places)
    gravitational = gravitational_energy(bodies, mechanism, symbols)
    acting = ActingLoads(mechanism.loads, symbols, places)
    elastic = acting.stored_energy()
    potential = gravitational + elastic
    efforts = _efforts(topology, symbols)
    forces = acting.generalised_forces(efforts)
    contacts = contact_forces(mechanism, symbols, places)
    for q, force in contacts.generalised.items():
        forces[q] = forces.get(q, sp.S.Zero) + force
    return SymbolicEquations(
        title=mechanism.name,
        symbols=symbols,
        coordinates=tuple(symbols.coordinates.values()),
        driven=driven,
        free=free,
        dependent=dependent,
        followers=tuple(
            Definition(symbol, places.coordinate(name))
            for name, symbol in symbols.followers.items()
        ),
        drives=_drives(topology, symbols),
        efforts=efforts,
        blocks=blocks,
        bodies=bodies,
        loads=acting,
        contacts=contacts.definitions,
        kinetic_energy=kinetic_energy(bodies, symbols.rates),
        gravitational=gravitational,
        elastic=elastic,
        forces=forces,
        lagrange=reduce(
            blocks, (*driven, *free), bodies, potential, acting.lengths.values(), forces, symbols
        ),
        internal=acting.internal_rates(),
    )


def _efforts(topology: Topology, symbols: Symbols) -> dict[sp.Symbol, sp.Symbol]:
    bodies = topology.mechanism.bodies
    return {
        symbols.coordinates[name]: symbols.define("M" if bodies[name].rotates else "F", name)
        for name in topology.driven
    }


def _drives(topology: Topology, symbols: Symbols) -> dict[sp.Symbol, sp.Expr]:
    prescribed = topology.mechanism.prescribed
    return {
        symbols.coordinates[name]: law_of(prescribed[name].law, symbols) for name in topology.driven
    }
