"""Masses concentrated at joints."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import Component, component
from linkages.components.contributed.references import References
from linkages.components.contributed.terms import Parameter, PointMass
from linkages.spec.quantities import Mass, Name


@component
class JointMass(Component):
    """A mass concentrated at a joint: a payload, a pin, a bob.

    Parameters
    ----------
    name
        A joint that moves.
    mass
        Kilograms, ≥ 0.
    """

    section: ClassVar[str] = "masses"

    name: Name
    mass: Mass

    def references(self) -> References:
        """The joint."""
        return References(moving=((self.path, self.name),))

    def terms(self) -> tuple[PointMass, ...]:
        """One point mass; exactly zero is structure."""
        return (PointMass(self.name, Parameter(self.path, self.mass, structural=True), self.path),)
