"""All equations of a mechanism."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from linkages.equations.closure import LoopEquation, closure
from linkages.equations.energies import (
    MassiveBody,
    generalised_forces,
    kinetic_energy,
    massive_bodies,
    potential_energy,
)
from linkages.equations.lagrange import ReducedEquations, reduce
from linkages.equations.places import Places
from linkages.equations.symbols import Symbols
from linkages.topology.topology import Topology


@dataclass(frozen=True)
class Equations:
    """Closure, energies, forces and Lagrange's equations of a mechanism.

    Parameters
    ----------
    title
        Name of the mechanism.
    symbols
        All symbols, with the values of parameters.
    coordinates
        One per body, in the order of the file: angle or displacement.
    driven, free, dependent
        Coordinates by what determines them.
    drives
        Driven coordinate → its law, a function of time.
    efforts
        Driven coordinate → unknown effort of its drive (N·m, N).
    loops
        One vector equation per independent loop.
    bodies
        Bodies with mass and their centres of mass.
    kinetic_energy, potential_energy
        T and V in J, over the coordinates of all bodies.
    forces
        Generalised forces Q over the coordinates of all bodies; others are zero.
    lagrange
        The same over the generalised coordinates.
    """

    title: str
    symbols: Symbols
    coordinates: tuple[sp.Symbol, ...]
    driven: tuple[sp.Symbol, ...]
    free: tuple[sp.Symbol, ...]
    dependent: tuple[sp.Symbol, ...]
    drives: dict[sp.Symbol, sp.Expr]
    efforts: dict[sp.Symbol, sp.Symbol]
    loops: tuple[LoopEquation, ...]
    bodies: tuple[MassiveBody, ...]
    kinetic_energy: sp.Expr
    potential_energy: sp.Expr
    forces: dict[sp.Symbol, sp.Expr]
    lagrange: ReducedEquations

    @property
    def closure(self) -> tuple[sp.Expr, ...]:
        """Φ: two scalar equations per loop, in metres."""
        return tuple(value for loop in self.loops for value in loop.residual)


def derive(topology: Topology) -> Equations:
    """Derive the equations of an analysed mechanism.

    Parameters
    ----------
    topology
        Its blocks give the loops and their order.
    """
    mechanism = topology.mechanism
    symbols = Symbols(mechanism)
    places = Places(topology, symbols)
    driven, free, dependent = (
        tuple(symbols.coordinates[name] for name in names)
        for names in (topology.driven, topology.free, topology.dependent)
    )
    loops = closure(topology, symbols, places)
    bodies = massive_bodies(mechanism, symbols, places)
    potential = potential_energy(bodies, mechanism, symbols)
    efforts = _efforts(topology, symbols)
    forces = generalised_forces(mechanism, symbols, efforts)
    return Equations(
        title=mechanism.name,
        symbols=symbols,
        coordinates=tuple(symbols.coordinates.values()),
        driven=driven,
        free=free,
        dependent=dependent,
        drives=_drives(topology, symbols),
        efforts=efforts,
        loops=loops,
        bodies=bodies,
        kinetic_energy=kinetic_energy(bodies, symbols.rates),
        potential_energy=potential,
        forces=forces,
        lagrange=reduce(loops, (*driven, *free), bodies, potential, forces, symbols),
    )


def _efforts(topology: Topology, symbols: Symbols) -> dict[sp.Symbol, sp.Symbol]:
    bodies = topology.mechanism.bodies
    return {
        symbols.coordinates[name]: symbols.define("M" if bodies[name].rotates else "F", name)
        for name in topology.driven
    }


def _drives(topology: Topology, symbols: Symbols) -> dict[sp.Symbol, sp.Expr]:
    drives = topology.mechanism.prescribed
    return {
        symbols.coordinates[name]: symbols.parameter(drives[name].start)
        + symbols.parameter(drives[name].speed) * symbols.time
        for name in topology.driven
    }
