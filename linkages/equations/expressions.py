"""Symbols, plane vectors and laws as SymPy expressions.

The name of a symbol is an ASCII identifier. What text and LaTeX show is kept apart from it, so that
no name of the definition file is ever parsed.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, assert_never

import sympy as sp

from linkages.components.contributed.functions import (
    Function,
    Internal,
    Measured,
    Number,
    Operation,
    Table,
    Time,
)
from linkages.components.contributed.terms import Body, Parameter
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.operations import COMPOSITE, ELEMENTARY
from linkages.reading.paths import KeyPath, dotted

RIGHT_ANGLE = sp.pi / 2


@dataclass(frozen=True)
class Polar:
    """The vector length∠angle; angle in radians, counter-clockwise from +x."""

    length: sp.Expr
    angle: sp.Expr

    def __neg__(self) -> Polar:
        return Polar(-self.length, self.angle)

    @property
    def components(self) -> tuple[sp.Expr, sp.Expr]:
        """Its x and y components."""
        return self.length * sp.cos(self.angle), self.length * sp.sin(self.angle)

    def derivative(self, coordinate: sp.Symbol) -> Terms:
        """Return the partial derivative by its angle and by its length, without zeros."""
        turned = Polar(self.length * sp.diff(self.angle, coordinate), self.angle + RIGHT_ANGLE)
        grown = Polar(sp.diff(self.length, coordinate), self.angle)
        return tuple(term for term in (turned, grown) if term.length != 0)


Terms = tuple[Polar, ...]


def in_frame(angle: sp.Expr, x: sp.Expr, y: sp.Expr) -> Terms:
    """Return the vector with components x and y in a frame turned by an angle."""
    terms = Polar(x, angle), Polar(y, angle + RIGHT_ANGLE)
    return tuple(term for term in terms if term.length != 0)


def components(terms: Iterable[Polar]) -> tuple[sp.Expr, sp.Expr]:
    """Return the x and y components of a sum."""
    pairs = [term.components for term in terms]
    return sp.Add(*(x for x, _ in pairs)), sp.Add(*(y for _, y in pairs))


def derivative(terms: Iterable[Polar], coordinate: sp.Symbol) -> Terms:
    """Return the partial derivative of a sum, without zeros."""
    return tuple(part for term in terms for part in term.derivative(coordinate))


def dot(a: Terms, b: Terms) -> sp.Expr:
    """Scalar product of two sums."""
    return sp.Add(*(p.length * q.length * sp.cos(p.angle - q.angle) for p in a for q in b))


def cross(a: Terms, b: Terms) -> sp.Expr:
    """Third component of the vector product of two sums."""
    return sp.Add(*(p.length * q.length * sp.sin(q.angle - p.angle) for p in a for q in b))


def collected(terms: Iterable[Polar], apart: Iterable[sp.Symbol]) -> Terms:
    """Return the same sum with equal directions added up and zeros left out."""
    alone = set(apart)
    lengths: dict[tuple[sp.Expr, frozenset], sp.Expr] = {}
    for term in terms:
        key = (term.angle, frozenset(term.length.free_symbols & alone))
        lengths[key] = lengths.get(key, sp.S.Zero) + term.length
    return tuple(Polar(length, key[0]) for key, length in lengths.items() if length != 0)


_BY_KEY = {
    "length": "L", "mass": "m", "inertia": "J", "size": "r", "speed": "omega", "force": "F",
    "torque": "M", "stiffness": "k", "damping": "d", "dissipation": "a", "friction": "mu",
    "pin_radius": "R", "slip": "w",
}  # fmt: skip
_BY_PLACE = {
    "motors": {
        "stall_torque": "M 0", "no_load_speed": "omega 0", "gear_ratio": "n",
        "against": "n carrier", "rotor_inertia": "J", "torque_constant": "k", "resistance": "R",
        "voltage": "U", "inductance": "L",
    },
    "cylinders": {
        "bore": "D", "rod": "D rod", "pressure": "p", "rod_pressure": "p rod",
        "gas_pressure": "p 0", "ambient": "p a", "volume": "V 0", "exponent": "n",
    },
    "cams": {"offset": "s 0"},
    "drives": {"angle": "theta 0", "position": "s 0"},
    "gears": {"ratio": "i", "carrier": "i carrier", "angle": "phi"},
    "springs": {"angle": "phi"},
    "maxwell": {"stiffness": "k", "damping": "d"},
    "racks": {
        "radius": "R", "radius.inverse": "kappa", "carrier": "R carrier", "ratio": "i",
        "ratio.inverse": "i inverse", "offset": "s 0", "offset.inverse": "phi",
    },
    "stops": {"stiffness": "k", "damping": "d", "lower": "x lower", "upper": "x upper"},
    "friction": {
        "torque": "M", "force": "F", "static": "F static", "stribeck_speed": "v Stribeck",
        "slip_speed": "v slip",
    },
}  # fmt: skip
"""Section → keys → letter and further subscripts, behind the name or number of the entry."""

_AXES = ("x", "y")


@dataclass(frozen=True)
class Notation:
    """How a symbol is written."""

    letter: str  # a Latin letter, or the name of a Greek one
    subscripts: tuple[str, ...] = ()  # any texts
    dots: int = 0  # number of time derivatives

    @property
    def identifier(self) -> str:
        """A Python identifier; two notations may share it."""
        return "_".join(["d" * self.dots + self.letter, *map(_ascii, self.subscripts)])


def _ascii(text: str) -> str:
    spelt = "".join(c if c.isascii() else f"u{ord(c):x}" for c in text)
    return re.sub(r"[^0-9A-Za-z]", "_", spelt)


class Symbols:
    """Makes the symbols of one mechanism, each once."""

    def __init__(self, mechanism: Mechanism, followers: Collection[str] = ()) -> None:
        self.notations: dict[sp.Symbol, Notation] = {}
        self.values: dict[sp.Symbol, float] = {}
        self.paths: dict[sp.Symbol, KeyPath] = {}
        self.tables: list[Table] = []
        self._parameters: dict[KeyPath, sp.Symbol] = {}
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

    def _notation(self, path: KeyPath) -> tuple[str, ...]:
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


def _parameter_notation(path: KeyPath) -> tuple[str, ...]:
    """Letter and subscripts for what stands at a path of the definition file."""
    section, *rest = path
    keys = ".".join(key for key in rest[1:] if isinstance(key, str))
    if notation := _BY_PLACE.get(str(section), {}).get(keys):
        letter, *more = notation.split()
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
        case ("drives", str(body), "law", *place):
            return "p", body, *map(_counted, place)
        case ("masses", str(joint)):
            return "m", joint
        case ("dampers", int(index), "damping", *place):
            return "b", str(index + 1), *map(_counted, place)
        case ("loads" | "springs", int(index), str(key), *place) if key in _BY_KEY:
            return _BY_KEY[key], str(index + 1), *map(_counted, place)
        case (_, str(body), "angle"):
            return "phi", body
        case (_, str(body), str(key)) if key in _BY_KEY:
            return _BY_KEY[key], body
    return "p", *(str(element) for element in path)


def _counted(element: str | int) -> str:
    """An element of a path, places of a list counted from 1."""
    return str(element + 1) if isinstance(element, int) else element


_LARGEST_DENOMINATOR = 100


class Select(sp.Function):
    """``Select(c, a, b)`` is a where c ≥ 0, otherwise b."""

    nargs = 3

    @classmethod
    def eval(cls, condition: Any, first: Any, second: Any) -> Any:  # noqa: ARG003
        """Nothing is selected between equals."""
        return first if first == second else None

    def _eval_derivative(self, symbol: sp.Symbol) -> sp.Expr:
        condition, first, second = self.args
        return Select(condition, sp.diff(first, symbol), sp.diff(second, symbol))


class Spline(sp.Function):
    """``Spline(n, k, t)`` is the k-th derivative of the n-th table at time t."""

    nargs = 3

    def fdiff(self, argindex: int = 3) -> sp.Expr:
        """Return the next derivative."""
        number, order, time = self.args
        if argindex != 3:
            raise sp.ArgumentIndexError(self, argindex)
        return Spline(number, order + 1, time)


def _of_time_alone(_: Measured | Internal) -> sp.Expr:
    raise ValueError("a function of time is not measured along anything")


def law_of(
    function: Function,
    symbols: Symbols,
    measured: Callable[[Measured | Internal], sp.Expr] = _of_time_alone,
) -> sp.Expr:
    """Return a law over the symbols of its numbers, of time, and of what it is `measured` by."""
    match function:
        case Number(parameter):
            return symbols.parameter(parameter) if parameter.path else exact(parameter.value)
        case Time():
            return symbols.time
        case Measured() | Internal():
            return measured(function)
        case Table():
            over = law_of(function.over, symbols, measured)
            return Spline(symbols.table(function), 0, over)
        case Operation(name, arguments):
            result = [law_of(argument, symbols, measured) for argument in arguments]
            if name in COMPOSITE and name != "power":
                return COMPOSITE[name].expanded(_applied, *result)
            return _on_symbols(name)(*result)
        case _:
            assert_never(function)


def _applied(name: str, *operands: Any) -> Any:
    result = (exact(o) if isinstance(o, float) else o for o in operands)
    return _on_symbols(name)(*result)


def _on_symbols(name: str) -> Callable[..., Any]:
    match name:
        case "power":
            return operator.pow
        case "select":
            return Select
    result = ELEMENTARY[name].among(sp) if name in ELEMENTARY else None
    if result is None:
        raise ValueError(f"no operation {name!r} in a function of time")
    return result


def exact(value: float) -> sp.Expr:
    """Return a constant of a formula as it is written: a short fraction, a multiple of π."""
    for unit in (sp.S.One, sp.pi):
        quotient = Fraction(value / float(unit)).limit_denominator(_LARGEST_DENOMINATOR)
        written = sp.Rational(quotient.numerator, quotient.denominator) * unit
        if abs(float(written) - value) <= 1e-15 * abs(value):
            return written
    return sp.Float(value)
