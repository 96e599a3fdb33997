"""The loads of a mechanism by what they act along, which decides on their symbols."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import assert_never

from linkages.components.contributed.measures import (
    BodyAxis,
    Coordinate,
    Distance,
    Load,
    Slide,
    Turn,
)
from linkages.components.contributed.terms import Path


@dataclass(frozen=True)
class Kinds:
    """Loads by their measure, each in the order of the mechanism.

    Those at a joint are listed by their entry, for it is one arrow.
    """

    lines: list[tuple[Distance, Load]] = field(default_factory=list)
    turns: list[tuple[Turn, Load]] = field(default_factory=list)
    slides: list[tuple[Slide, Load]] = field(default_factory=list)
    joints: dict[tuple[Path, str], list[tuple[Coordinate | BodyAxis, Load]]] = field(
        default_factory=dict
    )


def by_kind(loads: Iterable[Load]) -> Kinds:
    """Sort loads; none is left out."""
    found = Kinds()
    for load in loads:
        match load.measure:
            case Distance():
                found.lines.append((load.measure, load))
            case Turn():
                found.turns.append((load.measure, load))
            case Slide():
                found.slides.append((load.measure, load))
            case Coordinate(joint) | BodyAxis(joint):
                found.joints.setdefault((load.path, joint), []).append((load.measure, load))
            case _:
                assert_never(load.measure)
    return found
