"""Joints fixed to the ground."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import Component, component
from linkages.components.contributed.terms import GroundPin
from linkages.spec.quantities import Name, Point


@component
class GroundJoint(Component):
    """A fixed pivot: a joint on the ground.

    Parameters
    ----------
    name
        Joint name.
    position
        Coordinates in metres.
    """

    section: ClassVar[str] = "joints"

    name: Name
    position: Point

    def terms(self) -> tuple[GroundPin, ...]:
        """One pin; a coordinate of exactly zero is structure."""
        return (GroundPin(self.name, self.pair(self.position)),)
