"""Generalised forces of loads and contacts as SymPy expressions."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import NamedTuple, assert_never

import sympy as sp

from linkages.components.contributed.functions import FIRST, Function, Internal, Measured, Number
from linkages.components.contributed.load_measures import (
    BodyAxis,
    Coordinate,
    Distance,
    Load,
    Measure,
    Slide,
    Turn,
)
from linkages.components.contributed.normal_forces import (
    Contact,
    CornerAtWall,
    FollowerOnCam,
    NormalForce,
    OilFilm,
    PinInHole,
    RigidContact,
    RoundAtWall,
)
from linkages.components.contributed.state_laws import InternalState, leaves, measured_in
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.equations.expressions import (
    Select,
    Symbols,
    Terms,
    collected,
    components,
    derivative,
    dot,
    law_of,
)
from linkages.equations.vector_loops import Definition, Places

Forces = dict[sp.Symbol, sp.Expr]


@dataclass(frozen=True)
class Length:
    """The distance of two joints that a load acts along."""

    symbol: sp.Symbol
    rate: sp.Symbol
    between: Terms  # from its first to its second joint

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
    """The loads and actuators of a mechanism."""

    def __init__(self, mechanism: Mechanism, symbols: Symbols, places: Places) -> None:
        self._loads = [load for load in mechanism.loads if not load.absent]
        self._actuations = [own.measure for own in mechanism.actuations.values()]
        self._states = mechanism.states
        self._symbols = symbols
        self._places = places
        self.lengths: dict[tuple[str, str], Length] = {}
        of_states = (m.measure for state in self._states for m in measured_in(state.law))
        of_loads = (m for load in self._loads for m in (load.measure, *load.sensed))
        for measure in (*of_loads, *of_states, *self._actuations):
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

        What follows from the stored energy is left out. `efforts`: of drives by their coordinates;
        actuators act in their place, in the same order.
        """
        total: Forces = {} if self._actuations else dict(efforts)
        for effort, measure in zip(efforts.values(), self._actuations, strict=False):
            along = self._along(measure)
            for q in self._symbols.rates:
                total[q] = total.get(q, sp.S.Zero) + _work([(effort, along)], q)
        for _, same in groupby(self._loads, key=lambda load: (load.path, _joint(load))):
            result = [(load, self._along(load.measure)) for load in same]
            parts = [(self._force(load, along), along) for load, along in result]
            for q in self._symbols.rates:
                total[q] = total.get(q, sp.S.Zero) + _work(parts, q)
        return {coordinate: force for coordinate, force in total.items() if force != 0}

    def internal_laws(self) -> Iterator[tuple[InternalState, sp.Expr]]:
        """Internal states, and what their laws give: functions of the state and of time."""
        for load in self._loads:
            for state in load.states:
                yield state, self._law(state.law, self._along(load.measure))
        for state in self._states:
            yield state, self._law(state.law)

    def _force(self, load: Load, along: MeasureSymbols) -> sp.Expr:
        """What works along a measure beyond the stored energy."""
        if isinstance(load.measure, Coordinate | BodyAxis) and isinstance(load.law, Number):
            entry = load.path[-1]
            number = str(entry + 1) if isinstance(entry, int) else load.measure.joint
            notation = ("F", number, "xy"[load.measure.axis])
            return self._symbols.parameter(load.law.parameter, notation)
        return self._law(load.working, along)

    def _law(self, law: Function, along: MeasureSymbols | None = None) -> sp.Expr:
        def measured(found: Measured | Internal) -> sp.Expr:
            if isinstance(found, Internal):
                return self._symbols.internal[found.name]
            of = along if found.measure is None else self._along(found.measure)
            assert of is not None
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


class _Acting(ABC):
    """What journals and bearings, or blocks and guides, do to each other at one contact."""

    def __init__(
        self, contact: Contact, mechanism: Mechanism, symbols: Symbols, places: Places
    ) -> None:
        self._symbols, self._places, self._name = symbols, places, contact.name
        self.definitions: list[Definition] = []
        self._build(contact, mechanism)

    def _define(self, letter: str, value: sp.Expr, name: str = "") -> sp.Symbol:
        symbol = self._symbols.define(letter, name or self._name)
        self.definitions.append(Definition(symbol, value))
        return symbol

    @abstractmethod
    def _build(self, contact: Contact, mechanism: Mechanism) -> None: ...

    @abstractmethod
    def along(self, rate: sp.Symbol) -> sp.Expr:
        """Work of all forces per unit of a coordinate with this rate."""


class _Film(_Acting):
    """One film; `linkages.kernel.forces.contact_forces` derives the force."""

    def _build(self, contact: Contact, mechanism: Mechanism) -> None:
        symbols, places, pin, film = self._symbols, self._places, contact.geometry, contact.normal
        assert isinstance(pin, PinInHole), "films are between journals and bearings"
        assert isinstance(film, OilFilm)
        size, radius = symbols.parameter(pin.size), symbols.parameter(pin.pin_radius)
        width, viscosity = symbols.parameter(film.width), symbols.parameter(film.viscosity)
        x, y = (symbols.coordinates[axis] for axis in pin.axes)
        own, other = places.turning(pin.body), places.turning(mechanism.carrier(pin.joint))
        mean, self._sheared = (own + other) / 2, own - other
        self._squeezed = symbols.rates[x] + mean * y, symbols.rates[y] - mean * x
        wx, wy = (self._define("w", along) for along in self._squeezed)
        root = self._define("Q", sp.sqrt(1 - (x**2 + y**2) / size**2))
        reach: sp.Expr = 2 * sp.pi
        ends_x = ends_y = sp.S.Zero
        if not film.whole:
            speed = self._define("W", sp.sqrt(wx**2 + wy**2))
            ahead = self._define("epsilon", (x * wx + y * wy) / (size * speed))
            aside = self._define("epsilon", (y * wx - x * wy) / (size * speed))
            reach = sp.pi + 2 * sp.atan(ahead / root)
            side = aside * (4 + 2 * ahead**2 / (1 - aside**2))
            ends_x = (6 * ahead * wx - side * wy) / root**4
            ends_y = (6 * ahead * wy + side * wx) / root**4
        reach = self._define("Gamma", reach)
        across = 3 * (x * wx + y * wy) / (size**2 * root**5)
        scale = -viscosity * radius * width**3 / (2 * size**3)
        self._force = (
            self._define("F", scale * (reach * (wx / root**3 + across * x) + ends_x)),
            self._define("F", scale * (reach * (wy / root**3 + across * y) + ends_y)),
        )
        shear = viscosity * radius**3 * width / size * reach / root
        self._torque = self._define("M", shear * self._sheared)

    def along(self, rate: sp.Symbol) -> sp.Expr:
        pairs = zip(self._force, self._squeezed, strict=True)
        squeezing = sp.Add(*(force * sp.diff(along, rate) for force, along in pairs))
        return squeezing - self._torque * sp.diff(self._sheared, rate)


def require_forces_of_the_state(mechanism: Mechanism) -> None:
    """Impulses, and forces that depend on reactions or on history, have no closed form."""
    reactions = (
        "the law depends on a reaction, which follows from accelerations: there are no equations "
        "in closed form; expected friction under a constant load"
    )
    result = [(load.path, reactions) for load in mechanism.loads if load.bearing is not None]
    for contact in mechanism.contacts:
        normal = contact.normal
        if isinstance(contact.geometry, PinInHole) and contact.geometry.profile:
            why = "where a journal touches a bearing that is not round is found by iteration"
            expected = "there are no equations in closed form; expected no profile"
            result.append(((*contact.path, "profile"), f"{why}: {expected}"))
            continue
        if isinstance(normal, RigidContact):
            why = "impacts change rates at once, by no force"
        elif isinstance(normal, NormalForce) and FIRST in leaves(normal.force):
            why = "the force depends on the rate at which each contact began"
        else:
            continue
        message = (
            f"{why}, which is no function of the state: there are no equations in closed form; "
            "expected a law without that (hertz, hunt-crossley-constant, kelvin-voigt)"
        )
        result.append(((*contact.path, "contact"), message))
    for path in dict.fromkeys(end.path for end in mechanism.ends):
        why = "impacts change rates at once, by no force: there are no equations in closed form"
        result.append(((*path, "restitution"), f"{why}; expected 'stiffness'"))
    if result:
        raise mechanism.error(result)


@dataclass(frozen=True)
class ContactForces:
    """What journals and bearings do to each other."""

    # Distances, rates, slips and forces of contacts, each from what stands before it
    definitions: tuple[Definition, ...]
    generalised: Forces  # q of the coordinates that they act on, in N or N·m


def contact_forces(mechanism: Mechanism, symbols: Symbols, places: Places) -> ContactForces:
    """Normal forces and friction of all contacts."""
    definitions: list[Definition] = []
    total: Forces = {}
    for contact in mechanism.contacts:
        kind = _Film if isinstance(contact.normal, OilFilm) else _Contact
        own: _Acting = kind(contact, mechanism, symbols, places)
        definitions += own.definitions
        for q, rate in symbols.rates.items():
            total[q] = total.get(q, sp.S.Zero) + own.along(rate)
    return ContactForces(tuple(definitions), {q: force for q, force in total.items() if force != 0})


def _picked(*values: sp.Expr) -> Callable[[Measured | Internal], sp.Expr]:
    """What laws are measured by, by its order."""

    def value(found: Measured | Internal) -> sp.Expr:
        assert isinstance(found, Measured)
        return values[found.order]

    return value


class _Gap(NamedTuple):
    """What tells whether two bodies touch, the indentation, its rate, and slip."""

    touch: sp.Expr
    depth: sp.Expr
    rate: sp.Expr
    slip: sp.Expr


class _Contact(_Acting):
    """A normal force, and friction under it."""

    def _build(self, contact: Contact, mechanism: Mechanism) -> None:
        normal, symbols = contact.normal, self._symbols
        assert isinstance(normal, NormalForce)
        match contact.geometry:
            case PinInHole():
                gap = self._pin(contact.geometry, mechanism.carrier(contact.geometry.joint))
            case CornerAtWall():
                gap = self._corner(contact.geometry)
            case RoundAtWall():
                gap = self._wall(contact.geometry, mechanism)
            case FollowerOnCam():
                gap = self._cam(contact.geometry)
            case _:
                assert_never(contact.geometry)
        self._deepening, self._slip = gap.rate, gap.slip
        measured = _picked(gap.depth, self._define("v", gap.rate))
        force = law_of(normal.force, symbols, measured)
        if normal.pressing is not None:
            force = Select(law_of(normal.pressing, symbols, measured), force, sp.S.Zero)
        self._force = self._define("N", Select(gap.touch, force, sp.S.Zero))
        self._friction: sp.Expr = sp.S.Zero
        if contact.friction is not None:
            slip = self._define("w", self._slip)
            part = law_of(contact.friction, symbols, _picked(slip, slip))
            self._friction = self._define("F", self._force * part)

    def _pin(self, pin: PinInHole, other: str | None) -> _Gap:
        """Where the gap is open the distance counts as its size: nothing is 0/0."""
        symbols = self._symbols
        x, y = (symbols.coordinates[axis] for axis in pin.axes)
        dx, dy = symbols.rates[x], symbols.rates[y]
        size, radius = symbols.parameter(pin.size), symbols.parameter(pin.pin_radius)
        touch = x**2 + y**2 - size**2
        apart = self._define("D", Select(touch, sp.sqrt(x**2 + y**2), size), pin.clearance)
        bodies = (other, pin.body) if pin.hole else (pin.body, other)
        of_pin, of_hole = map(self._places.turning, bodies)
        slip = (x * dy - y * dx) / apart + radius * of_pin - (radius + apart) * of_hole
        return _Gap(touch, apart - size, (x * dx + y * dy) / apart, slip)

    def _corner(self, corner: CornerAtWall) -> _Gap:
        symbols, play = self._symbols, corner.play
        across, tilt = (symbols.coordinates[own] for own in (play.offset, play.tilt))
        half = (
            side * symbols.parameter(size) / 2
            for side, size in ((corner.along, corner.length), (corner.across, corner.height))
        )
        arm = sp.rot_ccw_axis3(tilt)[:2, :2] * sp.Matrix([*half])
        wall = symbols.parameter(corner.height) / 2 + symbols.parameter(corner.size)
        depth = self._define("D", corner.across * (across + arm[1]) - wall)
        slid = self._rate(self._places.coordinate(play.slider) + arm[0])
        return _Gap(depth, depth, corner.across * self._rate(across + arm[1]), slid)

    def _wall(self, own: RoundAtWall, mechanism: Mechanism) -> _Gap:
        symbols, places = self._symbols, self._places
        (wall, through), (body, middle) = (
            mechanism.placed(*pair) for pair in ((own.wall, own.through), (own.body, own.joint))
        )
        ends = (components(places.joint(label)) for label in (middle, through))
        arm = [first - second for first, second in zip(*ends, strict=True)]
        radius = symbols.parameter(own.radius)
        if own.angle is None:
            touching = radius * (-1 if own.inside else 1) + symbols.parameter(own.circle)
            apart = self._define("D", sp.sqrt(arm[0] ** 2 + arm[1] ** 2))
            sense = -1 if own.inside else 1
            normal = [sense * part / apart for part in arm]
            depth = self._define("d", sense * (touching - apart))
            rate = -sp.Add(*(n * self._rate(part) for n, part in zip(normal, arm, strict=True)))
        else:
            turned = symbols.parameter(own.angle)
            if wall is not None:
                turned += places.orientation(wall)
            normal = [-sp.sin(turned), sp.cos(turned)]
            height = sp.Add(*(n * part for n, part in zip(normal, arm, strict=True)))
            depth, rate = self._define("d", radius - height), -self._rate(height)
        turning = places.turning(wall)
        slip = radius * (places.turning(body) - turning)
        slip += turning * (normal[0] * arm[0] + normal[1] * arm[1])
        slip += normal[1] * self._rate(arm[0]) - normal[0] * self._rate(arm[1])
        return _Gap(depth, depth, rate, slip)

    def _cam(self, own: FollowerOnCam) -> _Gap:
        symbols, places = self._symbols, self._places
        lift = law_of(own.lift, symbols, lambda _: places.coordinate(own.cam))
        room = places.coordinate(own.slider) - symbols.parameter(own.offset) - lift
        depth, slip, base = self._define("d", -room), sp.S.Zero, own.profile.base
        if own.profile.flat and base is not None:
            slip = (symbols.parameter(base) + lift) * places.turning(own.cam)
        return _Gap(depth, depth, -self._rate(room), slip)

    def _rate(self, value: sp.Expr) -> sp.Expr:
        return sp.Add(*(sp.diff(value, q) * rate for q, rate in self._symbols.rates.items()))

    def along(self, rate: sp.Symbol) -> sp.Expr:
        normal = self._force * sp.diff(self._deepening, rate)
        return self._friction * sp.diff(self._slip, rate) - normal
