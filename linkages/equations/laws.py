"""Laws as SymPy expressions."""

from __future__ import annotations

import operator
from collections.abc import Callable
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
from linkages.equations.symbols import Symbols
from linkages.operations import COMPOSITE, ELEMENTARY

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
            found = [law_of(argument, symbols, measured) for argument in arguments]
            if name in COMPOSITE and name != "power":
                return COMPOSITE[name].expanded(_applied, *found)
            return _on_symbols(name)(*found)
        case _:
            assert_never(function)


def _applied(name: str, *operands: Any) -> Any:
    found = (exact(o) if isinstance(o, float) else o for o in operands)
    return _on_symbols(name)(*found)


def _on_symbols(name: str) -> Callable[..., Any]:
    """An elementary operation on expressions."""
    match name:
        case "power":
            return operator.pow
        case "select":
            return Select
    found = ELEMENTARY[name].among(sp) if name in ELEMENTARY else None
    if found is None:
        raise ValueError(f"no operation {name!r} in a function of time")
    return found


def exact(value: float) -> sp.Expr:
    """Return a constant of a formula as it is written: a short fraction, a multiple of π."""
    for unit in (sp.S.One, sp.pi):
        quotient = Fraction(value / float(unit)).limit_denominator(_LARGEST_DENOMINATOR)
        written = sp.Rational(quotient.numerator, quotient.denominator) * unit
        if abs(float(written) - value) <= 1e-15 * abs(value):
            return written
    return sp.Float(value)
