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
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.stop import AngleStop, DistanceStop, GuideStop

Stop = GuideStop | AngleStop | DistanceStop


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


def stops_of(mechanism: Mechanism) -> list[Stop]:
    """All stops of a mechanism."""
    return [part for part in mechanism.components if isinstance(part, Stop)]


def frictions_of(mechanism: Mechanism) -> list[Load]:
    """All loads that rub at joints and in guides, and are no dampers."""
    return [load for load in mechanism.loads if load.called == "friction"]


def springs_of(mechanism: Mechanism) -> list[Load]:
    """All loads but those of stops and friction, which are no springs or dampers to look at."""
    others = {part.path for part in (*stops_of(mechanism), *frictions_of(mechanism))}
    return [load for load in mechanism.loads if load.path not in others]
