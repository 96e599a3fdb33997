"""Objectives and constraints of an optimisation, and the record of its motions.

A peak, ``max(x)`` or ``min(x)``, has corners where another maximum of x becomes the largest. Where
less of it is better, it is replaced by a number s under conditions x(t) ≤ s at all maxima, which
are smooth (the epigraph of a minimax problem). That holds for sums of multiples of peaks, and for
constraints. Any other measure is taken as it is.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.spec.formulas import Call, Constant, Formula, Node, Sensed
from linkages.spec.measures import DISTANCES, WINDOWS, Measure, read_measure, reduces

_COMPARED = re.compile(r"(<=|>=|==|=|<|>|≤|≥)")
_LESS = ("<", "<=", "≤")
_EQUAL = ("=", "==")

CONSTRAINT = "min(piston.velocity) > -6 m/s"


class Peak(NamedTuple):
    """A positive multiple of the largest value of a series, or of its negative (`sign` −1).

    `measure` is that value at the end of the part of the motion in which it is looked for, as in
    ``during(1 s, 2 s, final(x))``.
    """

    factor: float
    measure: str
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
    """What is made least or greatest."""

    measure: Measure  # as it was asked for
    sense: Literal["minimise", "maximise"]  # what is done with it

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
    """What must hold."""

    text: str  # as it was given
    measured: Measure  # the side that is no constant, a measure
    excess: Measure  # what that side has above the other one, a measure
    # 1 where the excess must not be above zero, −1 where not below; 0 where it must be zero
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
        result = "none" if minimise is None else "both"
        raise ValueError(f"expected one of minimise and maximise, found {result}")
    if minimise is not None:
        return Goal(read_measure(minimise.strip()), "minimise")
    assert maximise is not None
    return Goal(read_measure(maximise.strip()), "maximise")


def constraint_of(text: str) -> Constraint:
    """Read ``min(transmission_angle) > 40 deg``."""
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
    result = []
    for part in wanted.parts:
        tree = read_measure(part.measure).tree if isinstance(part, Plain) else None
        match tree:
            case Call("power", (Call() as base, Constant(2.0))) if part.factor > 0.0:
                assert isinstance(part, Plain)
                result.append((part.factor, _written(part.measure, base)))
            case _:
                return []
    return result


def distances_of(wanted: Sum) -> list[tuple[float, str, str]]:
    """Factors, joints and targets of sums of squared distances that a sum consists of, else none.

    Where the root of their mean is least, so is their sum.
    """
    result = []
    for part in wanted.parts:
        tree = read_measure(part.measure).tree if isinstance(part, Plain) else None
        alone = ("rms_distance",) if len(wanted.parts) == 1 else ()
        match tree:
            case Call(name, (Sensed(joint), Sensed(target))) if part.factor > 0.0 and (
                name in ("sum_squared_distance", *alone)
            ):
                result.append((part.factor, joint, target))
            case _:
                return []
    return result


def sum_of(measure: Measure, factor: float) -> Sum:
    """A multiple of a measure as a sum, of which less is better."""
    parts = [*_parts(measure.text, measure.tree, factor, ())]
    constant = sum(part for part in parts if isinstance(part, float))
    return Sum(constant, tuple(part for part in parts if not isinstance(part, float)))


def _parts(
    text: str, node: Node, factor: float, windows: tuple[str, ...]
) -> Iterator[float | Peak | Plain]:
    """Parts of a sum; `windows` are the beginnings of those that it is in."""
    within = (text, windows)
    match node:
        case Constant(value):
            yield factor * value
        case Call("neg", (one,)):
            yield from _parts(text, one, -factor, windows)
        case Call("add" | "sub" as name, (first, second)):
            yield from _parts(text, first, factor, windows)
            yield from _parts(text, second, factor if name == "add" else -factor, windows)
        case Call("mul", (Constant(value), one)) | Call("mul", (one, Constant(value))):
            yield from _parts(text, one, factor * value, windows)
        case Call("div", (one, Constant(value))):
            yield from _parts(text, one, factor / value, windows)
        case Call(name, (*edges, inner)) if name in WINDOWS:
            begun = f"{name}({', '.join(_given(text, each) for each in edges)}, "
            yield from _parts(text, inner, factor, (*windows, begun))
        case Call(name, arguments) if reduces(name, len(arguments)):
            yield from _reduced(within, node, factor)
        case _:
            yield Plain(factor, _measure(within, _written(text, node)))


def _reduced(
    within: tuple[str, tuple[str, ...]], node: Call, factor: float
) -> Iterator[Peak | Plain]:
    series = _measure(within, f"final({_written(within[0], node.arguments[-1])})")
    if node.name == "max" and factor > 0:
        yield Peak(factor, series, 1.0)
    elif node.name == "min" and factor < 0:
        yield Peak(-factor, series, -1.0)
    elif node.name in ("range", "stroke") and factor > 0:
        yield from (Peak(factor, series, 1.0), Peak(factor, series, -1.0))
    else:
        yield Plain(factor, _measure(within, _written(within[0], node)))


def _measure(within: tuple[str, tuple[str, ...]], inner: str) -> str:
    """The text of a measure within windows."""
    return "".join(within[1]) + inner + ")" * len(within[1])


def _given(text: str, node: Node) -> str:
    """The text of an edge of a window; a number, which has no place in the text, in SI."""
    return repr(node.value) if isinstance(node, Constant) else _written(text, node)


def _written(text: str, node: Node) -> str:
    """The text of a part of a measure."""
    span = getattr(node, "span", None)
    return "t" if span is None else text[slice(*span)].strip()


def reduced_series(measure: Measure) -> list[str]:
    """Texts of all that a measure reduces, each once."""
    nodes = Formula(measure.text, measure.tree).nodes()
    calls = [node for node in nodes if isinstance(node, Call)]
    result = []
    for node in calls:
        if reduces(node.name, len(node.arguments)):
            result.append(_written(measure.text, node.arguments[-1]))
        elif node.name in DISTANCES:
            joint = _written(measure.text, node.arguments[0])
            result += [f"{joint}.{axis} position" for axis in ("x", "y")]
    return list(dict.fromkeys(result))


Floats = NDArray[np.float64]

HOLDS = 1e-8
"""By what part of its size a constraint may be violated and still holds."""


ROUND_OFF = 1e-11
"""Part of the goal by which two values are alike."""


@dataclass(frozen=True)
class Tried:
    """What came of some numbers.

    `measured`, `excesses`: of the constraints; nan if there are none.
    `missing`: how much of the motion there is not: 0 if all of it is there, up to 1 where it stops
    before its end, 2 if a measure has no value, above 2 and up to 3 by how far from assembly the
    mechanism is, 3 if the numbers make no sense.
    """

    places: Floats  # in the box of bounds, from 0 to 1
    value: float  # of the goal; nan if there is none
    measured: Floats
    excesses: Floats
    missing: float = 0.0
    reason: str = ""  # why, if not all of it is there


@dataclass
class Record:
    """Results of a search, in its order."""

    goal: Goal
    constraints: Sequence[Constraint]
    # Called after each, with how many there are and the best value so far
    watch: Callable[[int, float], None] | None = None
    most: int | None = None  # how many there may be; None for any number
    tried: list[Tried] = field(default_factory=list)
    sizes: Floats | None = None
    best: Tried | None = None
    # Whether a search has ended where nothing is gained any more but by round-off
    plateau: bool = False
    # The goal at the best end of a search, and its first-order optimality
    settled: tuple[float, float] = (math.nan, math.nan)

    def add(self, one: Tried) -> None:
        """Keep what came of some numbers; raises `EnoughError` when there may be no more."""
        self.tried.append(one)
        if self.sizes is None and not one.missing:
            sizes = np.maximum(np.abs(one.measured), np.abs(one.excesses))
            self.sizes = np.where(sizes > 0.0, sizes, 1.0)
        if self.best is None or self.order(one) < self.order(self.best):
            self.best = one
        if self.watch is not None:
            self.watch(len(self.tried), self.best.value)
        if self.most is not None and len(self.tried) >= self.most:
            raise EnoughError

    def settle(self, places: Floats, optimality: float) -> None:
        """Prefer where a search has settled to what is better by round-off alone."""
        one = next(t for t in reversed(self.tried) if np.array_equal(t.places, places))
        best = self.best
        assert best is not None
        if self.holds(one) and abs(one.value - best.value) <= ROUND_OFF * abs(one.value):
            self.best = one
        if self.best is one or abs(one.value - best.value) <= HOLDS * abs(best.value):
            self.settled = best.value, optimality

    @property
    def optimality(self) -> float:
        """Of the best, by `Round.optimality`; nan if no search has ended there."""
        value, optimality = self.settled
        known = self.best is not None and abs(self.best.value - value) <= HOLDS * abs(value)
        return optimality if known else math.nan

    def order(self, one: Tried) -> tuple[float, float, float]:
        """Less is better: first what can be computed, then what satisfies the constraints."""
        if one.missing:
            return one.missing, np.inf, np.inf
        return 0.0, self.violation(one), self.goal.sign * one.value

    def violations(self, one: Tried) -> Floats:
        """Of each constraint, as a part of its size; zero where it holds."""
        result = [c.violation(e) for c, e in zip(self.constraints, one.excesses, strict=True)]
        parts = np.array(result) / (1.0 if self.sizes is None else self.sizes)
        return np.where(parts <= HOLDS, 0.0, parts)

    def violation(self, one: Tried) -> float:
        """Sum over the constraints; infinite for what cannot be computed."""
        return np.inf if one.missing else float(self.violations(one).sum())

    def holds(self, one: Tried) -> bool:
        """Whether it can be computed and satisfies all constraints."""
        return self.violation(one) == 0.0


class EnoughError(Exception):
    """As many motions as may be were computed."""
