"""Quantities that laws of loads may name: which measure each is, and what it is called."""

from __future__ import annotations

from collections.abc import Collection
from typing import assert_never

from linkages.components.contributed.functions import (
    PRESSED,
    Function,
    Internal,
    Measured,
    Number,
    Operation,
    Table,
    Time,
)
from linkages.components.contributed.measures import (
    BodyAxis,
    Coordinate,
    Distance,
    Measure,
    Slide,
    Turn,
)
from linkages.components.contributed.revolute import GROUND
from linkages.components.contributed.state_laws import exchanged, measured_in, variables
from linkages.operations import ATOM, ELEMENTARY
from linkages.spec.formulas import Sensed

_RATES = ("velocity", "speed", "vx", "vy")


def measured_by(found: Sensed) -> Measured:
    """The measure that a quantity of a formula is, or its rate.

    A speed is that of an angle until the whole mechanism tells sliders: see `with_sliders`.
    """
    order = 1 if found.rate or found.word in _RATES else 0
    return Measured(order, _measure(found.word, found.names))


def _measure(word: str, names: tuple[str, ...]) -> Measure:
    match word, names:
        case "distance", (first, second):
            return Distance(first, second)
        case "angle", (first, second):
            return Turn(second, None if first == GROUND else first)
        case (("position" | "velocity"), (body,)):
            return Slide(body)
        case (("x" | "y" | "vx" | "vy"), (joint,)):
            return Coordinate(joint, "xy".index(word[-1]))
        case _, (body, *_):
            return Turn(body, None)
    raise ValueError(f"no quantity {word!r}")


def with_sliders(function: Function, sliders: Collection[str]) -> Function:
    """The same function where the speeds of sliders are those along their axes."""

    def slid(found: Measured) -> Measured:
        match found.measure:
            case Turn(body, None) if body in sliders:
                return Measured(found.order, Slide(body))
        return found

    if any(slid(found) != found for found in measured_in(function)):
        return exchanged(function, slid)
    return function


def words(measure: Measure, order: int) -> str:
    """What formulas call the value of a measure (`order` 0) or its rate (1)."""
    match measure:
        case Distance(first, second):
            return _rate(f"distance({first}, {second})", order)
        case Turn(body, None):
            return f"{body}.{'speed' if order else 'angle'}"
        case Turn(body, reference):
            return _rate(f"angle({reference}, {body})", order)
        case Slide(body):
            return f"{body}.{'velocity' if order else 'position'}"
        case Coordinate(joint, axis):
            return f"{joint}.{'v' * order}{'xy'[axis]}"
        case BodyAxis(joint, body):
            return f"the velocity of {joint} along {body}"
        case _:
            assert_never(measure)


def _rate(text: str, order: int) -> str:
    return f"rate({text})" if order else text


def written(function: Function, own: Measure) -> str:
    """A function as sentences show it, shortened.

    Parameters
    ----------
    function
        Part of the law of a load.
    own
        What the load acts along.
    """
    text = _written(function, own)[0]
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"


_LONGEST = 60


def _written(function: Function, own: Measure) -> tuple[str, int]:
    """Text, and how strongly it binds."""
    match function:
        case Number(parameter):
            return f"{parameter.value:.6g}", ATOM if parameter.value >= 0.0 else 1
        case Time():
            return "t", ATOM
        case Measured() if function == PRESSED:
            return "reaction", ATOM
        case Measured(order, measure):
            return words(own if measure is None else measure, order), ATOM
        case Internal(name):
            return name, ATOM
        case Table():
            return f"table({_written(function.over, own)[0]})", ATOM
        case Operation("where", (difference, *_)):
            return f"where({_written(difference, own)[0]} >= 0)", ATOM
        case Operation("power", (base, Number(exponent))):
            return f"{_bound(base, own, ATOM)}**{exponent.value:.0f}", 3
        case Operation(name, arguments):
            form = ELEMENTARY[name].operator if name in ELEMENTARY else None
            if form is None:
                return f"{name}({', '.join(_written(a, own)[0] for a in arguments)})", ATOM
            parts = (_bound(a, own, s) for a, s in zip(arguments, form.operands, strict=False))
            return form.template.format(*parts), form.strength
        case _:
            assert_never(function)


def _bound(function: Function, own: Measure, strength: int) -> str:
    text, own_strength = _written(function, own)
    return text if own_strength >= strength else f"({text})"


def named(function: Function, own: Measure | None = None) -> list[str]:
    """What a function depends on, t last: own measures are x and v unless they are given."""
    found = dict.fromkeys(
        "xv"[leaf.order] if (of := leaf.measure or own) is None else words(of, leaf.order)
        for leaf in measured_in(function)
        if leaf != PRESSED
    )
    ordered = [name for name in ("x", "v") if name in found]
    timed = ["t"] if "t" in variables(function) else []
    return [*ordered, *(name for name in found if name not in ordered), *timed]
