"""What is sought and what must hold, as texts; and as sums of peaks and of other measures.

A peak, ``max(x)`` or ``min(x)``, has corners where another maximum of x takes the lead. Where less
of it is better, it is replaced by a number s of its own under conditions x(t) ≤ s at all maxima,
which are smooth (the epigraph of a minimax problem). That holds for sums of multiples of peaks, and
for constraints. Any other measure is taken as it is.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, NamedTuple

from linkages.spec.formulas import Call, Constant, Formula, Node
from linkages.spec.measures import Measure, read_measure, reduces

_COMPARED = re.compile(r"(<=|>=|==|=|<|>|≤|≥)")
_LESS = ("<", "<=", "≤")
_EQUAL = ("=", "==")

CONSTRAINT = "min(piston.velocity) > -6 m/s"


class Peak(NamedTuple):
    """A multiple of the largest value of a series, or of the largest value of its negative.

    Parameters
    ----------
    factor
        Above zero.
    series
        Text of what changes with time.
    sign
        1, or −1 for the negative.
    """

    factor: float
    series: str
    sign: float


class Plain(NamedTuple):
    """A multiple of a measure that is taken as it is."""

    factor: float
    measure: str


@dataclass(frozen=True)
class Sum:
    """A constant and parts, of which less is better."""

    constant: float
    parts: tuple[Peak | Plain, ...]


@dataclass(frozen=True)
class Goal:
    """What is made least or greatest.

    Parameters
    ----------
    measure
        As it was asked for.
    sense
        What is done with it.
    """

    measure: Measure
    sense: Literal["minimise", "maximise"]

    @property
    def text(self) -> str:
        """In words."""
        return f"{self.sense} {self.measure.text}"

    @property
    def sign(self) -> float:
        """What it is multiplied by so that less is better."""
        return 1.0 if self.sense == "minimise" else -1.0

    @property
    def sum(self) -> Sum:
        """Of which less is better."""
        return sum_of(self.measure, self.sign)


@dataclass(frozen=True)
class Constraint:
    """What must hold.

    Parameters
    ----------
    text
        As it was given.
    measured
        The side that is no constant, a measure.
    excess
        What that side has above the other one, a measure.
    sign
        1 where the excess must not be above zero, −1 where not below; 0 where it must be zero.
    """

    text: str
    measured: Measure
    excess: Measure
    sign: float

    @property
    def equal(self) -> bool:
        """Whether the excess must be zero."""
        return self.sign == 0.0

    @property
    def sum(self) -> Sum:
        """Which must not be above zero, or must be zero."""
        if self.equal:
            return Sum(0.0, (Plain(1.0, self.excess.text),))
        return sum_of(self.excess, self.sign)

    def violation(self, excess: float) -> float:
        """By how much it does not hold."""
        return abs(excess) if self.equal else max(0.0, self.sign * excess)


def goal_of(minimise: str | None, maximise: str | None) -> Goal:
    """The one goal that is asked for; raises ValueError for none, two, or a text that is none."""
    if (minimise is None) == (maximise is None):
        found = "none" if minimise is None else "both"
        raise ValueError(f"expected one of minimise and maximise, found {found}")
    if minimise is not None:
        return Goal(read_measure(minimise.strip()), "minimise")
    assert maximise is not None
    return Goal(read_measure(maximise.strip()), "maximise")


def constraint_of(text: str) -> Constraint:
    """Read ``min(transmission_angle) > 40 deg``.

    Raises
    ------
    ValueError
        If it is not that.
    """
    parts = [part.strip() for part in _COMPARED.split(text)]
    if len(parts) != 3 or not all(parts):
        raise ValueError(f"expected a constraint such as '{CONSTRAINT}', found {text!r}")
    left, comparison, right = parts
    sign = 0.0 if comparison in _EQUAL else 1.0 if comparison in _LESS else -1.0
    known, other = read_measure(left), read_measure(right)
    if isinstance(known.tree, Constant):
        left, right, known, sign = right, left, other, -sign
    return Constraint(text.strip(), known, read_measure(f"({left}) - ({right})"), sign)


def squares_of(wanted: Sum) -> list[tuple[float, str]]:
    """Factors and measures whose squares a sum consists of; none if it has other parts."""
    found = []
    for part in wanted.parts:
        tree = read_measure(part.measure).tree if isinstance(part, Plain) else None
        match tree:
            case Call("power", (Call() as base, Constant(2.0))) if part.factor > 0.0:
                assert isinstance(part, Plain)
                found.append((part.factor, _written(part.measure, base)))
            case _:
                return []
    return found


def sum_of(measure: Measure, factor: float) -> Sum:
    """A multiple of a measure as a sum, of which less is better."""
    parts = [*_parts(measure.text, measure.tree, factor)]
    constant = sum(part for part in parts if isinstance(part, float))
    return Sum(constant, tuple(part for part in parts if not isinstance(part, float)))


def _parts(text: str, node: Node, factor: float) -> Iterator[float | Peak | Plain]:
    match node:
        case Constant(value):
            yield factor * value
        case Call("neg", (one,)):
            yield from _parts(text, one, -factor)
        case Call("add" | "sub" as name, (first, second)):
            yield from _parts(text, first, factor)
            yield from _parts(text, second, factor if name == "add" else -factor)
        case Call("mul", (Constant(value), one)) | Call("mul", (one, Constant(value))):
            yield from _parts(text, one, factor * value)
        case Call("div", (one, Constant(value))):
            yield from _parts(text, one, factor / value)
        case Call(name, arguments) if reduces(name, len(arguments)):
            yield from _reduced(text, node, factor)
        case _:
            yield Plain(factor, _written(text, node))


def _reduced(text: str, node: Call, factor: float) -> Iterator[Peak | Plain]:
    series = _written(text, node.arguments[-1])
    if node.name == "max" and factor > 0:
        yield Peak(factor, series, 1.0)
    elif node.name == "min" and factor < 0:
        yield Peak(-factor, series, -1.0)
    elif node.name in ("range", "stroke") and factor > 0:
        yield from (Peak(factor, series, 1.0), Peak(factor, series, -1.0))
    else:
        yield Plain(factor, _written(text, node))


def _written(text: str, node: Node) -> str:
    """The text of a part of a measure."""
    span = getattr(node, "span", None)
    return "t" if span is None else text[slice(*span)].strip()


def reduced_series(measure: Measure) -> list[str]:
    """Texts of all that a measure reduces, each once."""
    nodes = Formula(measure.text, measure.tree).nodes()
    calls = [node for node in nodes if isinstance(node, Call)]
    found = [n.arguments[-1] for n in calls if reduces(n.name, len(n.arguments))]
    return list(dict.fromkeys(_written(measure.text, node) for node in found))
