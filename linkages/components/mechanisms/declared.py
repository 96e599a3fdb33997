"""The names that a set of components declares, and what to say of others."""

from __future__ import annotations

from collections.abc import Iterable

from linkages.components.contributed.component import Component
from linkages.components.contributed.contacts import Contact
from linkages.components.contributed.ends import End
from linkages.components.contributed.functions import PRESSED
from linkages.components.contributed.measures import ClearanceFriction, JointFriction, Load
from linkages.components.contributed.state_laws import leaves
from linkages.components.contributed.terms import (
    Body,
    Displacement,
    GroundPin,
    Hint,
    Initial,
    Path,
    Play,
    Prescribed,
    Relation,
    oriented,
)
from linkages.components.parameter import NumberOfFormulas
from linkages.reading.wording import nearest


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
        components = tuple(components)
        terms = [(c, term) for c in components for term in c.terms()]
        self.ground = {t.joint for _, t in terms if isinstance(t, GroundPin)} | set(ground)
        self.bodies = [(c.path, t) for c, t in terms if isinstance(t, Body)]
        self.displacements = [(c.path, t) for c, t in terms if isinstance(t, Displacement)]
        self.driven = {t.body: t.path for _, t in terms if isinstance(t, Prescribed)}
        self.free = {t.body: t.path for _, t in terms if isinstance(t, Initial)}
        known = {*self.driven, *self.free}
        self.relations = oriented((t for _, t in terms if isinstance(t, Relation)), known)
        self.frictions = [t for _, t in terms if isinstance(t, JointFriction)]
        self.plays = [(c.path, t) for c, t in terms if isinstance(t, Play)]
        self.opening = {t.name for _, t in terms if isinstance(t, Contact | Play)}
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
        self.instead = {name: c.no_body for c in components if c.no_body for name in c.path[1:]}
        self.complete = complete
        self.uncertain = set(joints)  # more bodies may be there than could be built
        self.faulty = {name for name, _ in bodies}  # what they are like is not known
        used = {
            joint
            for c, _ in terms
            if not any(isinstance(t, Hint) for t in c.terms())
            for _, joint in (*c.references().joints, *c.references().moving)
        }
        self.air = self._on_air(used)
        points = {joint for _, body in self.bodies for joint in body.points}
        self.joints = self.ground | self.uncertain | (points - {joint for _, joint in self.air})

    def _on_air(self, used: set[str]) -> list[tuple[Path, str]]:
        """Sliders' joints that nothing else has, needs or gives a motion: misspelt, most likely."""
        held = self.ground | self.uncertain | used
        held |= {joint for _, body in self.bodies if body.rotates for joint in body.points}
        carriers = {body.guide.body for _, body in self.bodies if body.guide is not None}
        tied = {n for r in self.relations for n in (r.body, *(name for name, _ in r.parts))}
        carriers |= set(self.driven) | set(self.free) | tied
        found = []
        for path, body in self.bodies:
            if body.rotates or body.name in carriers:
                continue
            joint = next(iter(body.points))
            others = [b for _, b in self.bodies if b is not body and joint in b.points]
            if joint not in held and not others:
                found.append((path, joint))
        return found


def expected_one_of(name: str, names: Iterable[str], what: str) -> str:
    """What to say of an unknown name: the nearest right one, or all that there are."""
    known = sorted(names)
    near = nearest(name, known)
    if near is not None:
        return f"unknown {what} {name!r}; did you mean {near!r}?"
    listed = ", ".join(known[:12]) or "none"
    return f"unknown {what} {name!r}; expected one of: {listed}"
