"""Quantities that laws of loads may name: which measure each is, and what it is called."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import assert_never

from linkages.components.contributed.functions import Measured
from linkages.components.contributed.measures import (
    BodyAxis,
    Coordinate,
    Distance,
    Load,
    Measure,
    Slide,
    Turn,
)
from linkages.components.contributed.revolute import GROUND
from linkages.components.contributed.state_laws import exchanged, measured_in
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


def with_sliders(load: Load, sliders: Collection[str]) -> Load:
    """The same load where the speeds of sliders are those along their axes."""

    def slid(found: Measured) -> Measured:
        match found.measure:
            case Turn(body, None) if body in sliders:
                return Measured(found.order, Slide(body))
        return found

    if any(slid(found) != found for found in measured_in(load.law)):
        return replace(load, law=exchanged(load.law, slid))
    return load


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


def depends_on(load: Load) -> list[str]:
    """What a load depends on, as formulas call it; t comes last."""
    found = (
        words(load.measure if leaf.measure is None else leaf.measure, leaf.order)
        for leaf in measured_in(load.law)
    )
    return list(dict.fromkeys(found))
