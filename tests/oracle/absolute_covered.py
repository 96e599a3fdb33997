"""What the absolute formulation covers; it refuses everything else by name."""

from linkages.components.contributed.component import Term
from linkages.components.contributed.load_measures import ClearanceFriction, JointFriction, Load
from linkages.components.contributed.terms import (
    GUIDED,
    Body,
    CamSize,
    Displacement,
    Gravity,
    GroundPin,
    Hint,
    Initial,
    NamedNumber,
    PointMass,
    Prescribed,
    Relation,
)
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.reading.paths import KeyPath, dotted

COVERED: dict[type[Term], set[str]] = {
    Body: {"name", "kind", "path", "points", "mass", "inertia", "centre", "guide"},
    GroundPin: {"joint", "position"},
    # that a link rubs moves nothing: outputs of wear are not compared
    Displacement: {"name", "joint", "body", "renamed", "links", "rubbing"},
    Relation: {"body", "parts", "offset", "path", "inverse", "profile"},
    # of forces across guides, which are not compared
    CamSize: {"slider", "base", "roller", "eccentricity", "flat"},
    PointMass: {"joint", "mass", "path"},
    Prescribed: {"body", "law", "path", "deviation"},
    Initial: {"body", "position", "speed", "path", "keys"},
    Gravity: {"x", "y"},
    Hint: {"joint", "position", "side", "path"},
    NamedNumber: {"number"},
    Load: {"measure", "law", "path", "called", "applied", "stores", "states", "bearing"},
    JointFriction: {"joint", "bodies", "law", "path", "called", "stores", "states"},
    ClearanceFriction: {"clearance", "law", "path"},
}
"""Term → its fields: another field may change what the term does."""


class NotCoveredError(Exception):
    """The absolute formulation has no equations for part of a mechanism."""

    def __init__(self, path: KeyPath, what: str) -> None:
        super().__init__(f"{dotted(path)}: {what}")


def require_covered(mechanism: Mechanism) -> None:
    """Refuse a mechanism with something that has no equations here."""
    for component, terms in zip(mechanism.components, mechanism.term_groups, strict=True):
        for term in terms:
            if type(term) not in COVERED:
                raise NotCoveredError(component.path, type(term).__name__)
            if isinstance(term, Body) and term.kind == GUIDED:  # it has no point of its own
                raise NotCoveredError(component.path, term.kind)
            if getattr(term, "deviation", None):  # no file has one: masters of FMUs give it
                raise NotCoveredError(component.path, "deviation")
            if getattr(term, "states", ()):
                raise NotCoveredError(component.path, "internal state")
