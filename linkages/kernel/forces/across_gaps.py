"""The nodes of whatever acts across a gap."""

from __future__ import annotations

from typing import TYPE_CHECKING, assert_never

from linkages.components.contributed.contacts import Contact, NormalForce, OilFilm, RigidContact
from linkages.kernel.forces.across import GapNodes
from linkages.kernel.forces.contacts import PressingNodes
from linkages.kernel.forces.films import FilmNodes
from linkages.kernel.forces.impacts import RigidNodes

if TYPE_CHECKING:
    from linkages.kernel.model import Model


def gap_nodes(model: Model, contact: Contact) -> GapNodes:
    """The nodes of a contact, or of a film."""
    match contact.normal:
        case NormalForce() as law:
            return PressingNodes(model, contact, law)
        case RigidContact() as law:
            return RigidNodes(model, contact, law)
        case OilFilm() as law:
            return FilmNodes(model, contact, law)
        case _ as law:
            assert_never(law)
