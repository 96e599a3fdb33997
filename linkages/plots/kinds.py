"""The loads of a mechanism by the symbol that stands for them in drawings."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import assert_never

from linkages.components.terms import (
    AxialDamper,
    AxialForce,
    Load,
    PointForce,
    Spring,
    Torque,
    TorsionSpring,
)


@dataclass(frozen=True)
class Kinds:
    """Loads by their kind, each in the order of the mechanism."""

    springs: list[Spring] = field(default_factory=list)
    torsional: list[TorsionSpring] = field(default_factory=list)
    guide_dampers: list[AxialDamper] = field(default_factory=list)
    axial: list[AxialForce] = field(default_factory=list)
    forces: list[PointForce] = field(default_factory=list)
    torques: list[Torque] = field(default_factory=list)


def by_kind(loads: Iterable[Load]) -> Kinds:
    """Sort loads; none is left out."""
    found = Kinds()
    for load in loads:
        match load:
            case Spring():
                found.springs.append(load)
            case TorsionSpring():
                found.torsional.append(load)
            case AxialDamper():
                found.guide_dampers.append(load)
            case AxialForce():
                found.axial.append(load)
            case PointForce():
                found.forces.append(load)
            case Torque():
                found.torques.append(load)
            case _:
                assert_never(load)
    return found
