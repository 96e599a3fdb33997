"""Whether the components of a mechanism fit together: every finding, not only the first."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

from linkages.components.component import Component
from linkages.components.terms import (
    Body,
    Displacement,
    GroundPin,
    Initial,
    Path,
    Prescribed,
)
from linkages.reading.wording import nearest

Finding = tuple[Path, str]


class Declared:
    """The names that a set of components declares.

    Parameters
    ----------
    components
        Components that could be built.
    ground, joints, bodies
        Ground joints, other joints, and names with kinds of bodies that entries declare
        although they could not be built.
    complete
        Whether that is everything; if not, nothing can be said of a name that is not among it.
    """

    def __init__(
        self,
        components: Iterable[Component],
        ground: Iterable[str] = (),
        joints: Iterable[str] = (),
        bodies: Iterable[tuple[str, str]] = (),
        complete: bool = True,
    ) -> None:
        terms = [(c, term) for c in components for term in c.terms()]
        self.ground = {t.joint for _, t in terms if isinstance(t, GroundPin)} | set(ground)
        self.bodies = [(c.path, t) for c, t in terms if isinstance(t, Body)]
        self.displacements = [(c.path, t) for c, t in terms if isinstance(t, Displacement)]
        self.driven = {t.body: t.path for _, t in terms if isinstance(t, Prescribed)}
        self.free = {t.body: t.path for _, t in terms if isinstance(t, Initial)}
        self.kinds = dict(bodies)
        self.kinds |= {body.name: body.kind for _, body in self.bodies}
        self.kinds |= {term.link.name: "clearance" for _, term in self.displacements}
        turning = {joint for _, body in self.bodies if body.rotates for joint in body.points}
        self.joints = self.ground | set(joints) | turning
        self.complete = complete
        self.uncertain = set(joints)  # more bodies may be there than could be built


def findings(components: Sequence[Component], declared: Declared) -> list[Finding]:
    """Everything that is inconsistent, as pairs of a path and a sentence."""
    found = [problem for component in components for problem in component.problems()]
    if declared.complete:
        found += _unknown_names(components, declared)
        found += _sliders_on_air(declared)
    found += _repeated_entries(components)
    found += _repeated_names(declared)
    found += _misplaced_clearances(declared)
    found += _contested_coordinates(declared)
    return found


def _expected(name: str, names: Iterable[str], what: str) -> str:
    known = sorted(names)
    near = nearest(name, known)
    if near is not None:
        return f"unknown {what} {name!r}; did you mean {near!r}?"
    listed = ", ".join(known[:12]) or "none"
    return f"unknown {what} {name!r}; expected one of: {listed}"


def _unknown_names(components: Sequence[Component], declared: Declared) -> list[Finding]:
    found: list[Finding] = []
    for references in (component.references() for component in components):
        for path, joint in references.joints:
            if joint not in declared.joints:
                found.append((path, _expected(joint, declared.joints, "joint")))
        for path, joint in references.ground:
            if joint not in declared.ground:
                found.append((path, _expected(joint, declared.ground, "ground joint")))
        for path, name, kinds in references.bodies:
            if declared.kinds.get(name) not in kinds:
                of_kind = [n for n, kind in declared.kinds.items() if kind in kinds]
                found.append((path, _expected(name, of_kind, kinds[0])))
    return found


def _repeated_entries(components: Sequence[Component]) -> list[Finding]:
    """Entries at one place of the definition, which only Python code can make.

    Bodies are left to `_repeated_names`, which knows more places.
    """
    seen: set[Path] = set()
    found: list[Finding] = []
    for component in components:
        named = any(isinstance(term, Body | Displacement) for term in component.terms())
        if component.path in seen and not named:
            found.append((component.path, "given already; expected once"))
        seen.add(component.path)
    return found


def _repeated_names(declared: Declared) -> list[Finding]:
    places = [*declared.bodies, *((path, term.link) for path, term in declared.displacements)]
    counts = Counter(body.name for _, body in places)
    seen: set[str] = set()
    found: list[Finding] = []
    for path, body in places:
        if body.name in seen:
            found.append((path, f"the name {body.name!r} is taken already; expected a new one"))
        seen.add(body.name)
    if "ground" in counts:
        path = next(path for path, body in places if body.name == "ground")
        found.append((path, "the name 'ground' stands for the frame; expected another one"))
    return found


def _misplaced_clearances(declared: Declared) -> list[Finding]:
    bodies = {body.name: body for _, body in declared.bodies}
    found: list[Finding] = []
    taken: dict[tuple[str, str], str] = {}
    for path, term in declared.displacements:
        body = bodies.get(term.body)
        if body is None:
            continue
        if term.joint not in body.points:
            ends = ", ".join(body.points)
            found.append(
                ((*path, "joint"), f"bar {body.name!r} has no joint {term.joint!r}; it has {ends}")
            )
        elif (term.joint, term.body) in taken:
            other = taken[term.joint, term.body]
            found.append((path, f"clearance {other!r} is between the same joint and bar"))
        elif _only_one_at(term.joint, declared):
            found.append((path, f"nothing but bar {body.name!r} is at joint {term.joint!r}"))
        taken[term.joint, term.body] = term.link.name
    return found


def _only_one_at(joint: str, declared: Declared) -> bool:
    if joint in declared.ground or joint in declared.uncertain or not declared.complete:
        return False
    return sum(joint in body.points for _, body in declared.bodies) < 2


def _sliders_on_air(declared: Declared) -> list[Finding]:
    return [
        ((*path, "joint"), _expected(joint, declared.joints, "joint"))
        for path, body in declared.bodies
        if not body.rotates
        for joint in body.points
        if joint not in declared.joints
    ]


def _contested_coordinates(declared: Declared) -> list[Finding]:
    return [
        (path, f"the coordinate of {name!r} is both driven and free; expected one of the two")
        for name in declared.driven
        if name in declared.free
        for path in (declared.driven[name], declared.free[name])
    ]
