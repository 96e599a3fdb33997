"""What entries of lists have in common: loads, springs, dampers and gears have no names."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from linkages.components.contributed.component import Component
from linkages.components.contributed.revolute import GROUND
from linkages.components.contributed.terms import Path

TURNING = ("bar", "plate")

BodyReference = tuple[Path, str, tuple[str, ...]]


class ListedComponent(Component):
    """A component that stands in a list: its place is its index."""

    index: int

    @property
    def path(self) -> Path:
        """The section and the place in its list."""
        return (self.section, self.index)


def numbered(components: Iterable[Component]) -> tuple[Component, ...]:
    """The same components; indices of lists count from 0 without gaps."""
    found = list(components)
    places: dict[str, list[int]] = {}
    for entry in found:
        if isinstance(entry, ListedComponent):
            places.setdefault(entry.section, []).append(entry.index)
    for number, entry in enumerate(found):
        if isinstance(entry, ListedComponent):
            place = sorted(places[entry.section]).index(entry.index)
            made: Any = entry
            found[number] = entry if entry.index == place else replace(made, index=place)
    return tuple(found)


def turning(path: Path, names: tuple[str, ...]) -> tuple[BodyReference, ...]:
    """References to bars and plates of a list at a path; the ground may stand first."""
    return tuple(
        ((*path, place), name, TURNING)
        for place, name in enumerate(names)
        if not (place == 0 and name == GROUND)
    )


def reference(names: tuple[str, str]) -> str | None:
    """The first of two bodies as terms have it: None for the ground."""
    return None if names[0] == GROUND else names[0]


def two_bodies(path: Path, names: tuple[str, str]) -> tuple[tuple[Path, str], ...]:
    """What is wrong with a pair of bodies: the same twice, or the ground in second place."""
    if names[0] == names[1]:
        return ((path, f"expected two different bodies, found {names[0]!r} twice"),)
    if names[1] == GROUND:
        return (((*path, 1), "expected a bar or plate; the ground can stand first only"),)
    return ()
