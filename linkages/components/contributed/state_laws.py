"""Laws of state and internal states.

A law is a function of a value x, its rate v and time, and of whatever else it senses. Nothing here
knows what x measures.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce

from linkages.components.contributed.functions import (
    Function,
    Internal,
    Measured,
    Number,
    Operation,
    Table,
    Time,
    V,
    X,
    constant,
)
from linkages.components.contributed.terms import ZERO
from linkages.operations import ELEMENTARY
from linkages.reading.paths import KeyPath, dotted

NOTHING = Number(ZERO)
"""The law of a load that exact zeros remove."""

_MINUS = constant(-1.0)


def leaves(function: Function) -> Iterator[Function]:
    """What operations end in, from left to right; tables, then what they are functions of."""
    match function:
        case Operation(_, arguments):
            for argument in arguments:
                yield from leaves(argument)
        case Table():
            yield function
            yield from leaves(function.over)
        case _:
            yield function


def exchanged(function: Function, other: Callable[[Measured], Function]) -> Function:
    """The same function with something else in the place of what it senses."""
    match function:
        case Measured():
            return other(function)
        case Operation(name, arguments):
            return Operation(name, tuple(exchanged(argument, other) for argument in arguments))
        case Table():
            return replace(function, over=exchanged(function.over, other))
    return function


def measured_in(function: Function) -> Iterator[Measured]:
    """All values and rates that a function depends on."""
    return (leaf for leaf in leaves(function) if isinstance(leaf, Measured))


def variables(function: Function) -> list[str]:
    """What a function depends on: ``"x"``, ``"v"``, ``"t"``, and ``"other"`` measures."""
    result = set(leaves(function))
    other = internal(function) or any(m.measure is not None for m in measured_in(function))
    there = {"x": X in result, "v": V in result, "t": Time() in result, "other": other}
    return [name for name, occurs in there.items() if occurs]


def internal(function: Function) -> bool:
    """Whether a function depends on an internal state."""
    return any(isinstance(leaf, Internal) for leaf in leaves(function))


def rated(function: Function) -> bool:
    """Whether a function depends on a rate."""
    return any(leaf.order for leaf in measured_in(function))


_EVERYWHERE = (
    "add", "sub", "mul", "neg", "power", "abs", "min", "max", "sign", "where", "select",
    "sin", "cos", "atan", "tanh",
)  # fmt: skip


def everywhere(function: Function) -> bool:
    """Whether a function has a value wherever its measures have one."""
    match function:
        case Operation(name, arguments):
            return name in _EVERYWHERE and all(map(everywhere, arguments))
        case Table():
            return everywhere(function.over)
    return True


def of_state(function: Function) -> bool:
    """Whether a function depends on the state: on a measure, or on an internal state."""
    return any(isinstance(leaf, Measured | Internal) for leaf in leaves(function))


def _of_own(function: Function) -> bool:
    """Whether x or v is in it."""
    return any(leaf.measure is None for leaf in measured_in(function))


def time_functions(law: Function) -> Iterator[Function]:
    """The largest parts of a law that depend on time, but on no measure.

    Of a sum within a sine the part that depends on time is within a sine as well: it repeats.
    """
    if not of_state(law):
        if variables(law):
            yield law
        return
    match law:
        case Operation(name, (argument,)) if name in ELEMENTARY and ELEMENTARY[name].periodic:
            inner = _time_part(argument)
            yield from () if inner is None else (Operation(name, (inner,)),)
        case Table() if law.periodic:
            inner = _time_part(law.over)
            yield from () if inner is None else (replace(law, over=inner),)
        case Table():
            yield from time_functions(law.over)
        case Operation(_, arguments):
            for argument in arguments:
                yield from time_functions(argument)


def _time_part(argument: Function) -> Function | None:
    """The terms of a sum that depend on time alone; None without any, or where others do too."""
    terms = list(addends(argument))
    timed = [term for term in terms if "t" in variables(term)]
    return sum_of(timed) if timed and not any(map(of_state, timed)) else None


def winding(function: Function) -> list[Measured]:
    """The angles among what a function senses whose whole turns count."""
    result = dict.fromkeys(leaf for leaf in measured_in(function) if leaf.order == 0)
    return [angle for angle in result if _per_turn(function, angle) != 0.0]


def _per_turn(function: Function, angle: Measured) -> float | None:
    """By how many turns a function grows when an angle makes one; None if that is no number."""
    match function:
        case Measured():
            return 1.0 if function == angle else 0.0
        case Number() | Time() | Internal():
            return 0.0
        case Table():
            grown = _per_turn(function.over, angle)
            repeats = function.turning and grown is not None and grown.is_integer()
            return 0.0 if grown == 0.0 or repeats else None
        case Operation(name, arguments):
            return _grown(name, arguments, [_per_turn(a, angle) for a in arguments])


def _grown(name: str, arguments: tuple[Function, ...], grown: list[float | None]) -> float | None:
    match name, arguments, grown:
        case _ if all(part == 0.0 for part in grown):
            return 0.0
        case "neg", _, [float(a)]:
            return -a
        case "add" | "sub", _, [float(a), float(b)]:
            return a + b if name == "add" else a - b
        case "mul", (Number(parameter), _), [_, float(a)] if not parameter.path:
            return parameter.value * a
        case _, _, [float(a)] if name in ELEMENTARY and ELEMENTARY[name].periodic:
            return 0.0 if a.is_integer() else None
    return None


def _vanishes(function: Function) -> bool:
    """Whether it is zero by structure."""
    return isinstance(function, Number) and (function.parameter.absent or function == constant(0.0))


def folded(law: Function) -> Function:
    """The same law without what exact zeros remove; `NOTHING` if they remove all of it."""
    if not isinstance(law, Operation):
        return NOTHING if _vanishes(law) else law
    arguments = tuple(folded(argument) for argument in law.arguments)
    match law.name, arguments, tuple(argument == NOTHING for argument in arguments):
        case "add", (_, b), (True, _):
            return b
        case "add" | "sub", (a, _), (_, True):
            return a
        case "sub", (_, b), (True, _):
            return negated(b)
        case ("mul", _, (True, _) | (_, True)) | ("div", _, (True, _)) | ("neg", _, (True,)):
            return NOTHING
        case "power", (_, Number(exponent)), (True, False) if exponent.value > 0:
            return NOTHING
    return Operation(law.name, arguments)


def negated(function: Function) -> Function:
    """Its opposite."""
    if isinstance(function, Operation) and function.name == "neg":
        return function.arguments[0]
    return Operation("neg", (function,))


def addends(law: Function) -> Iterator[Function]:
    """The terms whose sum a law is."""
    match law:
        case Operation("neg", (a,)):
            yield from map(negated, addends(a))
        case Operation("add", (a, b)):
            yield from (*addends(a), *addends(b))
        case Operation("sub", (a, b)):
            yield from (*addends(a), *map(negated, addends(b)))
        case _:
            yield law


def sum_of(terms: Iterable[Function]) -> Function:
    """The sum of some terms; `NOTHING` without any."""
    result = list(terms)
    return reduce(lambda a, b: Operation("add", (a, b)), result) if result else NOTHING


def _factors(term: Function) -> list[Function]:
    """What a term is a product of; a difference from a constant counts from the constant."""
    match term:
        case Operation("neg", (a,)):
            return [_MINUS, *_factors(a)]
        case Operation("mul", (a, b)):
            return [*_factors(a), *_factors(b)]
        case Operation("div", (a, b)) if not _of_own(b):
            return [*_factors(a), Operation("div", (constant(1.0), b))]
        case Operation("power", (a, Number(n))) if n.value >= 1 and _of_own(a):
            return _factors(a) * int(n.value)
        case Operation("sub", (a, b)) if _of_own(b) and not _of_own(a):
            return [_MINUS, Operation("sub", (b, a))]
    return [term]


def _product(factors: Sequence[Function]) -> Function:
    result = [factor for factor in factors if factor != _MINUS]
    if not result:
        result = [constant(1.0)]
    total = reduce(lambda a, b: Operation("mul", (a, b)), result)
    return negated(total) if factors.count(_MINUS) % 2 else total


def _shifted(function: Function) -> bool:
    """Whether it is x, or x less or more a constant."""
    match function:
        case Operation("sub" | "add", (a, b)) if a == X:
            return not _of_own(b)
        case Operation("add", (a, b)) if b == X:
            return not _of_own(a)
    return function == X


@dataclass(frozen=True)
class Monomial:
    """A term coefficient · base^degree · v^rate."""

    coefficient: Function  # without x and v; it may sense other measures
    base: Function | None  # x, or x less a constant; None where neither is in it
    # Exponents, ≥ 0
    degree: int
    rate: int

    def over(self, divisor: Measured) -> Function:
        """The term divided by x or v, which it is a multiple of."""
        powers = [(self.base or X, self.degree - (divisor == X)), (V, self.rate - (divisor == V))]
        factors = [Operation("power", (f, constant(float(n)))) for f, n in powers if n > 0]
        return reduce(lambda a, b: Operation("mul", (a, b)), factors, self.coefficient)


def monomial(term: Function) -> Monomial | None:
    """A term as powers of x (or x less a constant) and v; None if it is none."""
    factors = _factors(term)
    own = [factor for factor in factors if _of_own(factor)]
    bases = [factor for factor in own if factor != V]
    if len(set(bases)) > 1 or not all(map(_shifted, bases)):
        return None
    coefficient = _product([factor for factor in factors if not _of_own(factor)])
    return Monomial(coefficient, bases[0] if bases else None, len(bases), len(own) - len(bases))


def stored(term: Function) -> Function | None:
    """The potential energy −∫ term dx of a polynomial in x; None for any other term.

    A multiple of (x − c)ⁿ is integrated from c, so that a relaxed spring has none.
    """
    if variables(term) != ["x"]:
        return None
    return _integral([_MINUS, *_factors(term)])


def _integral(factors: list[Function]) -> Function | None:
    """The integral over x of a product; sums in it are multiplied out where it has to be."""
    term = monomial(_product(factors))
    if term is not None:
        exponent = constant(term.degree + 1.0)
        raised = Operation("power", (term.base or X, exponent)) if term.base else X
        return Operation("div", (_product([*_factors(term.coefficient), raised]), exponent))
    for place, factor in enumerate(factors):
        terms = list(addends(factor))
        if len(terms) > 1 and _of_own(factor):
            others = factors[:place] + factors[place + 1 :]
            parts = [_integral([*others, *_factors(part)]) for part in terms]
            return None if None in parts else sum_of(part for part in parts if part)
    return None


STATES = "states"
"""The section of states that have an equation of their own."""


@dataclass(frozen=True)
class InternalState:
    """A quantity z with dz/dt = f(z, x, v, t): a current, a deflection, an integral, a pressure.

    It belongs to a load, or is a term of its own. One that is sampled is constant, but for
    multiples of a period, where it becomes f.
    """

    # Where it stands in the definition file, or would: then that of its load and a word
    path: KeyPath
    unit: str  # in SI
    # f: a function of time, of measures and of internal states; of one that belongs to a load also
    # of what that acts along
    law: Function
    scale: float = 1.0  # what is large for it, in its unit: absolute tolerances are parts of this
    initial: float = 0.0  # its value at the start
    # Seconds from one update to the next of a state that is sampled; None for any other
    period: Number | None = None

    @property
    def name(self) -> str:
        """What laws and results call it; no body has a name with dots."""
        return dotted(self.path)

    @property
    def value(self) -> Internal:
        """Its value, in laws."""
        return value_of(self.path)


def value_of(path: KeyPath) -> Internal:
    """The value of the internal state at a path, in laws."""
    return Internal(dotted(path))
