"""Generalised forces of journals in bearings that they may leave."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, assert_never

import sympy as sp

from linkages.components.contributed.contacts import (
    Contact,
    CornerAtWall,
    NormalForce,
    OilFilm,
    PinInHole,
    RigidContact,
)
from linkages.components.contributed.functions import FIRST, Internal, Measured
from linkages.components.contributed.state_laws import leaves
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.equations.coefficients import Definition
from linkages.equations.films import FilmForces
from linkages.equations.laws import Select, law_of
from linkages.equations.loads import Forces
from linkages.equations.places import Places
from linkages.equations.symbols import Symbols


def require_forces_of_the_state(mechanism: Mechanism) -> None:
    """Impulses, and forces that depend on reactions or on how a contact began, have no closed form.

    Raises
    ------
    InputError
        For such laws.
    """
    reactions = (
        "the law depends on a reaction, which follows from accelerations: there are no equations "
        "in closed form; expected friction under a constant load"
    )
    found = [(load.path, reactions) for load in mechanism.loads if load.bearing is not None]
    for contact in mechanism.contacts:
        normal = contact.normal
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
        found.append(((*contact.path, "contact"), message))
    for path in dict.fromkeys(end.path for end in mechanism.ends):
        why = "impacts change rates at once, by no force: there are no equations in closed form"
        found.append(((*path, "restitution"), f"{why}; expected 'stiffness'"))
    if found:
        raise mechanism.error(found)


@dataclass(frozen=True)
class ContactForces:
    """What journals and bearings do to each other.

    Parameters
    ----------
    definitions
        Distances, rates, slips and forces of contacts, each from what stands before it.
    generalised
        Q of the coordinates that they act on, in N or N·m.
    """

    definitions: tuple[Definition, ...]
    generalised: Forces


def contact_forces(mechanism: Mechanism, symbols: Symbols, places: Places) -> ContactForces:
    """Normal forces and friction of all contacts."""
    definitions: list[Definition] = []
    total: Forces = {}
    for contact in mechanism.contacts:
        about = mechanism, symbols, places
        own: _Contact | FilmForces
        if isinstance(contact.normal, OilFilm):
            own = FilmForces(contact, contact.normal, *about)
        else:
            own = _Contact(contact, *about)
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


class _Contact:
    """One contact."""

    def __init__(
        self, contact: Contact, mechanism: Mechanism, symbols: Symbols, places: Places
    ) -> None:
        self._symbols, self._places = symbols, places
        self.definitions: list[Definition] = []
        normal, name = contact.normal, contact.name
        assert isinstance(normal, NormalForce)
        match contact.geometry:
            case PinInHole():
                gap = self._pin(contact.geometry, mechanism.carrier(contact.geometry.joint))
            case CornerAtWall():
                gap = self._corner(contact.geometry, name)
            case _:
                assert_never(contact.geometry)
        self._deepening, self._slip = gap.rate, gap.slip
        measured = _picked(gap.depth, self._define("v", name, gap.rate))
        force = law_of(normal.force, symbols, measured)
        if normal.pressing is not None:
            force = Select(law_of(normal.pressing, symbols, measured), force, sp.S.Zero)
        self._force = self._define("N", name, Select(gap.touch, force, sp.S.Zero))
        self._friction: sp.Expr = sp.S.Zero
        if contact.friction is not None:
            slip = self._define("w", name, self._slip)
            part = law_of(contact.friction, symbols, _picked(slip, slip))
            self._friction = self._define("F", name, self._force * part)

    def _pin(self, pin: PinInHole, other: str | None) -> _Gap:
        """Where the gap is open the distance counts as its size: nothing is 0/0."""
        symbols = self._symbols
        x, y = (symbols.coordinates[axis] for axis in pin.axes)
        dx, dy = symbols.rates[x], symbols.rates[y]
        size, radius = symbols.parameter(pin.size), symbols.parameter(pin.pin_radius)
        touch = x**2 + y**2 - size**2
        apart = self._define("D", pin.clearance, Select(touch, sp.sqrt(x**2 + y**2), size))
        bodies = (other, pin.body) if pin.hole else (pin.body, other)
        of_pin, of_hole = map(self._places.turning, bodies)
        slip = (x * dy - y * dx) / apart + radius * of_pin - (radius + apart) * of_hole
        return _Gap(touch, apart - size, (x * dx + y * dy) / apart, slip)

    def _corner(self, corner: CornerAtWall, name: str) -> _Gap:
        """A corner of a block and a wall of its guide."""
        symbols, play = self._symbols, corner.play
        across, tilt = (symbols.coordinates[own] for own in (play.offset, play.tilt))
        half = (
            side * symbols.parameter(size) / 2
            for side, size in ((corner.along, corner.length), (corner.across, corner.height))
        )
        arm = sp.rot_ccw_axis3(tilt)[:2, :2] * sp.Matrix([*half])
        wall = symbols.parameter(corner.height) / 2 + symbols.parameter(corner.size)
        depth = self._define("D", name, corner.across * (across + arm[1]) - wall)
        slid = self._rate(self._places.coordinate(play.slider) + arm[0])
        return _Gap(depth, depth, corner.across * self._rate(across + arm[1]), slid)

    def _define(self, letter: str, name: str, value: sp.Expr) -> sp.Symbol:
        symbol = self._symbols.define(letter, name)
        self.definitions.append(Definition(symbol, value))
        return symbol

    def _rate(self, value: sp.Expr) -> sp.Expr:
        """Rate of a function of the coordinates."""
        return sp.Add(*(sp.diff(value, q) * rate for q, rate in self._symbols.rates.items()))

    def along(self, rate: sp.Symbol) -> sp.Expr:
        """Work of both forces per unit of a coordinate with this rate."""
        normal = self._force * sp.diff(self._deepening, rate)
        return self._friction * sp.diff(self._slip, rate) - normal
