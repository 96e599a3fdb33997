"""Ends of ways at which bodies bounce: what stops by restitution contribute."""

from __future__ import annotations

from dataclasses import dataclass

from linkages.components.contributed.contacts import RigidContact
from linkages.components.contributed.measures import Measure, Turn
from linkages.components.contributed.terms import Parameter, Path


@dataclass(frozen=True)
class End:
    """A value that a measure does not pass.

    Parameters
    ----------
    name
        What results and sentences call it.
    measure
        What it ends.
    limit
        The value (m, rad).
    upper
        Whether the measure is not larger; otherwise it is not smaller.
    law
        Of the impacts there.
    path
        Where it stands in the definition file.
    """

    name: str
    measure: Measure
    limit: Parameter
    upper: bool
    law: RigidContact
    path: Path

    @property
    def twists(self) -> bool:
        """Whether it exerts a torque."""
        return isinstance(self.measure, Turn)
