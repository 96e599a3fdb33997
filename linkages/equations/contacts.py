"""Generalised forces of pins in holes that they may leave."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import sympy as sp

from linkages.components.contributed.contacts import Contact, NormalForce, RigidContact
from linkages.components.contributed.functions import FIRST, Internal, Measured
from linkages.components.contributed.state_laws import leaves
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.equations.coefficients import Definition
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
        elif FIRST in leaves(normal.force):
            why = "the force depends on the rate at which each contact began"
        else:
            continue
        message = (
            f"{why}, which is no function of the state: there are no equations in closed form; "
            "expected a law without that (hertz, hunt-crossley-constant, kelvin-voigt)"
        )
        found.append(((*contact.path, "contact"), message))
    if found:
        raise mechanism.error(found)


@dataclass(frozen=True)
class ContactForces:
    """What pins and holes do to each other.

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
        own = _Contact(contact, mechanism, symbols, places)
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


class _Contact:
    """One contact; where its gap is open the distance counts as its size: nothing is 0/0."""

    def __init__(
        self, contact: Contact, mechanism: Mechanism, symbols: Symbols, places: Places
    ) -> None:
        self._symbols, self._places = symbols, places
        self.definitions: list[Definition] = []
        normal, name = contact.normal, contact.name
        assert isinstance(normal, NormalForce)
        x, y = (symbols.coordinates[axis] for axis in contact.axes)
        dx, dy = symbols.rates[x], symbols.rates[y]
        size, radius = symbols.parameter(contact.size), symbols.parameter(contact.pin_radius)
        touch = x**2 + y**2 - size**2
        apart = self._define("D", name, Select(touch, sp.sqrt(x**2 + y**2), size))
        other = mechanism.carrier(contact.joint)
        bodies = (other, contact.body) if contact.hole else (contact.body, other)
        pin, hole = map(self._turning, bodies)
        self._deepening = (x * dx + y * dy) / apart
        self._slip = (x * dy - y * dx) / apart + radius * pin - (radius + apart) * hole
        measured = _picked(apart - size, self._define("v", name, self._deepening))
        force = law_of(normal.force, symbols, measured)
        if normal.pressing is not None:
            force = Select(law_of(normal.pressing, symbols, measured), force, sp.S.Zero)
        self._force = self._define("N", name, Select(touch, force, sp.S.Zero))
        self._friction: sp.Expr = sp.S.Zero
        if contact.friction is not None:
            slip = self._define("w", name, self._slip)
            part = law_of(contact.friction.coefficient, symbols, _picked(slip, slip))
            self._friction = self._define("F", name, self._force * part)

    def _define(self, letter: str, name: str, value: sp.Expr) -> sp.Symbol:
        symbol = self._symbols.define(letter, name)
        self.definitions.append(Definition(symbol, value))
        return symbol

    def _turning(self, body: str | None) -> sp.Expr:
        """Angular speed of a body (None: the ground)."""
        if body is None:
            return sp.S.Zero
        angle = self._places.orientation(body)
        return sp.Add(*(sp.diff(angle, q) * rate for q, rate in self._symbols.rates.items()))

    def along(self, rate: sp.Symbol) -> sp.Expr:
        """Work of both forces per unit of a coordinate with this rate."""
        normal = self._force * sp.diff(self._deepening, rate)
        return self._friction * sp.diff(self._slip, rate) - normal
