"""Lagrange's equations (paper, Eqs. 2 and 3, with the translation of every body).

Dependent rates follow from the closure: ż = Σ_i K_zi q̇_i with the velocity coefficients of
`linkages.equations.vector_loops`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

import sympy as sp

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.equations.expressions import Symbols, Terms, components, derivative, dot, law_of
from linkages.equations.generalised import (
    ActingLoads,
    Length,
    contact_forces,
    require_forces_of_the_state,
)
from linkages.equations.vector_loops import (
    BlockCoefficients,
    BlockEquations,
    Definition,
    LoopEquation,
    Places,
    Row,
    closure,
    solve_block,
)
from linkages.topology.topology import Topology


@dataclass(frozen=True)
class MassiveBody:
    """A body with a mass or a moment of inertia about its centre of mass, or a mass at a joint."""

    name: str  # name of the body or joint
    angle: sp.Expr  # how it is turned, over the coordinates
    mass: sp.Expr
    inertia: sp.Expr
    centre: Terms  # position of the centre of mass
    position: sp.Symbol  # the symbol that stands for it in print


def massive_bodies(
    mechanism: Mechanism, symbols: Symbols, places: Places
) -> tuple[MassiveBody, ...]:
    """All bodies that have a part in the energies, then the masses at joints."""
    result = []
    for name, body in mechanism.bodies.items():
        if not (body.mass.absent and body.inertia.absent):
            angle = places.orientation(name)
            mass, inertia = symbols.parameter(body.mass), symbols.parameter(body.inertia)
            centre, position = places.centre(name), symbols.define("X", name)
            result.append(MassiveBody(name, angle, mass, inertia, centre, position))
    for term in mechanism.point_masses:
        if not term.mass.absent:
            mass, centre = symbols.parameter(term.mass), places.joint(term.joint)
            position = symbols.define("X", term.joint)
            result.append(MassiveBody(term.joint, sp.S.Zero, mass, sp.S.Zero, centre, position))
    return tuple(result)


def kinetic_energy(bodies: Iterable[MassiveBody], rates: Mapping[sp.Symbol, sp.Symbol]) -> sp.Expr:
    """T = Σ ½ m v² + ½ J θ̇² in J; `rates` has the symbols of the rates of coordinates."""
    energy = sp.S.Zero
    for body in bodies:
        if body.mass != 0:
            x, y = (time_derivative(value, rates) for value in components(body.centre))
            energy += body.mass * (x**2 + y**2) / 2
        if body.inertia != 0:
            energy += body.inertia * time_derivative(body.angle, rates) ** 2 / 2
    return energy


def time_derivative(expression: sp.Expr, rates: Mapping[sp.Symbol, sp.Symbol]) -> sp.Expr:
    """Chain rule over everything that changes in time."""
    return sp.Add(*(sp.diff(expression, q) * rate for q, rate in rates.items()))


def gravitational_energy(
    bodies: Iterable[MassiveBody], mechanism: Mechanism, symbols: Symbols
) -> sp.Expr:
    """V = −Σ m g·x in J, zero for centres of mass at the origin."""
    gravity = symbols.pair((mechanism.gravity.x, mechanism.gravity.y))
    energy = sp.S.Zero
    for body in bodies:
        x, y = components(body.centre)
        energy -= sp.expand(body.mass * (gravity[0] * x + gravity[1] * y))
    turning = sorted(energy.atoms(sp.cos, sp.sin), key=sp.default_sort_key)
    varying = [*symbols.coordinates.values(), *turning]
    return sp.Add(*map(sp.factor_terms, sp.Add.make_args(sp.collect(energy, varying))))


@dataclass(frozen=True)
class ReducedEquations:
    """Σ_j J_ij q̈_j + Σ_jk (∂J_ij/∂q_k − ½ ∂J_jk/∂q_i) q̇_j q̇_k + ∂V/∂q_i = Q_i."""

    coordinates: tuple[sp.Symbol, ...]  # the generalised coordinates q: driven, then free
    coefficients: dict[sp.Symbol, Row]  # coordinate u of a body → (∂u/∂q_1, …): 0, 1 or a symbol K
    # For each solved block what defines its K, from earlier K and coordinates
    blocks: tuple[BlockCoefficients, ...]
    # (u, v) → a_uv with 2 T = Σ a_uv u̇ v̇, for pairs of which v does not come before u
    masses: dict[tuple[sp.Symbol, sp.Symbol], Definition]
    inertia: dict[tuple[int, int], Definition]  # J_ij for i ≤ j, from a and K
    slopes: dict[sp.Symbol, sp.Expr]  # ∂V/∂u of every coordinate u of a body
    gradient: Row  # ∂V/∂q_i, from ∂V/∂u and K
    forces: Row  # Q_i, from loads, drive efforts and K


def reduce(
    blocks: tuple[BlockEquations, ...],
    independent: tuple[sp.Symbol, ...],
    bodies: tuple[MassiveBody, ...],
    potential: sp.Expr,
    between: Collection[Length],
    forces: Mapping[sp.Symbol, sp.Expr],
    symbols: Symbols,
) -> ReducedEquations:
    """Eliminate the dependent rates from T, V and Q."""
    coefficients = {q: tuple(sp.eye(len(independent)).row(i)) for i, q in enumerate(independent)}
    solved = tuple(solve_block(block, coefficients, symbols) for block in blocks)
    masses = _masses(bodies, symbols)
    slopes = {u: sp.factor_terms(_slope(potential, u, between)) for u in coefficients}
    return ReducedEquations(
        coordinates=independent,
        coefficients=coefficients,
        blocks=solved,
        masses=masses,
        inertia=_inertia(masses, coefficients, len(independent), symbols),
        slopes=slopes,
        gradient=_projected(slopes, coefficients),
        forces=_projected(forces, coefficients),
    )


def _slope(potential: sp.Expr, u: sp.Symbol, between: Collection[Length]) -> sp.Expr:
    """∂V/∂u, directly and through the lengths of springs."""
    through = (sp.diff(potential, d.symbol) * d.derivative(u) for d in between)
    return sp.diff(potential, u) + sp.Add(*through)


def _masses(
    bodies: tuple[MassiveBody, ...], symbols: Symbols
) -> dict[tuple[sp.Symbol, sp.Symbol], Definition]:
    coordinates = list(symbols.coordinates.items())
    result: dict[tuple[sp.Symbol, sp.Symbol], Definition] = {}
    for i, (first, u) in enumerate(coordinates):
        for second, v in coordinates[i:]:
            value = sp.Add(*(_mass(body, u, v) for body in bodies))
            if value != 0:
                symbol = symbols.define("a", first, second)
                result[u, v] = Definition(symbol, sp.factor_terms(value))
    return result


def _mass(body: MassiveBody, u: sp.Symbol, v: sp.Symbol) -> sp.Expr:
    """Return a body's part of a_uv: m ∂x/∂u·∂x/∂v + J ∂θ/∂u ∂θ/∂v."""
    value = body.mass * dot(derivative(body.centre, u), derivative(body.centre, v))
    return value + body.inertia * sp.diff(body.angle, u) * sp.diff(body.angle, v)


def _inertia(
    masses: Mapping[tuple[sp.Symbol, sp.Symbol], Definition],
    coefficients: Mapping[sp.Symbol, Row],
    count: int,
    symbols: Symbols,
) -> dict[tuple[int, int], Definition]:
    """J_ij = Σ_uv a_uv K_ui K_vj."""
    result: dict[tuple[int, int], Definition] = {}
    for i in range(count):
        for j in range(i, count):
            terms = []
            for (u, v), a in masses.items():
                terms.append(a.symbol * coefficients[u][i] * coefficients[v][j])
                if u != v:
                    terms.append(a.symbol * coefficients[v][i] * coefficients[u][j])
            index = (f"{i + 1}{j + 1}",) if count < 10 else (str(i + 1), str(j + 1))
            result[i, j] = Definition(symbols.define("J", *index), sp.Add(*terms))
    return result


def _projected(values: Mapping[sp.Symbol, sp.Expr], coefficients: Mapping[sp.Symbol, Row]) -> Row:
    count = len(next(iter(coefficients.values()), ()))
    return tuple(sp.Add(*(v * coefficients[u][i] for u, v in values.items())) for i in range(count))


@dataclass(frozen=True)
class SymbolicEquations:
    """Closure, energies, forces and Lagrange's equations of a mechanism."""

    title: str  # name of the mechanism
    symbols: Symbols  # all symbols, with the values of parameters
    # One per body, in the order of the file: angle or displacement. A body that a weld or gear
    # turns has none of its own
    coordinates: tuple[sp.Symbol, ...]
    driven: tuple[sp.Symbol, ...]
    free: tuple[sp.Symbol, ...]
    dependent: tuple[sp.Symbol, ...]
    followers: tuple[Definition, ...]  # angles of the bodies that welds and gears turn
    drives: dict[sp.Symbol, sp.Expr]  # driven coordinate → its law, a function of time
    # Driven coordinate → unknown effort of its drive (N·m, N), or of the actuator in its place
    efforts: dict[sp.Symbol, sp.Symbol]
    # Vector equations, one per independent loop, and what they determine together
    blocks: tuple[BlockEquations, ...]
    bodies: tuple[MassiveBody, ...]  # bodies with mass and their centres of mass
    loads: ActingLoads  # what acts; `elastic` and `forces` refer to its `lengths`
    # Distances, rates, forces and slips of clearances that open, each from what stands before it
    contacts: tuple[Definition, ...]
    kinetic_energy: sp.Expr  # t in J, over the coordinates of all bodies
    gravitational: sp.Expr
    elastic: sp.Expr
    # Generalised forces Q over the coordinates of all bodies, their rates, and time; others are
    # zero
    forces: dict[sp.Symbol, sp.Expr]
    lagrange: ReducedEquations  # the same over the generalised coordinates
    # Internal state → its rate, over the coordinates, their rates, internal states and time
    internal: dict[sp.Symbol, sp.Expr]
    # State that is sampled → what it becomes at every multiple of a period, and that
    updates: dict[sp.Symbol, tuple[sp.Expr, sp.Expr]]

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
        result, rates = self.loads.lengths.values(), self.symbols.rates
        lengths = [Definition(d.symbol, d.length) for d in result]
        speeds = (Definition(d.rate, d.speed(rates)) for d in result)
        return (*lengths, *speeds, *self.contacts)

    def expanded(self, expression: sp.Expr) -> sp.Expr:
        """An expression over coordinates and rates, without lengths of loads."""
        for definition in reversed(self.intermediate):
            expression = expression.subs(definition.symbol, definition.value)
        return expression


def derive(topology: Topology) -> SymbolicEquations:
    """Derive the equations of an analysed mechanism, whose blocks give the loops in their order."""
    mechanism = topology.mechanism
    require_forces_of_the_state(mechanism)
    symbols = Symbols(mechanism, tuple(topology.followers))
    places = Places(topology, symbols)
    driven, free, dependent = (
        tuple(symbols.coordinates[name] for name in names if name in symbols.coordinates)
        for names in (topology.driven, topology.free, topology.dependent)
    )
    blocks = closure(topology, symbols, places)
    bodies = massive_bodies(mechanism, symbols, places)
    gravitational = gravitational_energy(bodies, mechanism, symbols)
    acting = ActingLoads(mechanism, symbols, places)
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
        drives={
            symbols.coordinates[name]: law_of(mechanism.prescribed[name].law, symbols)
            for name in topology.driven
        },
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
        internal={
            symbols.internal[state.name]: law if state.period is None else sp.S.Zero
            for state, law in acting.internal_laws()
        },
        updates={
            symbols.internal[state.name]: (law, symbols.parameter(state.period.parameter))
            for state, law in acting.internal_laws()
            if state.period is not None
        },
    )


def _efforts(topology: Topology, symbols: Symbols) -> dict[sp.Symbol, sp.Symbol]:
    mechanism = topology.mechanism
    names = tuple(mechanism.actuations) or topology.driven
    return {
        symbols.coordinates[driven]: symbols.define("M" if mechanism.twisting(name) else "F", name)
        for driven, name in zip(topology.driven, names, strict=True)
    }
