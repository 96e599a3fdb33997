"""Generalised forces of films of oil between journals and bearings: short journal bearings."""

from __future__ import annotations

import sympy as sp

from linkages.components.contributed.contacts import Contact, OilFilm, PinInHole
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.equations.coefficients import Definition
from linkages.equations.places import Places
from linkages.equations.symbols import Symbols


class FilmForces:
    """One film; `linkages.kernel.forces.films` derives the force.

    Attributes
    ----------
    definitions
        Of the velocity with which it is squeezed, of where the centres are as seen from that, and
        of the force, each from what stands before it.
    """

    def __init__(
        self,
        contact: Contact,
        film: OilFilm,
        mechanism: Mechanism,
        symbols: Symbols,
        places: Places,
    ) -> None:
        self._symbols, self._name = symbols, contact.name
        self.definitions: list[Definition] = []
        pin = contact.geometry
        assert isinstance(pin, PinInHole), "films are between journals and bearings"
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

    def _define(self, letter: str, value: sp.Expr) -> sp.Symbol:
        symbol = self._symbols.define(letter, self._name)
        self.definitions.append(Definition(symbol, value))
        return symbol

    def along(self, rate: sp.Symbol) -> sp.Expr:
        """Work of pressure and shear per unit of a coordinate with this rate."""
        pairs = zip(self._force, self._squeezed, strict=True)
        squeezing = sp.Add(*(force * sp.diff(along, rate) for force, along in pairs))
        return squeezing - self._torque * sp.diff(self._sheared, rate)
