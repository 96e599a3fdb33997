"""Whether what formulas name exists, and whether they measure what stands in their place."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any

from linkages.components.contributed.component import Component
from linkages.components.contributed.listed import TURNING
from linkages.components.contributed.revolute import GROUND
from linkages.components.contributed.terms import Path
from linkages.components.laws.table import TablePoints
from linkages.components.mechanisms.declared import Declared, expected_one_of
from linkages.reading.wording import suggestion
from linkages.spec.annotations import alternatives, entries_of, fields, rule_of, written_fields
from linkages.spec.dimensions import Dimension
from linkages.spec.formula_dimensions import Powers, described, measured, powers, require
from linkages.spec.formulas import CALLED, PARAMETER, Formula, Sensed
from linkages.spec.grammar import NumberError
from linkages.spec.laws import LawRule
from linkages.spec.units import unit

Finding = tuple[Path, str]

_TURNS = (*TURNING, "clearance")
_OF = {
    **dict.fromkeys(("position", "velocity"), ("slider",)),
    "angle": _TURNS,
    "speed": (*_TURNS, "slider"),
}
_UNITS = {"position": "m", "x": "m", "y": "m", "distance": "m", "angle": "rad"}
_RATES = {"velocity": "m/s", "vx": "m/s", "vy": "m/s"}


def formula_findings(components: Collection[Component], declared: Declared) -> Iterator[Finding]:
    """What is wrong with the formulas of components; each is reported once."""
    for component in components:
        model: Any = type(component)
        sound = True
        for key, value in (written_fields(component) or {}).items():
            found = list(_inside(value, (*component.path, key), fields(model)[key], declared))
            sound = sound and not found
            yield from found
        if sound:
            yield from component.measuring(
                lambda formula: measured(formula, lambda node: _powers(node, declared))
            )


def formulas_in(value: Any) -> Iterator[Formula]:
    """All formulas of a component."""
    if isinstance(value, Formula):
        yield value
    elif isinstance(value, tuple):
        for entry in value[:_MANY]:
            yield from formulas_in(entry)
    else:
        for entry in (written_fields(value) or {}).values():
            yield from formulas_in(entry)


def _inside(value: Any, path: Path, annotation: Any, declared: Declared) -> Iterator[Finding]:
    match value:
        case Formula():
            rules = (rule_of(arm) for arm in alternatives(annotation))
            expected = next((r.dimension for r in rules if isinstance(r, LawRule)), None)
            yield from _of_formula(value, path, expected, declared)
        case tuple():
            entries = entries_of(annotation) if value and len(value) < _MANY else ()
            for place, (entry, inner) in enumerate(zip(value, entries, strict=False)):
                yield from _inside(entry, (*path, place), inner, declared)
        case TablePoints() if value.over is not None:
            found = list(_of_formula(value.over, (*path, "over"), None, declared))
            yield from found or _of_places(value, path, declared)
        case _:
            for key, entry in (written_fields(value) or {}).items():
                if isinstance(entry, TablePoints | Formula):
                    yield from _inside(entry, (*path, key), Any, declared)


_MANY = 8
"""Lists of formulas are short: the components of a force."""


def _of_formula(
    formula: Formula, path: Path, expected: Dimension | None, declared: Declared
) -> Iterator[Finding]:
    names = [node for node in formula.nodes() if isinstance(node, Sensed)]
    faults = [(node, why) for node in names if (why := _unknown(node, declared))]
    for node, why in faults[:1]:
        yield path, f"{why} (character {node.span[0] + 1} of {formula.text!r})"
    if faults or expected is None:
        return
    try:
        shared = any(node.word == PARAMETER and _powers(node, declared) for node in names)
        require(formula, expected, lambda node: _powers(node, declared), shared)
    except NumberError as error:
        place = "" if error.at is None else f" (character {error.at + 1})"
        yield (
            path,
            f"expected {expected.article} ({expected.unit}), found {formula.text!r}: "
            + (f"{error.message}{place}"),
        )


def _of_places(points: TablePoints[Any], path: Path, declared: Declared) -> Iterator[Finding]:
    """Places are on the axis of what the table is a function of."""
    assert points.over is not None
    given = {place: at.unit for place, at in enumerate(points.at) if at.unit is not None}
    try:
        found = measured(points.over, lambda node: _powers(node, declared))
    except NumberError as error:
        if points.over.has_units or given:
            yield (*path, "over"), f"found {points.over.text!r}: {error}"
        return
    for place, own in given.items():
        if powers(own) != (found or {}):
            what = f"{points.over.text!r} is {described(found or {})}"
            yield (*path, "at", place), f"{what}, and this is {described(powers(own))}"
            return


def _powers(node: Sensed, declared: Declared) -> Powers | None:
    """What a quantity measures; a parameter without a unit is in SI, and may be anything."""
    if node.word == PARAMETER:
        own = declared.numbers.get(node.names[0])
        return None if own is None or own.unit is None else powers(own.unit)
    return powers(unit(_unit(node, declared)))


def _unit(node: Sensed, declared: Declared) -> str:
    if node.word == "speed":
        return "m/s" if "slider" in declared.kinds.get(node.names[0], ()) else "rad/s"
    unit = _RATES.get(node.word) or _UNITS[node.word]
    return f"{unit}/s" if node.rate else unit


def _unknown(node: Sensed, declared: Declared) -> str:
    """What is wrong with the names of a quantity; empty if nothing is."""
    word, names = node.word, node.names
    if word == PARAMETER:
        return _unknown_word(names[0], declared)
    if word in CALLED and len(names) == CALLED[word] and names[0] == names[1]:
        return f"{word}({', '.join(names)}) is that of {names[0]!r} with itself; expected two"
    for place, name in enumerate(names):
        if word in ("distance", "x", "y", "vx", "vy"):
            if name not in declared.joints:
                return expected_one_of(name, declared.joints, "joint")
            continue
        grounded = place == 0 and len(names) > 1 and name == GROUND
        if not grounded and (why := _other_kind(name, word, declared)):
            return why
    return ""


def _unknown_word(name: str, declared: Declared) -> str:
    if name in declared.numbers or not declared.complete:
        return ""
    near = suggestion(name, declared.numbers)
    own = f", {', '.join(declared.numbers)}" if declared.numbers else ""
    hint = near or f"; expected t, pi{own}, or a quantity such as crank.angle"
    return f"unknown name {name!r}{hint}"


def _other_kind(name: str, word: str, declared: Declared) -> str:
    kinds, wanted = declared.kinds.get(name, set()), _OF[word]
    if name in declared.opening:
        return (
            f"clearance {name!r} has 'contact': what moves in it has two coordinates, and no "
            f"{word!r}; expected quantities of the joint or of bodies"
        )
    if kinds & set(wanted):
        return ""
    if kinds:
        kind = next(iter(kinds))
        own = [w for w, of in _OF.items() if kind in of]
        return f"{kind} {name!r} has no {word!r}; expected {' or '.join(map(repr, own[:2]))}"
    known = [n for n, own_kinds in declared.kinds.items() if own_kinds & set(wanted)]
    return expected_one_of(name, known, wanted[0] if len(wanted) == 1 else "body")
