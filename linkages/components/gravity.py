"""Uniform gravity."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import Component, component
from linkages.components.contributed.terms import Gravity
from linkages.spec.quantities import AccelerationVector


@component
class UniformGravity(Component):
    """Gravitational acceleration, the same everywhere.

    Parameters
    ----------
    acceleration
        Components along x and y in m/s².
    """

    section: ClassVar[str] = "gravity"

    acceleration: AccelerationVector

    def terms(self) -> tuple[Gravity, ...]:
        """A component of exactly zero is structure: its terms are left out."""
        return (Gravity(*self.pair(self.acceleration)),)
