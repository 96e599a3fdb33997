"""Kernel parameters and initial state as functions of numbers of a definition.

What components make of their numbers is Python, which is carried out again with dual numbers.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from linkages.components.contributed.component import Component, Term
from linkages.components.contributed.functions import Table
from linkages.components.contributed.state_laws import leaves
from linkages.components.contributed.terms import Parameter, Prescribed, Relation
from linkages.components.mechanisms.definition import owner
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.mechanisms.registry import SECTIONS
from linkages.errors import InputError
from linkages.kernel.dual_numbers import Dual, FollowedNumber, Slopes
from linkages.kernel.inputs import Effects, initial_values, parts_of, slots, table_numbers
from linkages.kernel.system import System
from linkages.reading.paths import KeyPath, dotted, split
from linkages.reading.wording import nearest
from linkages.spec.formulas import Constant, Formula
from linkages.spec.models import infos_of

Keys = tuple[str | int, ...]
"""Attributes and indices that lead from a component to one of its numbers."""


class NoDerivativeError(InputError):
    """What a component makes of a number cannot be differentiated."""


@dataclass(frozen=True)
class Number:
    """A number of a definition, and its keys within a component."""

    path: str
    component: int
    keys: Keys


def numbers_of(mechanism: Mechanism, paths: Sequence[str]) -> tuple[Number, ...]:
    """The numbers that dotted paths name, each once.

    Patterns such as ``bars.*`` stand for all that are written in the definition and have an effect.
    """
    result: dict[tuple[int, Keys], Number] = {}
    problems: list[tuple[KeyPath, str]] = []
    known = [] if all("*" not in path and "?" not in path for path in paths) else written(mechanism)
    for path in paths:
        if "*" in path or "?" in path:
            fitting = [number for number in known if fnmatchcase(number.path, path)]
            if not fitting:
                problems.append(((path,), _no_match(mechanism)))
        else:
            named = _named(mechanism, path)
            fitting = [] if isinstance(named, str) else [named]
            if isinstance(named, str):
                problems.append((split(path) or (path,), named))
        for number in fitting:
            result.setdefault((number.component, number.keys), number)
    if problems:
        raise mechanism.error(problems)
    if not result:
        raise InputError(mechanism.source, [mechanism.problem((), "no numbers are asked for")])
    return tuple(result.values())


def written(mechanism: Mechanism) -> list[Number]:
    """All numbers that the definition writes and that have an effect."""
    result = []
    for place, component in enumerate(mechanism.components):
        own = [
            Number(dotted((*component.path, *steps)), place, keys)
            for steps, keys, leaf in _leaves(component)
            if isinstance(leaf, float)
            and mechanism.definition.value((*component.path, *steps)) is not None
        ]
        result += [number for number in own if _has_effect(mechanism, number)]
    return result


def value_of(mechanism: Mechanism, number: Number) -> float:
    """A number as the definition has it, in SI."""
    part: Any = mechanism.components[number.component]
    for key in number.keys:
        part = _entry(part, key)
    return float(part)


def number_value(mechanism: Mechanism, path: str) -> float | None:
    """The number at a dotted path in SI, also one that follows from others; None for no number."""
    found, where = given_number(mechanism, path), split(path)
    if found is not None:
        return value_of(mechanism, found)
    for term in (term for group in mechanism.term_groups for term in group):
        for own, value in _parameters(term):
            if own == where and isinstance(value, float):
                return value
    return None


def given_number(mechanism: Mechanism, path: str) -> Number | None:
    """The number that stands at a dotted path, if one does, whether it has an effect or not."""
    result = owner(mechanism, path)
    if result is None:
        return None
    place, steps = result
    component = mechanism.components[place]
    keys = _keys(component, steps[len(component.path) :])
    return None if isinstance(keys, str) else Number(path, place, keys)


def _parameters(item: Any) -> Iterator[tuple[KeyPath, float]]:
    match item:
        case Parameter(path, value):
            yield path, value
        case _:
            for part in parts_of(item):
                yield from _parameters(part)


def ideal_number(mechanism: Mechanism, ideal: Mechanism, number: Number) -> Number | None:
    """The same number of the mechanism without clearances; None for one of a clearance."""
    component = mechanism.components[number.component]
    places = (place for place, each in enumerate(ideal.components) if each is component)
    place = next(places, None)
    return None if place is None else replace(number, component=place)


def effects(system: System, numbers: Sequence[Number | None]) -> Effects:
    """What changes with numbers, of a system whose numbers they are; nothing with None."""
    layout, mechanism = system.layout, system.mechanism
    half = len(layout.coordinates)
    rows = {name: row for row, name in enumerate(layout.coordinates)}
    state = np.zeros((2 * half, len(numbers)))
    fed: list[dict[KeyPath, float]] = [{} for _ in numbers]
    knots: set[tuple[int, KeyPath]] = set()
    there = {k: number for k, number in enumerate(numbers) if number is not None}
    for place in sorted({number.component for number in there.values()}):
        own = {k: number for k, number in there.items() if number.component == place}
        terms = _dual_terms(mechanism, place, own)
        for path, value in moved(terms):
            if path in system.model.inputs.parameters and isinstance(value, Dual):
                for k, slope in value.slopes.items():
                    fed[k][path] = slope
        for table in tabulated(terms):
            if (*table.path, "spline", 0) in system.model.inputs.parameters:
                for k, entries, still in _splines(table):
                    fed[k] |= entries
                    knots |= {(k, path) for path in still}
        for name, value, rate in initial_values(terms):
            for row, entry in ((rows.get(name), value), (rows.get(name, 0) + half, rate)):
                if name in rows and row is not None and isinstance(entry, Dual):
                    for k, slope in entry.slopes.items():
                        state[row, k] = slope
    slopes = np.array([slope for each in fed for slope in each.values()], dtype=float)
    paths = tuple(tuple(each) for each in fed)
    return Effects(paths, slopes, state, np.array([one in knots for one in slots(paths)], bool))


def moved(item: Any) -> Iterator[tuple[KeyPath, FollowedNumber]]:
    """Path and value of the parameters in a term that follow from numbers."""
    match item:
        case Parameter(path, FollowedNumber() as value):
            yield path, value
        case _:
            for part in parts_of(item):
                yield from moved(part)


def _dual_terms(mechanism: Mechanism, place: int, numbers: dict[int, Number]) -> tuple[Term, ...]:
    """What a component contributes, with derivatives along some of its numbers."""

    def dual(k: int) -> Callable[[Any], Any]:
        def made(number: Any) -> Dual:
            if isinstance(number, Dual):
                return Dual(number.value, {**number.slopes, k: 1.0})
            return Dual(float(number), {k: 1.0})

        return made

    made = [(number, dual(k)) for k, number in numbers.items()]
    try:
        terms = terms_with(mechanism, place, made)
        laws = [table for term in terms if isinstance(term, Prescribed) for table in _tables(term)]
        if any(True for table in laws for _ in moved(table.over)):
            raise TypeError("how far along a curve a drive is")
        for table in tabulated(terms):
            if any(isinstance(place, Dual) for place in table.places):
                raise TypeError("the places of a table")
            if table.periodic and any(isinstance(table.values[end], Dual) for end in (0, -1)):
                raise TypeError("the first and the last value, which are one, of what repeats")
            if table.interpolation == "pchip":
                raise TypeError("the coefficients of a table that is joined by pchip")
    except TypeError as error:
        first = next(iter(numbers.values()))
        message = f"no derivative is known of what follows from this number ({error})"
        refusal = mechanism.error([(split(first.path) or (), message)])
        raise NoDerivativeError(refusal.source, refusal.problems) from None
    return terms


def terms_with(
    mechanism: Mechanism, place: int, made: Iterable[tuple[Number, Callable[[Any], Any]]]
) -> tuple[Term, ...]:
    """What a component contributes with others in the place of some of its numbers."""
    component: Any = mechanism.components[place]
    for number, make in made:
        component = _replaced(component, number.keys, make)
    return mechanism.terms_of(component)


def _tables(drive: Prescribed) -> Iterator[Table]:
    return (leaf for leaf in leaves(drive.law) if isinstance(leaf, Table))


def tabulated(item: Any) -> Iterator[Table]:
    """Tables in which followed numbers stand, with what follows from them."""
    match item:
        case Table(_, places, values):
            if any(isinstance(number, FollowedNumber) for number in (*places, *values)):
                yield item
            yield from tabulated(item.over)
        case Relation(profile=Table() as profile):
            yield from tabulated((profile, profile.bends))
        case _:
            for part in parts_of(item):
                yield from tabulated(part)


def _splines(table: Table) -> Iterator[tuple[int, dict[KeyPath, float], list[KeyPath]]]:
    """For each number in a table what it feeds, and which of that are knots.

    Coefficients are linear in the values: their derivatives are those of a table of derivatives.
    """
    slopes: list[Slopes] = [v.slopes if isinstance(v, Dual) else {} for v in table.values]
    for k in sorted({k for each in slopes for k in each}):
        moved = replace(table, values=tuple(each.get(k, 0.0) for each in slopes))
        entries = {
            (*table.path, "spline", place): number
            for place, number in enumerate(table_numbers(moved))
        }
        yield k, entries, [*entries][: len(entries) // 5 + 1]


def _replaced(part: Any, keys: Keys, make: Callable[[Any], Any]) -> Any:
    """A component with another number in the place of one of its numbers."""
    if not keys:
        return make(part)
    key, *rest = keys
    if isinstance(key, int):
        inner = _replaced(part[key], tuple(rest), make)
        return (*part[:key], inner, *part[key + 1 :])
    if isinstance(part, Mapping):
        return {**part, key: _replaced(part[key], tuple(rest), make)}
    changed = copy.copy(part)
    # components are frozen and checked; what stands for a number passes by both
    object.__setattr__(changed, key, _replaced(getattr(part, key), tuple(rest), make))
    return changed


def _has_effect(mechanism: Mechanism, number: Number) -> bool:
    try:
        terms = _dual_terms(mechanism, number.component, {0: number})
    except InputError:
        return False
    initial = (value for _, *pair in initial_values(terms) for value in pair)
    follows = any(moved(terms)) or any(tabulated(terms))
    return follows or any(isinstance(value, Dual) for value in initial)


def _named(mechanism: Mechanism, path: str) -> Number | str:
    result = owner(mechanism, path)
    if result is None:
        return "found no number there" + near_number(path, mechanism)
    place, steps = result
    component = mechanism.components[place]
    keys = _keys(component, steps[len(component.path) :])
    if isinstance(keys, str):
        return keys + (near_number(path, mechanism) if keys.startswith("found no") else "")
    number = Number(path, place, keys)
    _dual_terms(mechanism, place, {0: number})
    if not _has_effect(mechanism, number):
        return "this number does not enter the equations, so nothing changes with it"
    return number


def _keys(component: Component, steps: KeyPath) -> Keys | str:
    """Attributes and indices along steps to a number, or what is wrong with them."""
    wanted, field = tuple(map(str, steps)), _field(component)
    named = [alias for alias, name in _names(component).items() if name == field]
    for own, keys, leaf in _leaves(component):
        texts = tuple(map(str, own))
        if wanted != texts and (keys[:1] != (field,) or wanted != (*named, *texts)):
            continue
        if leaf is None:
            return "the definition does not give this number, and it follows from others; give it"
        if isinstance(leaf, Formula):
            return "found a formula; give its number a name in 'parameters', and ask for that"
        return keys
    return "found no number there"


def _entry(part: Any, key: str | int) -> Any:
    """What a key leads to: an entry of a list or a mapping, or an attribute."""
    held: Any = part
    return held[key] if isinstance(part, tuple | Mapping) else getattr(part, str(key))


def _leaves(part: Any) -> Iterator[tuple[KeyPath, Keys, float | Formula | None]]:
    """Steps and keys of all numbers of a component, and of formulas and gaps in their places."""
    field: str | None = None
    entries: dict[str | int, tuple[str | int, Any]] = {}
    match part:
        case Constant():
            yield (), ("value",), part.value
            return
        case float() | Formula() | None:
            yield (), (), part
            return
        case tuple():
            entries = {index: (index, entry) for index, entry in enumerate(part)}
        case Mapping():
            entries = {name: (name, entry) for name, entry in part.items()}
        case _:
            field = _field(part) if isinstance(part, Component) else None
            entries = {alias: (key, getattr(part, key)) for alias, key in _names(part).items()}
    for step, (key, entry) in entries.items():
        for steps, keys, leaf in _leaves(entry):
            yield (steps if key == field else (step, *steps)), (key, *keys), leaf


def _names(part: Any) -> dict[str, str]:
    """Keys of a definition → attributes."""
    infos = infos_of(type(part))
    attributes = getattr(type(part), "__pydantic_fields__", {})
    return dict(zip(infos, attributes, strict=True))


def _field(component: Component) -> str | None:
    """The attribute that takes an entry which is not a mapping of keys."""
    section = SECTIONS.get(component.section)
    return None if section is None else section.field


def near_number(path: str, mechanism: Mechanism) -> str:
    """A suggestion of the number of a definition that a path may mean; empty if none is near."""
    near = nearest(path, [number.path for number in written(mechanism)])
    return f"; did you mean {near!r}?" if near is not None else ""


def _no_match(mechanism: Mechanism) -> str:
    first = next((number.path for number in written(mechanism)), None)
    example = "" if first is None else f"; there are such as {first!r}"
    return f"no number of the definition fits this pattern{example}"
