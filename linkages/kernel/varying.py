"""A mechanism with other numbers: only what they touch is read again, nothing is built anew."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.component import Component, Term
from linkages.components.contributed.terms import Body, Displacement, GroundPin, Hint
from linkages.components.mechanisms.definition import owner, reread
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.scene import NumberOfFormulas
from linkages.errors import InputError
from linkages.kernel.batch_assembly import AssembledBatch, BatchAssembler
from linkages.kernel.inputs import (
    NEAREST,
    initial_values,
    nearest_distance,
    numbers_in,
    structure_key,
)
from linkages.kernel.system import System
from linkages.reading.overrides import Column, values_of
from linkages.reading.paths import KeyPath

Floats = NDArray[np.float64]

Overrides = Mapping[str, object]
"""Dotted path → value, as `Mechanism.with_values` takes them."""

MOST_READ = 4096
"""Components that are remembered: those along the axes of a grid are needed again and again."""

_FEWEST = 8
"""Mechanisms from which on their numbers are read together."""

_CHECKED = 64
"""Of numbers that are read together, one in so many is compared with what it is by itself."""


class _Read(NamedTuple):
    """A component that was read with other values."""

    component: Component
    terms: tuple[Term, ...]
    key: Hashable


class _Base:
    """What systems of a structure start from; the mechanism varied may be of another one."""

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
        self.assembler = BatchAssembler(system.model, system.mechanism.hints)
        self.numbers, self.given = system.numbers.copy(), np.zeros(2 * self.half)
        self.hints: dict[str, Floats] = {}
        self.enter(mechanism.terms, self.numbers, self.given, self.hints)
        if NEAREST in self.places:
            self.numbers[self.places[NEAREST]] = nearest_distance(mechanism)

    def enter(
        self, terms: tuple[Term, ...], numbers: Floats, given: Floats, hints: dict[str, Floats]
    ) -> None:
        """Enter the numbers of a component, shape (p,) or (p, sets), and so on."""
        for path, value in numbers_in(terms):
            if path in self.places:
                numbers[self.places[path]] = values_of(value)
        for name, position, speed in initial_values(terms):
            if (row := self.coordinates.get(name)) is not None:
                given[row], given[self.half + row] = values_of(position), values_of(speed)
        for term in terms:
            if isinstance(term, Hint) and term.position is not None:
                place = np.broadcast_arrays(*map(values_of, term.position))
                hints[term.joint] = np.array(place, dtype=float)

    def moves(self, read: Iterable[_Read]) -> bool:
        """Whether components change how near places may be that round-off alone tells apart."""
        shapes = (Body, GroundPin, Displacement)
        terms = (term for item in read for term in item.terms)
        return NEAREST in self.places and any(isinstance(term, shapes) for term in terms)


class _Numbers(NamedTuple):
    """Numbers of a definition before it is assembled; of several, one column for each."""

    parameters: Floats
    given: Floats
    hints: Mapping[str, Floats]


@dataclass(frozen=True, eq=False)
class Along:
    """Mechanisms with other numbers, assembled together."""

    varying: Varying
    points: Sequence[Overrides]
    # Those of one structure, column by column; None if there are none
    settled: AssembledBatch | None
    # Place of every mechanism among them; None for one that is built as usual
    columns: Sequence[int | None]
    # Every mechanism with its parameters, as far as they have been read one by one
    read: Sequence[tuple[Mechanism, _Numbers] | None] = ()

    def __len__(self) -> int:
        return len(self.points)

    def system(self, index: int) -> System:
        """One of them."""
        column, base = self.columns[index], self.varying.base
        if column is None or self.settled is None or base is None:
            return self.varying.built(self.points[index])
        read = self.read[index] if self.read else self.varying.numbers_at(self.points[index])
        assert read is not None
        mechanism, numbers = read
        return base.system.bound(
            mechanism,
            numbers.parameters,
            base.assembler.assembly(self.settled, column),
            self.settled.state[:, column].copy(),
            self.settled.margin_scale[:, column].copy(),
            lambda: self._modes[:, column].copy(),
        )

    @cached_property
    def _modes(self) -> Floats:
        """Modes and memories of all that can be assembled, at once, shape (m, sets)."""
        assert self.settled is not None
        assert self.varying.base is not None
        return self.varying.base.system.starting_modes(self.settled.parameters, self.settled.state)


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
        self._owners: dict[str, tuple[int, KeyPath] | None] = {}

    def at(self, overrides: Overrides) -> System:
        """The system with other values; raises as `Along.system` does."""
        return self.built(overrides) if self.base is None else self.along([overrides]).system(0)

    def mechanism_at(self, overrides: Overrides) -> Mechanism:
        """The mechanism with other values; raises as `Mechanism.with_values` does."""
        result = self.numbers_at(overrides)
        return self.mechanism.with_values(overrides) if result is None else result[0]

    def built(self, overrides: Overrides) -> System:
        """The system as it is built from a definition."""
        system = System(self.mechanism.with_values(overrides) if overrides else self.mechanism)
        if self.base is None and not system.chosen and BatchAssembler.serves(system.model):
            self.base = _Base(system, self.mechanism)
        return system

    def along(self, points: Sequence[Overrides], one_in: int = _CHECKED) -> Along:
        """Systems with many sets of other values, assembled together.

        Of those that are read together, `one_in` so many is compared with what it is by itself.
        """
        for point in points if self.base is None else ():
            with suppress(InputError):
                self.built(point)
                break
        columns: list[int | None] = [None] * len(points)
        if self.base is None:
            return Along(self, points, None, columns)
        sets = self._together(points, one_in)
        places = [*range(len(points))]
        read: list[tuple[Mechanism, _Numbers] | None] = []
        if sets is None:
            read = [self.numbers_at(point) for point in points]
            places = [index for index in places if read[index] is not None]
            if not places:
                return Along(self, points, None, columns)
            sets = _side_by_side([item[1] for item in read if item is not None])
        time = self.base.system.time
        settled = self.base.assembler(sets.parameters, sets.given, time, sets.hints)
        # those that start in walls are built as usual, too, which says why they cannot
        sound = settled.sound & ~self.base.system.starts_in_walls(settled.parameters, settled.state)
        for column, index in enumerate(places):
            columns[index] = column if sound[column] else None
        return Along(self, points, settled, columns, read)

    def _together(self, points: Sequence[Overrides], one_in: int) -> _Numbers | None:
        """Numbers of all mechanisms, read at once; None if they have to be read one by one."""
        paths = points[0].keys() if points else ()
        alike = all(
            point.keys() == paths and all(type(value) is float for value in point.values())
            for point in points
        )
        if len(points) < _FEWEST or not alike:
            return None
        rows = {path: np.array([point[path] for point in points], dtype=float) for path in paths}
        try:
            with np.errstate(all="ignore"):
                columns = {path: Column(row) for path, row in rows.items()}
                if (read := self._fitting(columns)) is None:
                    return None
                result = self._entered(read, lambda: self._exchanging(read), len(points))
        except (TypeError, ValueError):  # they differ in more than numbers, or in ways unknown here
            return None
        entered = [place.reshape(2, -1) for place in result.hints.values()]
        if not all(np.isfinite(each).all() for each in (*result[:2], *entered)):
            return None
        for index in {*range(0, len(points), one_in), len(points) - 1}:
            one = self.numbers_at(points[index])
            if one is None or not _same(result, index, one[1]):
                return None
        return result

    def _entered(
        self,
        read: Mapping[int, _Read],
        mechanism: Callable[[], Mechanism],
        count: int | None = None,
    ) -> _Numbers:
        """Numbers with those of some components, or so many columns of them."""
        base = self.base
        assert base is not None
        numbers, given, hints = base.numbers.copy(), base.given.copy(), dict(base.hints)
        if count is not None:
            numbers, given = (np.repeat(own[:, None], count, axis=1) for own in (numbers, given))
        # others were read with the shared numbers of the definition, which stand last therefore
        for item in sorted(
            read.values(), key=lambda item: isinstance(item.component, NumberOfFormulas)
        ):
            base.enter(item.terms, numbers, given, hints)
        if base.moves(read.values()):
            numbers[base.places[NEAREST]] = values_of(nearest_distance(mechanism()))
        return _Numbers(numbers, given, hints)

    def __reduce__(self) -> tuple[type[Varying], tuple[Mechanism]]:
        """Without what belongs to this process."""
        return Varying, (self.mechanism,)

    def numbers_at(self, overrides: Overrides) -> tuple[Mechanism, _Numbers] | None:
        """A mechanism with other values, and its numbers; None if more changes than numbers."""
        if (read := self._fitting(overrides)) is None:
            return None
        mechanism = self._exchanging(read)
        return mechanism, self._entered(read, lambda: mechanism)

    def _exchanging(self, read: Mapping[int, _Read]) -> Mechanism:
        return self.mechanism.exchanging({p: (f.component, f.terms) for p, f in read.items()})

    def _fitting(self, overrides: Overrides) -> dict[int, _Read] | None:
        """What overrides make of components, where that leaves the structure as it is."""
        base, read = self.base, self._changed(overrides)
        if base is None or read is None or not base.different <= set(read):
            return None
        if any(item.key != base.keys[place] for place, item in read.items()):
            return None
        return read

    def _changed(self, overrides: Overrides) -> dict[int, _Read] | None:
        """Place of each component that overrides touch → what it is then."""
        values: dict[int, dict[KeyPath, object]] = {}
        for path, value in overrides.items():
            if path not in self._owners:
                self._owners[path] = owner(self.mechanism, path)
            result = self._owners[path]
            if result is None:
                return None
            values.setdefault(result[0], {})[result[1]] = value
        read = {place: self._component(place, changed) for place, changed in values.items()}
        known = {place: item for place, item in read.items() if item is not None}
        return known if len(known) == len(read) else None

    def _component(self, place: int, values: Mapping[KeyPath, object]) -> _Read | None:
        simple = all(isinstance(value, str | float | int) for value in values.values())
        key = (place, *((path, type(value), value) for path, value in values.items()))
        if simple and key in self._read:
            return self._read[key]
        own = self.mechanism.components[place]
        result = reread(self.mechanism, own, values)
        made: _Read | None = None
        if result is not None and result.references() == own.references():
            terms = self.mechanism.terms_of(result)
            made = _Read(result, terms, structure_key(terms))
        if simple and len(self._read) < MOST_READ:
            self._read[key] = made
        return made


def _side_by_side(numbers: Sequence[_Numbers]) -> _Numbers:
    hints = {
        joint: np.array([each.hints[joint] for each in numbers]).T for joint in numbers[0].hints
    }
    parameters, given = (
        [getattr(each, name) for each in numbers] for name in ("parameters", "given")
    )
    return _Numbers(np.array(parameters).T, np.array(given).T, hints)


def _same(sets: _Numbers, column: int, one: _Numbers) -> bool:
    """Whether one of many sets of numbers is equal to another one in all bits."""
    pairs = [(sets.parameters[:, column], one.parameters), (sets.given[:, column], one.given)]
    for joint, place in one.hints.items():
        many = sets.hints[joint]
        pairs.append((many if many.ndim == 1 else many[:, column], place))
    return all(item.tobytes() == alone.tobytes() for item, alone in pairs)


def _key(mechanism: Mechanism, component: Component) -> Hashable:
    return structure_key(mechanism.terms_of(component))
