"""What acts across a gap: forces on both sides, whatever law they follow."""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property
from typing import TYPE_CHECKING, assert_never

from linkages.components.contributed.contacts import Contact, CornerAtWall, Geometry, PinInHole
from linkages.kernel.forces.corner_gaps import CornerGap
from linkages.kernel.forces.gaps import Gap, PinGap
from linkages.kernel.forces.loads import Acting
from linkages.kernel.graph.scalars import Scalar, ScalarGraph

if TYPE_CHECKING:
    from linkages.kernel.model import Model


def gap_of(model: Model, geometry: Geometry) -> Gap:
    """The gap of a contact."""
    match geometry:
        case PinInHole():
            return PinGap(model, geometry)
        case CornerAtWall():
            return CornerGap(model, geometry)
        case _:
            assert_never(geometry)


class GapNodes(Acting):
    """A gap, the forces across it, and what they store and dissipate."""

    model: Model
    graph: ScalarGraph
    contact: Contact
    gap: Gap

    def __init__(self, model: Model, contact: Contact) -> None:
        self.model, self.graph, self.contact = model, model.graph, contact
        self.gap = gap_of(model, contact.geometry)

    @property
    def touch(self) -> str:
        """Name of the mode of touching."""
        return f"{self.contact.name}: touch"

    @property
    @abstractmethod
    def touching(self) -> Scalar:
        """Mode: whether they touch."""

    @property
    @abstractmethod
    def force(self) -> Scalar:
        """Normal force, positive where it presses."""

    @property
    @abstractmethod
    def friction(self) -> Scalar:
        """Force along the direction of slip."""

    @property
    @abstractmethod
    def normal_loss(self) -> Scalar:
        """Power lost across the gap."""

    @property
    @abstractmethod
    def friction_loss(self) -> Scalar:
        """Power lost along the gap."""

    @cached_property
    def speed(self) -> Scalar:
        """The actual rate of the indentation."""
        return self.gap.rate(self.model.velocities)

    @property
    def working(self) -> Scalar:
        """Power of all but the elastic part, at the actual velocities."""
        return -(self.normal_loss + self.friction_loss)
