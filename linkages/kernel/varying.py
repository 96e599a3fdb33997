"""A mechanism with other numbers: only what they touch is read again, nothing is built anew."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.component import Component, Term
from linkages.components.contributed.measures import JointFriction, Load
from linkages.components.contributed.terms import Body, Displacement, GroundPin, Hint, Initial, Path
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.mechanisms.reread import owner, reread
from linkages.errors import InputError
from linkages.kernel.assembly.settling import Settled, Settling
from linkages.kernel.numbers.parameters import NEAREST, nearest_distance, numbers_in, structure_key
from linkages.kernel.system import System

Floats = NDArray[np.float64]

Overrides = Mapping[str, object]
"""Dotted path → value, as `Mechanism.with_values` takes them."""

MOST_READ = 4096
"""Components that are remembered: those along the axes of a grid are needed again and again."""


class _Read(NamedTuple):
    """A component that was read with other values."""

    component: Component
    terms: tuple[Term, ...]
    key: Hashable


class _Base:
    """What all systems of a structure start from.

    Parameters
    ----------
    system
        Some system of the structure.
    mechanism
        The mechanism that is varied, perhaps of another structure.
    """

    def __init__(self, system: System, mechanism: Mechanism) -> None:
        self.system = system
        self.keys = [_key(system.mechanism, entry) for entry in system.mechanism.components]
        own = [_key(mechanism, entry) for entry in mechanism.components]
        self.different = {
            place for place, key in enumerate(own) if self.keys[place : place + 1] != [key]
        }
        self.places = system.model.inputs.parameters
        self.coordinates = {name: row for row, name in enumerate(system.layout.coordinates)}
        self.half = len(system.layout.coordinates)
        self.settling = Settling(system.model, system.mechanism.hints)
        self.numbers, self.given = system.numbers.copy(), np.zeros(2 * self.half)
        self.hints: dict[str, Floats] = {}
        self.enter(mechanism.terms, self.numbers, self.given, self.hints)
        if NEAREST in self.places:
            self.numbers[self.places[NEAREST]] = nearest_distance(mechanism)

    def enter(
        self, terms: tuple[Term, ...], numbers: Floats, given: Floats, hints: dict[str, Floats]
    ) -> None:
        """Enter the numbers of a component."""
        for path, value in numbers_in(terms):
            if path in self.places:
                numbers[self.places[path]] = value
        for term in terms:
            if isinstance(term, Initial) and term.body in self.coordinates:
                row = self.coordinates[term.body]
                given[row], given[self.half + row] = term.position, term.speed
            elif isinstance(term, Load | JointFriction):
                for state in term.states:
                    given[self.half + self.coordinates[state.name]] = state.initial
            elif isinstance(term, Hint) and term.position is not None:
                hints[term.joint] = np.array(term.position, dtype=float)


class _Numbers(NamedTuple):
    """Numbers of a definition with other values, before it is assembled."""

    mechanism: Mechanism
    parameters: Floats
    given: Floats
    hints: Mapping[str, Floats]


@dataclass(frozen=True, eq=False)
class Along:
    """Mechanisms with other numbers, assembled together.

    Parameters
    ----------
    varying, points
        What is varied, and the overrides of each mechanism.
    numbers
        Of each mechanism that differs in numbers only.
    settled
        Those of one structure, column by column; None if there are none.
    columns
        Place of every mechanism among them; None for one that is built as usual.
    """

    varying: Varying
    points: Sequence[Overrides]
    numbers: Sequence[_Numbers | None]
    settled: Settled | None
    columns: Sequence[int | None]

    def __len__(self) -> int:
        return len(self.points)

    def system(self, index: int) -> System:
        """One of them.

        Raises
        ------
        InputError
            If a path names nothing, a value cannot be used or the mechanism not be assembled.
        """
        column, numbers = self.columns[index], self.numbers[index]
        base = self.varying.base
        if column is None or numbers is None or self.settled is None or base is None:
            return self.varying.built(self.points[index])
        return base.system.bound(
            numbers.mechanism,
            numbers.parameters,
            base.settling.assembly(self.settled, column),
            self.settled.state[:, column].copy(),
            self.settled.margin_scale[:, column].copy(),
        )


class Varying:
    """Makes systems from overrides of a definition.

    The components that overrides touch are read again as the definition file would be, so that
    whatever follows from a value (a centre of mass, the coefficients of a table) follows it here.
    Where more changes than numbers, the whole mechanism is read and assembled as usual.

    Parameters
    ----------
    mechanism
        What is varied.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.base: _Base | None = None
        self._read: dict[Hashable, _Read | None] = {}
        self._owners: dict[str, tuple[int, Path] | None] = {}

    def at(self, overrides: Overrides) -> System:
        """The system with other values; raises as `Along.system` does."""
        return self.built(overrides) if self.base is None else self.along([overrides]).system(0)

    def mechanism_at(self, overrides: Overrides) -> Mechanism:
        """The mechanism with other values; raises as `Mechanism.with_values` does."""
        found = self._numbers(overrides)
        return self.mechanism.with_values(overrides) if found is None else found.mechanism

    def built(self, overrides: Overrides) -> System:
        """The system as it is built from a definition."""
        system = System(self.mechanism.with_values(overrides) if overrides else self.mechanism)
        if self.base is None and not system.chosen and Settling.serves(system.model):
            self.base = _Base(system, self.mechanism)
        return system

    def along(self, points: Sequence[Overrides]) -> Along:
        """Systems with many sets of other values, assembled together."""
        if self.base is None:
            self._look_for_base(points)
        numbers = [self._numbers(point) for point in points]
        chosen = [found for found in numbers if found is not None]
        columns: list[int | None] = [None] * len(points)
        if not chosen or self.base is None:
            return Along(self, points, numbers, None, columns)
        settled = self.base.settling(
            np.array([found.parameters for found in chosen]).T,
            np.array([found.given for found in chosen]).T,
            self.base.system.time,
            {
                joint: np.array([found.hints[joint] for found in chosen]).T
                for joint in self.base.hints
            },
        )
        places = [index for index, found in enumerate(numbers) if found is not None]
        for column, index in enumerate(places):
            columns[index] = column if settled.sound[column] else None
        return Along(self, points, numbers, settled, columns)

    def _look_for_base(self, points: Sequence[Overrides]) -> None:
        """Build the first system that can be built."""
        for point in points:
            try:
                self.built(point)
            except InputError:
                continue
            return

    def __reduce__(self) -> tuple[type[Varying], tuple[Mechanism]]:
        """Without what belongs to this process."""
        return Varying, (self.mechanism,)

    def _numbers(self, overrides: Overrides) -> _Numbers | None:
        """Numbers of a definition with other values; None if more changes than numbers."""
        base = self.base
        if base is None:
            return None
        read = self._changed(overrides)
        if read is None or not base.different <= set(read):
            return None
        if any(found.key != base.keys[place] for place, found in read.items()):
            return None
        mechanism = self.mechanism.exchanging({p: (f.component, f.terms) for p, f in read.items()})
        numbers, given, hints = base.numbers.copy(), base.given.copy(), dict(base.hints)
        for found in read.values():
            base.enter(found.terms, numbers, given, hints)
        shapes = (Body, GroundPin, Displacement)
        if NEAREST in base.places and any(
            isinstance(term, shapes) for found in read.values() for term in found.terms
        ):
            numbers[base.places[NEAREST]] = nearest_distance(mechanism)
        return _Numbers(mechanism, numbers, given, hints)

    def _changed(self, overrides: Overrides) -> dict[int, _Read] | None:
        """Place of each component that overrides touch → what it is then."""
        values: dict[int, dict[Path, object]] = {}
        for path, value in overrides.items():
            if path not in self._owners:
                self._owners[path] = owner(self.mechanism, path)
            found = self._owners[path]
            if found is None:
                return None
            values.setdefault(found[0], {})[found[1]] = value
        read = {place: self._component(place, changed) for place, changed in values.items()}
        known = {place: found for place, found in read.items() if found is not None}
        return known if len(known) == len(read) else None

    def _component(self, place: int, values: Mapping[Path, object]) -> _Read | None:
        simple = all(isinstance(value, str | float | int) for value in values.values())
        key = (place, *((path, type(value), value) for path, value in values.items()))
        if simple and key in self._read:
            return self._read[key]
        own = self.mechanism.components[place]
        found = reread(self.mechanism, own, values)
        made: _Read | None = None
        if found is not None and found.references() == own.references():
            terms = self.mechanism.terms_of(found)
            made = _Read(found, terms, structure_key(terms))
        if simple and len(self._read) < MOST_READ:
            self._read[key] = made
        return made


def _key(mechanism: Mechanism, component: Component) -> Hashable:
    return structure_key(mechanism.terms_of(component))
