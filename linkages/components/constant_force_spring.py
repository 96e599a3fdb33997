"""Springs that pull with the same force at any length."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import component
from linkages.components.contributed.functions import Number, X
from linkages.components.contributed.listed import ListedComponent
from linkages.components.contributed.measures import Distance, Load, damper_law
from linkages.components.contributed.references import References
from linkages.components.contributed.terms import Path
from linkages.components.laws.law import DampingLaw, function_of
from linkages.components.spring import ends, two_joints
from linkages.spec.quantities import Force, Name


@component
class ConstantForceSpring(ListedComponent):
    """A spring that pulls two joints together with a constant force, and a damper beside it.

    Parameters
    ----------
    index
        Place in the list of springs.
    between
        Two joints; one may be fixed to the ground.
    force
        Newtons; one below zero pushes.
    damping
        N·s/m, ≥ 0, or a law.
    """

    section: ClassVar[str] = "springs"
    told_by: ClassVar[str] = "force"

    index: int
    between: tuple[Name, Name]
    force: Force
    damping: DampingLaw = 0.0

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Two different joints."""
        return two_joints((*self.path, "between"), self.between)

    def references(self) -> References:
        """The joints."""
        return References(joints=ends((*self.path, "between"), self.between))

    def terms(self) -> tuple[Load, ...]:
        """One spring, whose energy is force times distance."""
        force = Number(self.number("force"))
        law = damper_law(function_of(self.damping, (*self.path, "damping"))) - force
        measure = Distance(*self.between)
        return (Load(measure, law, self.path, called="constant-force spring", stores=force * X),)
