"""The numbers of a mechanism in the order of kernel arguments.

Structure is all of a mechanism that its numbers do not change: names, what is joined to what, laws
as operations, which numbers are exactly zero, which angles are right and which ratios are one. Its
numbers are arguments.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.functions import Table, polynomials
from linkages.components.contributed.load_measures import Distance, Turn
from linkages.components.contributed.terms import Guide, Parameter, Relation
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.reading.columns import Column
from linkages.reading.paths import KeyPath
from linkages.topology.graph import is_unit
from linkages.topology.topology import Topology

NEAREST: KeyPath = ("nearest",)
"""Distance in metres below which two joints are apart by round-off only."""

ROUND_OFF = 4e-15
"""Distance of two joints, beside the size of the mechanism, that round-off may cause."""

SIDED = ("RRR", "RRP", "RPR")
"""Blocks that can be assembled in two ways."""


def right_angle(angle: Parameter) -> int | None:
    """Quarter turns of an angle that is an exact multiple of 90°, 0 to 3; None if it is not."""
    quarters = angle.value / (math.pi / 2)
    return None if angle.kept or quarters != round(quarters) else round(quarters) % 4


def structure_key(item: object) -> Hashable:
    """What is left of a term without its numbers; equal for equal structures."""
    match item:
        case float() | Column():
            return float
        case Parameter(path, value):
            return (path, item.absent, item.kept) if path else value
        case Guide(origin, angle, body):
            return (structure_key(origin), structure_key(angle), right_angle(angle), body)
        case Relation(body, parts, offset, path):
            ratios = tuple((name, structure_key(r), is_unit(r)) for name, r in parts)
            profile = structure_key(item.profile)
            return (body, ratios, structure_key(offset), right_angle(offset), path, profile)
        case tuple():
            return tuple(map(structure_key, item))
        case Mapping():
            return tuple((name, structure_key(value)) for name, value in item.items())
        case str() | int() | None:
            return item
    return (type(item).__name__, *map(structure_key, _parts(item)))


def numbers_in(item: object) -> Iterator[tuple[KeyPath, float]]:
    """Path and value of every parameter in a term, in their order; not those that are absent."""
    match item:
        case Parameter(path, value):
            if path and not item.absent:
                yield path, value
        case Table(path):
            for place, value in enumerate(table_numbers(item)):
                yield (*path, "spline", place), value
            yield from numbers_in(item.over if item.corners is None else item.corners)
        case Relation(_, parts, offset, profile=Table() as profile):
            yield from numbers_in((parts, offset, profile, profile.bends))
        case tuple():
            for part in item:
                yield from numbers_in(part)
        case Mapping():
            for part in item.values():
                yield from numbers_in(part)
        case str() | float() | int() | Column() | None:
            return
        case _:
            for part in _parts(item):
                yield from numbers_in(part)


def _parts(item: Any) -> Iterator[object]:
    """What the fields of a dataclass hold."""
    return (getattr(item, name) for name in item.__dataclass_fields__)


def table_numbers(table: Table) -> list[float]:
    """Knots, then four coefficients for each interval, the cubic one first."""
    found = polynomials(table)
    return [*map(float, found.x), *(float(c) for column in found.c.T for c in column)]


def definition_numbers(mechanism: Mechanism) -> dict[KeyPath, float]:
    """Path → number of a definition, ordered by its structure: bodies, relations, laws, loads."""
    ground, bodies = mechanism.anchors, mechanism.bodies
    # in the order of the bodies: the order of the ground joints in the file is no structure
    used = [ground[j] for name in bodies for j in mechanism.labels(name) if j in ground]
    laws = [mechanism.prescribed[name] for name in bodies if name in mechanism.prescribed]
    groups: tuple[Iterable[object], ...] = (
        (mechanism.gravity,),
        used,
        ground.values(),
        bodies.values(),
        mechanism.relations,
        mechanism.point_masses,
        laws,
        mechanism.loads,
        mechanism.cams.values(),
        mechanism.contacts,
        mechanism.ends,
    )
    found = {path: value for group in groups for part in group for path, value in numbers_in(part)}
    measures = [own.measure for own in mechanism.loads] + [own.measure for own in mechanism.ends]
    measures += mechanism.sensed
    if any(isinstance(measure, Distance) for measure in measures):
        found[NEAREST] = nearest_distance(mechanism)
    return found


def nearest_distance(mechanism: Mechanism) -> float:
    """Distance of two joints in metres that round-off may cause.

    Beside a length that all places have in common: the farthest point of every body, summed up.
    """
    places = [*mechanism.attachments.values(), mechanism.anchors]
    farthest = (
        max((abs(n.value) for p in some.values() for n in p), default=0.0) for some in places
    )
    return ROUND_OFF * sum(farthest)


def chosen_paths(topology: Topology) -> list[KeyPath]:
    """Parameters that the way of assembly gives: sides of blocks, whole turns of loads."""
    sides = [("side", b.index) for b in topology.solved_blocks if b.kind in SIDED]
    return [*sides, *(("turns", place) for place in wound_angles(topology.mechanism))]


def wound_angles(mechanism: Mechanism) -> dict[int, Turn]:
    """Angles that count from within half a turn at the start, where nothing says more.

    Their numbers are those of the loads along them. Behind all loads come angles of two bodies that
    loads sense: the angle of one body is what it is in outputs. Last come those that end.
    """
    loads = mechanism.loads
    felt = {turn for load in loads for turn in load.wound}
    own = [(load.measure, load.measure in load.wound) for load in loads]
    two = {turn for turn in felt if turn.reference is not None}
    other = [(measure, measure in two) for measure in mechanism.sensed]
    ends = [(end.measure, True) for end in mechanism.ends]
    return {
        place: measure
        for place, (measure, counts) in enumerate([*own, *other, *ends])
        if isinstance(measure, Turn) and counts
    }


def definition_vector(mechanism: Mechanism, paths: Iterable[KeyPath]) -> NDArray[np.float64]:
    """Parameters of a kernel as the definition gives them: sides are 1, turns 0; shape (p,)."""
    found = definition_numbers(mechanism)
    usual = {"side": 1.0, "turns": 0.0}
    return np.array([found[p] if p in found else usual[str(p[0])] for p in paths], dtype=float)


Floats = NDArray[np.float64]

Fed = tuple[tuple[KeyPath, ...], ...]
"""For each number of a definition the paths of the parameters that it feeds."""


@dataclass(frozen=True, eq=False)
class Effects:
    """Derivatives by numbers of a definition.

    Parameters
    ----------
    fed
        What each of P numbers feeds.
    slopes
        Derivatives of those parameters, those of one number after those of the other, shape (s,).
    state
        Derivatives of the initial coordinates and their rates, shape (2m, P).
    knots
        Which slopes are knots of tables instead: those of a spline whose coefficients are the
        derivatives that follow; shape (s,).
    """

    fed: Fed
    slopes: Floats
    state: Floats
    knots: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.fed)

    def scaled(self, factors: Floats) -> Effects:
        """The same by numbers in other units, of which each is `factors` SI units, shape (P,)."""
        each = np.repeat(factors, [len(paths) for paths in self.fed])
        slopes = np.where(self.knots, self.slopes, self.slopes * each)
        return replace(self, slopes=slopes, state=self.state * factors)


def slots(fed: Sequence[Sequence[KeyPath]]) -> Iterator[tuple[int, KeyPath]]:
    """Number of a definition and path of a parameter, for each of the slopes."""
    return ((number, path) for number, paths in enumerate(fed) for path in paths)
