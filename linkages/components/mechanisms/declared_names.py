"""Names that components declare, and names that formulas refer to."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from typing import Any

from linkages.components.contributed.component import Component, Term
from linkages.components.contributed.functions import PRESSED
from linkages.components.contributed.load_measures import (
    GROUND,
    Actuation,
    ClearanceFriction,
    End,
    JointFriction,
    Load,
)
from linkages.components.contributed.normal_forces import WITHOUT_ROOM, Contact
from linkages.components.contributed.state_laws import leaves
from linkages.components.contributed.terms import (
    GUIDED,
    Body,
    Displacement,
    GroundPin,
    Hint,
    Initial,
    Play,
    Prescribed,
    Relation,
    oriented,
)
from linkages.components.laws import TablePoints
from linkages.components.scene import NumberOfFormulas
from linkages.components.state_equations import SampledState, StateEquation
from linkages.reading.paths import KeyPath
from linkages.reading.wording import nearest, suggestion
from linkages.spec.formulas import (
    CALLED,
    PARAMETER,
    VALUE,
    Formula,
    Powers,
    Sensed,
    described,
    measured,
    powers,
    require,
)
from linkages.spec.grammar import NumberError
from linkages.spec.law_fields import LawRule
from linkages.spec.models import alternatives, entries_of, fields, rule_of, written_fields
from linkages.spec.units import Dimension, unit


class Declared:
    """The names that a set of components declares."""

    def __init__(
        self,
        components: Iterable[Component],
        # Ground joints, other joints, and names with kinds of bodies that entries declare although
        # they could not be built
        ground: Iterable[str] = (),
        joints: Iterable[str] = (),
        bodies: Iterable[tuple[str, str]] = (),
        complete: bool = True,  # if not, nothing can be said of a name that is not among these
    ) -> None:
        components = tuple(components)
        groups = [(c, c.terms()) for c in components]
        terms = [(c, term) for c, own in groups for term in own]
        self.ground = {t.joint for _, t in terms if isinstance(t, GroundPin)} | set(ground)
        built_of = ((c.path, t) for c, t in terms if isinstance(t, Body))
        self.bodies = [(path, body) for path, body in built_of if body.kind != GUIDED]
        self.displacements = [(c.path, t) for c, t in terms if isinstance(t, Displacement)]
        self.driven = {t.body: t.path for _, t in terms if isinstance(t, Prescribed)}
        self.free = {t.body: t.path for _, t in terms if isinstance(t, Initial)}
        self.actuations = [t for _, t in terms if isinstance(t, Actuation)]
        known = {*self.driven, *self.free}
        self.relations = oriented((t for _, t in terms if isinstance(t, Relation)), known)
        self.frictions = [t for _, t in terms if isinstance(t, JointFriction)]
        self.plays = [(c.path, t) for c, t in terms if isinstance(t, Play)]
        contacts = [t for _, t in terms if isinstance(t, Contact)]
        self.walls = [t for t in contacts if isinstance(t.geometry, WITHOUT_ROOM)]
        self.opening = {t.name for t in contacts if t not in self.walls}
        self.opening |= {play.name for _, play in self.plays}
        self.rigid = [
            t for _, t in terms if isinstance(t, End) or (isinstance(t, Contact) and t.rigid)
        ]
        self.pressed = [(t.path, t.joint) for t in self.frictions if PRESSED in leaves(t.law)]
        loads = [t for _, t in terms if isinstance(t, Load)]
        self.pressed += [(load.path, load.bearing.body) for load in loads if load.bearing]
        self.rubbing = [t for _, t in terms if isinstance(t, ClearanceFriction)]
        self.by_name = {body.name: body for _, body in self.bodies}
        self.kinds: dict[str, set[str]] = {}
        built = [(body.name, body.kind) for _, body in self.bodies]
        built += [(term.name, "clearance") for _, term in self.displacements]
        built += [(term.name, "clearance") for _, term in self.plays]
        for name, kind in [*bodies, *built]:
            self.kinds.setdefault(name, set()).add(kind)
        self.numbers = {c.name: c.value for c in components if isinstance(c, NumberOfFormulas)}
        self.states = {
            c.name: c.initial for c in components if isinstance(c, StateEquation | SampledState)
        }
        self.instead = {name: c.no_body for c in components if c.no_body for name in c.path[1:]}
        self.complete = complete
        self.uncertain = set(joints)  # more bodies may be there than could be built
        self.faulty = {name for name, _ in bodies}  # what they are like is not known
        users = (c.references() for c, own in groups if own and not any_hint(own))
        used = {joint for names in users for _, joint in (*names.joints, *names.moving)}
        self.air = self._on_air(used)
        points = {joint for _, body in self.bodies for joint in body.points}
        self.joints = self.ground | self.uncertain | (points - {joint for _, joint in self.air})

    def _on_air(self, used: set[str]) -> list[tuple[KeyPath, str]]:
        """Sliders' joints that nothing else has, needs or gives a motion: misspelt, most likely."""
        held = self.ground | self.uncertain | used
        held |= {joint for _, body in self.bodies if body.rotates for joint in body.points}
        carriers = {body.guide.body for _, body in self.bodies if body.guide is not None}
        tied = {n for r in self.relations for n in (r.body, *(name for name, _ in r.parts))}
        carriers |= set(self.driven) | set(self.free) | tied
        result = []
        for path, body in self.bodies:
            if body.rotates or body.name in carriers:
                continue
            joint = next(iter(body.points))
            if joint in held:
                continue
            if not any(b is not body and joint in b.points for _, b in self.bodies):
                result.append((path, joint))
        return result


def any_hint(terms: Iterable[Term]) -> bool:
    """Whether a component only says about where something is."""
    return any(isinstance(term, Hint) for term in terms)


def expected_one_of(name: str, names: Iterable[str], what: str) -> str:
    """What to say of an unknown name: the nearest right one, or all that there are."""
    known = sorted(names)
    near = nearest(name, known)
    if near is not None:
        return f"unknown {what} {name!r}; did you mean {near!r}?"
    listed = ", ".join(known[:12]) or "none"
    return f"unknown {what} {name!r}; expected one of: {listed}"


Finding = tuple[KeyPath, str]

_TURNS = ("bar", "plate", "clearance")
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
            place, given = (*component.path, key), component.dimension_of(key)
            result = list(_inside(value, place, fields(model)[key], declared, given))
            sound = sound and not result
            yield from result
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


def _inside(
    value: Any, path: KeyPath, annotation: Any, declared: Declared, given: Dimension | None = None
) -> Iterator[Finding]:
    match value:
        case Formula():
            rules = (rule_of(arm) for arm in alternatives(annotation))
            expected = next((r.dimension for r in rules if isinstance(r, LawRule)), given)
            yield from _of_formula(value, path, expected, declared)
        case tuple():
            entries = entries_of(annotation) if value and len(value) < _MANY else ()
            for place, (entry, inner) in enumerate(zip(value, entries, strict=False)):
                yield from _inside(entry, (*path, place), inner, declared)
        case TablePoints() if value.over is not None:
            result = list(_of_formula(value.over, (*path, "over"), None, declared))
            yield from result or _of_places(value, path, declared)
        case _:
            for key, entry in (written_fields(value) or {}).items():
                if isinstance(entry, TablePoints | Formula):
                    yield from _inside(entry, (*path, key), Any, declared)


_MANY = 8
"""Lists of formulas are short: the components of a force."""


def _of_formula(
    formula: Formula, path: KeyPath, expected: Dimension | None, declared: Declared
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


def _of_places(points: TablePoints[Any], path: KeyPath, declared: Declared) -> Iterator[Finding]:
    """Places are on the axis of what the table is a function of."""
    assert points.over is not None
    given = {place: at.unit for place, at in enumerate(points.at) if at.unit is not None}
    try:
        result = measured(points.over, lambda node: _powers(node, declared))
    except NumberError as error:
        if points.over.has_units or given:
            yield (*path, "over"), f"found {points.over.text!r}: {error}"
        return
    for place, own in given.items():
        if powers(own) != (result or {}):
            what = f"{points.over.text!r} is {described(result or {})}"
            yield (*path, "at", place), f"{what}, and this is {described(powers(own))}"
            return


def _powers(node: Sensed, declared: Declared) -> Powers | None:
    """What a quantity measures; a number without a unit is in SI, and may be anything."""
    if node.word in (PARAMETER, VALUE):
        named = declared.numbers if node.word == PARAMETER else declared.states
        own = named.get(node.names[0])
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
    if word == VALUE:
        if names[0] in declared.states or not declared.complete:
            return ""
        return expected_one_of(names[0], declared.states, "state")
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
