"""Springs between joints, with a damper beside them."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import component
from linkages.components.contributed.listed import ListedComponent
from linkages.components.contributed.measures import Distance, Load, spring_law
from linkages.components.contributed.references import References
from linkages.components.contributed.terms import Path
from linkages.components.laws.law import DampingLaw, StiffnessLaw, function_of
from linkages.spec.quantities import Name, NonNegativeLength


@component
class JointSpring(ListedComponent):
    """A spring and a damper side by side that pull two joints together.

    Parameters
    ----------
    index
        Place in the list of springs.
    between
        Two joints; one may be fixed to the ground.
    stiffness
        N/m, ≥ 0, or a law.
    length
        Length without force in metres, ≥ 0.
    damping
        N·s/m, ≥ 0, or a law.
    """

    section: ClassVar[str] = "springs"

    index: int
    between: tuple[Name, Name]
    stiffness: StiffnessLaw
    length: NonNegativeLength
    damping: DampingLaw = 0.0

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Two different joints."""
        return two_joints((*self.path, "between"), self.between)

    def references(self) -> References:
        """The joints."""
        return References(joints=ends((*self.path, "between"), self.between))

    def terms(self) -> tuple[Load, ...]:
        """A spring and damper; numbers of exactly zero are structure."""
        law = spring_law(
            function_of(self.stiffness, (*self.path, "stiffness")),
            self.number("length"),
            function_of(self.damping, (*self.path, "damping")),
        )
        return (Load(Distance(*self.between), law, self.path),)


def ends(path: Path, joints: tuple[str, str]) -> tuple[tuple[Path, str], ...]:
    """References to the joints of a list at a path."""
    return tuple(((*path, place), joint) for place, joint in enumerate(joints))


def two_joints(path: Path, joints: tuple[str, str]) -> tuple[tuple[Path, str], ...]:
    """What is wrong with a pair of joints."""
    if joints[0] == joints[1]:
        return ((path, f"expected two different joints, found {joints[0]!r} twice"),)
    return ()
