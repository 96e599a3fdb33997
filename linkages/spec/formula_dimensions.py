"""What formulas with units measure: terms of a sum alike, functions of pure numbers, and so on.

A formula without any unit is in SI and is not looked at. As soon as one number has a unit, all
numbers are what they say: one without a unit is a pure number, and only 0 may be anything. Named
quantities and t bring their dimension along. The radian counts as one, as in SI.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import TypeAlias, assert_never

from linkages.spec.dimensions import KNOWN, Dimension
from linkages.spec.formulas import Call, Clock, Constant, Formula, Node, Sensed
from linkages.spec.grammar import NumberError, Span
from linkages.spec.units import Unit, unit

Powers: TypeAlias = dict[str, Fraction]
"""Base unit → its power, those of zero left out; None in its place: a zero, which is anything."""

PURE: Powers = {}
_ALIKE = ("add", "sub", "min", "max", "where", "atan2")
TIME: Powers = {"second": Fraction(1)}
_SYMBOLS = {"meter": "m", "kilogram": "kg", "second": "s", "kelvin": "K", "ampere": "A"}


def powers(found: Unit) -> Powers:
    """The powers of base units, without the radian."""
    return {base: Fraction(power) for base, power in found.exponents if base != "radian"}


def described(found: Powers) -> str:
    """A dimension in words, with its unit: ``"a force (N)"``."""
    if not found:
        return "an angle or a pure number"
    for known in KNOWN:
        if powers(unit(known.unit)) == found:
            return f"{known.article} ({known.unit.replace('**', '^').replace('*', ' ')})"
    above = [_power(base, power) for base, power in found.items() if power > 0]
    below = [_power(base, -power) for base, power in found.items() if power < 0]
    return f"a quantity in {' '.join(above) or '1'}{''.join('/' + part for part in below)}"


def _power(base: str, power: Fraction) -> str:
    return _SYMBOLS.get(base, base) + ("" if power == 1 else f"^{power}")


def require(
    formula: Formula,
    expected: Dimension,
    powers_of: Callable[[Sensed], Powers | None],
    shared: bool = False,
) -> None:
    """Make sure that a formula measures what stands in its place.

    Parameters
    ----------
    formula
        Without units it is in SI, and passes.
    expected
        What is asked for.
    powers_of
        What a named quantity measures; None if that is not said.
    shared
        Whether a parameter in it has a unit, so that all numbers are what they say.

    Raises
    ------
    NumberError
        With what was found, and what is expected.
    """
    if not (formula.has_units or shared):
        return
    found = measured(formula, powers_of)
    wanted = powers(unit(expected.unit)) if expected.unit else PURE
    if found is not None and found != wanted:
        raise NumberError(f"it is {described(found)}, not {expected.article}")


def measured(formula: Formula, powers_of: Callable[[Sensed], Powers | None]) -> Powers | None:
    """What a formula with units measures; None if it is zero. Raises as `require` does."""
    return Measuring(formula.text, powers_of).of(formula.tree)


class Measuring:
    """What the nodes of a formula measure.

    Parameters
    ----------
    text
        The formula, for messages.
    powers_of
        What a named quantity measures; None if that is not said.
    """

    def __init__(self, text: str, powers_of: Callable[[Sensed], Powers | None]) -> None:
        self._text, self._powers_of = text, powers_of

    def of(self, node: Node) -> Powers | None:
        """What a node measures; None if it is zero. Raises as `require` does."""
        match node:
            case Constant(value, found):
                if found is not None:
                    return powers(found)
                return None if value == 0.0 else PURE
            case Clock():
                return TIME
            case Sensed():
                return self._powers_of(node)
            case Call("power", (base, Constant(exponent))):
                return raised(self.of(base), Fraction(int(exponent)))
            case Call(name, arguments, _, span):
                return self.called(name, [*map(self.of, arguments)], arguments, span)
            case _:
                assert_never(node)

    def called(
        self, name: str, found: list[Powers | None], arguments: tuple[Node, ...], span: Span
    ) -> Powers | None:
        """What an operation measures.

        Parameters
        ----------
        name, arguments, span
            Of the call.
        found
            What the arguments measure.
        """
        match name:
            case "neg" | "abs":
                return found[0]
            case "sign":
                return PURE
            case "mul" | "div":
                first, second = found
                if first is None or second is None:
                    return None
                return times(first, raised(second, Fraction(1 if name == "mul" else -1)) or PURE)
            case "sqrt":
                return raised(found[0], Fraction(1, 2))
            case _ if name in _ALIKE:
                begin = 1 if name == "where" else 0
                alike = self.alike(found[begin:], arguments[begin:], span)
                return PURE if name == "atan2" else alike
        for argument in found:
            if argument:
                message = f"{name!r} takes an angle or a pure number, found {described(argument)}"
                hint = "; multiply it by a rate, such as 2 rad/s" if argument == TIME else ""
                raise NumberError(f"{message} in {self._at(span)}{hint}", at=span[0])
        return PURE

    def alike(
        self,
        found: list[Powers | None],
        arguments: tuple[Node, ...],  # noqa: ARG002
        span: Span,
    ) -> Powers | None:
        """What terms of a sum have in common; the arguments are those of `called`."""
        known = [entry for entry in found if entry is not None]
        for other in known[1:]:
            if other != known[0]:
                both = f"{described(known[0])} and {described(other)}"
                raise NumberError(f"{both} do not go together in {self._at(span)}", at=span[0])
        return known[0] if known else None

    def _at(self, span: Span) -> str:
        return repr(self._text[slice(*span)].strip())


def raised(found: Powers | None, exponent: Fraction) -> Powers | None:
    """The dimension of a power."""
    return None if found is None else {base: power * exponent for base, power in found.items()}


def product(first: Powers, *others: tuple[Powers, int]) -> Powers:
    """A dimension times whole powers of others."""
    for other, exponent in others:
        first = times(first, raised(other, Fraction(exponent)) or PURE)
    return first


def times(first: Powers, second: Powers) -> Powers:
    """The dimension of a product."""
    total = {base: first.get(base, Fraction(0)) + second.get(base, Fraction(0))
             for base in dict.fromkeys((*first, *second))}  # fmt: skip
    return {base: power for base, power in total.items() if power}
