"""Symbols of a mechanism and how they are written.

The name of a symbol is an ASCII identifier, unique within the mechanism. What text and LaTeX show
is kept apart from it, so a name of the definition file is never parsed, whatever it consists of.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass, replace

import sympy as sp

from linkages.components.contributed.functions import Table
from linkages.components.contributed.terms import Body, Parameter, Path
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.reading.paths import dotted

_BY_KEY = {
    "length": "L",
    "mass": "m",
    "inertia": "J",
    "size": "r",
    "speed": "omega",
    "force": "F",
    "torque": "M",
    "stiffness": "k",
    "damping": "d",
    "dissipation": "a",
    "friction": "mu",
    "pin_radius": "R",
    "slip": "w",
}
_BY_PLACE: dict[tuple[str | int, ...], tuple[str, ...]] = {
    ("motors", "stall_torque"): ("M", "0"),
    ("motors", "no_load_speed"): ("omega", "0"),
    ("motors", "gear_ratio"): ("n",),
    ("motors", "against"): ("n", "carrier"),
    ("motors", "rotor_inertia"): ("J",),
    ("motors", "torque_constant"): ("k",),
    ("motors", "resistance"): ("R",),
    ("motors", "voltage"): ("U",),
    ("motors", "inductance"): ("L",),
    ("cylinders", "bore"): ("D",),
    ("cylinders", "rod"): ("D", "rod"),
    ("cylinders", "pressure"): ("p",),
    ("cylinders", "rod_pressure"): ("p", "rod"),
    ("cylinders", "gas_pressure"): ("p", "0"),
    ("cylinders", "ambient"): ("p", "a"),
    ("cylinders", "volume"): ("V", "0"),
    ("cylinders", "exponent"): ("n",),
    ("cams", "offset"): ("s", "0"),
    ("maxwell", "stiffness"): ("k",),
    ("maxwell", "damping"): ("d",),
    ("racks", "radius"): ("R",),
    ("racks", "radius", "inverse"): ("kappa",),
    ("racks", "carrier"): ("R", "carrier"),
    ("racks", "ratio"): ("i",),
    ("racks", "ratio", "inverse"): ("i", "inverse"),
    ("racks", "offset"): ("s", "0"),
    ("racks", "offset", "inverse"): ("phi",),
    ("stops", "stiffness"): ("k",),
    ("stops", "damping"): ("d",),
    ("stops", "lower"): ("x", "lower"),
    ("stops", "upper"): ("x", "upper"),
    ("friction", "torque"): ("M",),
    ("friction", "force"): ("F",),
    ("friction", "static"): ("F", "static"),
    ("friction", "stribeck_speed"): ("v", "Stribeck"),
    ("friction", "slip_speed"): ("v", "slip"),
}
"""Section and keys → letter and further subscripts, behind the name or number of the entry."""

_AXES = ("x", "y")


@dataclass(frozen=True)
class Notation:
    """How a symbol is written.

    Parameters
    ----------
    letter
        A Latin letter, or the name of a Greek one.
    subscripts
        Any texts.
    dots
        Number of time derivatives.
    """

    letter: str
    subscripts: tuple[str, ...] = ()
    dots: int = 0

    @property
    def identifier(self) -> str:
        """A Python identifier; two notations may share it."""
        return "_".join(["d" * self.dots + self.letter, *map(_ascii, self.subscripts)])


def _ascii(text: str) -> str:
    spelt = "".join(c if c.isascii() else f"u{ord(c):x}" for c in text)
    return re.sub(r"[^0-9A-Za-z]", "_", spelt)


class Symbols:
    """Makes the symbols of one mechanism, each once.

    Parameters
    ----------
    mechanism
        Its bodies give the coordinates; parameters become symbols when they are first used.
    followers
        Bodies without a coordinate of their own: welds and gears turn them.

    Attributes
    ----------
    coordinates
        Body → its angle (rad) or displacement (m).
    followers
        Body that follows others → the symbol of its angle in print.
    rates
        Coordinate → its time derivative.
    internal
        Internal state → its symbol.
    values
        Parameter symbol → value in SI.
    paths
        Parameter symbol → its place in the definition file.
    notations
        Symbol → how it is written.
    tables
        Laws that are splines: f_1, f_2, …
    """

    def __init__(self, mechanism: Mechanism, followers: Collection[str] = ()) -> None:
        self.notations: dict[sp.Symbol, Notation] = {}
        self.values: dict[sp.Symbol, float] = {}
        self.paths: dict[sp.Symbol, Path] = {}
        self.tables: list[Table] = []
        self._parameters: dict[Path, sp.Symbol] = {}
        self._sliders = {body.name for body in mechanism.bodies.values() if not body.rotates}
        bodies = [body for body in mechanism.bodies.values() if body.name not in followers]
        self.time = self.define("t")
        self.coordinates = {b.name: self.define(_coordinate_letter(b), b.name) for b in bodies}
        follow = [mechanism.bodies[name] for name in followers]
        self.followers = {b.name: self.define(_coordinate_letter(b), b.name) for b in follow}
        self.rates = {q: self.dotted(q) for q in self.coordinates.values()}
        states = mechanism.internal.values()
        self.internal = {z.name: self.define("z", *map(_counted, z.path[1:])) for z in states}

    def define(self, letter: str, *subscripts: str, dots: int = 0) -> sp.Symbol:
        """Make a new real symbol whose identifier and looks are its own."""
        notation = Notation(letter, subscripts, dots)
        while notation in self.notations.values():
            notation = replace(
                notation, subscripts=(*subscripts[:-1], notation.subscripts[-1] + "'")
            )
        taken = {symbol.name for symbol in self.notations}
        name, count = notation.identifier, 1
        while name in taken:
            count += 1
            name = f"{notation.identifier}_{count}"
        symbol = sp.Symbol(name, real=True)
        self.notations[symbol] = notation
        return symbol

    def dotted(self, symbol: sp.Symbol, dots: int = 1) -> sp.Symbol:
        """Make the symbol of a time derivative."""
        notation = self.notations[symbol]
        return self.define(notation.letter, *notation.subscripts, dots=dots)

    def parameter(self, parameter: Parameter, notation: tuple[str, ...] = ()) -> sp.Expr:
        """Return the symbol of a number of the definition file; a structural zero is 0.

        Its letter and subscripts follow from its path unless they are given.
        """
        if parameter.absent:
            return sp.S.Zero
        if parameter.path not in self._parameters:
            symbol = self.define(*(notation or self._notation(parameter.path)))
            self._parameters[parameter.path] = symbol
            self.values[symbol] = parameter.value
            self.paths[symbol] = parameter.path
        return self._parameters[parameter.path]

    def _notation(self, path: Path) -> tuple[str, ...]:
        match path:
            case ("drives", str(body), "speed") if body in self._sliders:
                return "v", body
        return _parameter_notation(path)

    def table(self, table: Table) -> int:
        """Return the number of a spline, from 1."""
        if table not in self.tables:
            self.tables.append(table)
        return self.tables.index(table) + 1

    def pair(self, pair: tuple[Parameter, Parameter]) -> tuple[sp.Expr, sp.Expr]:
        """Return the symbols of two numbers of the definition file."""
        return self.parameter(pair[0]), self.parameter(pair[1])

    def describe(self, symbol: sp.Symbol) -> str:
        """Return the dotted path of a parameter in the definition file."""
        return dotted(self.paths[symbol])


def _coordinate_letter(body: Body) -> str:
    if not body.rotates:
        return "s"
    return "alpha" if body.kind == "clearance" else "theta"


def _parameter_notation(path: Path) -> tuple[str, ...]:
    """Letter and subscripts for what stands at a path of the definition file."""
    section, *rest = path
    keys = tuple(key for key in rest[1:] if isinstance(key, str))
    if (section, *keys) in _BY_PLACE:
        letter, *more = _BY_PLACE[section, *keys]
        numbers = (number for number in rest[1:] if isinstance(number, int))
        return (letter, _counted(rest[0]), *more, *map(_counted, numbers))
    match path:
        case ("gravity", int(axis)):
            return "g", _AXES[axis]
        case ("joints", str(joint), int(axis)):
            return _AXES[axis], joint
        case (_, str(body), "points", str(joint), int(axis)):
            return _AXES[axis], body, joint
        case (_, str(body), "center", int(axis)):
            return ("c", "e")[axis], body
        case ("sliders", str(body), "through", int(axis)):
            return _AXES[axis], body, "0"
        case ("drives", str(body), "angle"):
            return "theta", body, "0"
        case ("drives", str(body), "position"):
            return "s", body, "0"
        case ("drives", str(body), "law", *place):
            return "p", body, *map(_counted, place)
        case ("masses", str(joint)):
            return "m", joint
        case ("gears", int(index), "ratio"):
            return "i", str(index + 1)
        case ("gears", int(index), "carrier"):
            return "i", str(index + 1), "carrier"
        case ("dampers", int(index), "damping", *place):
            return "b", str(index + 1), *map(_counted, place)
        case ("loads" | "springs", int(index), str(key), *place) if key in _BY_KEY:
            return _BY_KEY[key], str(index + 1), *map(_counted, place)
        case ("springs" | "gears", int(index), "angle"):
            return "phi", str(index + 1)
        case (_, str(body), "angle"):
            return "phi", body
        case (_, str(body), str(key)) if key in _BY_KEY:
            return _BY_KEY[key], body
    return "p", *(str(element) for element in path)


def _counted(element: str | int) -> str:
    """An element of a path, places of a list counted from 1."""
    return str(element + 1) if isinstance(element, int) else element
