"""Which of its assembly modes a mechanism starts in."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from linkages.components.contributed.component import Component, component
from linkages.components.contributed.references import References
from linkages.components.contributed.terms import Hint
from linkages.spec.quantities import Name, Point

SIDES = {"left": 1, "right": -1}


@component
class AssemblyHint(Component):
    """Where a joint is at t = 0.

    Parameters
    ----------
    name
        Joint name.
    where
        About where the joint is, or its side ("left" or "right") seen along the line between
        its two neighbour joints, in the order in which their bars stand in the file.
    """

    section: ClassVar[str] = "assembly"

    name: Name
    where: Annotated[Literal["left", "right"] | Point, Field(union_mode="left_to_right")]

    def references(self) -> References:
        """The joint."""
        return References(joints=((self.path, self.name),))

    def terms(self) -> tuple[Hint, ...]:
        """One hint."""
        if isinstance(self.where, str):
            return (Hint(self.name, None, SIDES[self.where], self.path),)
        return (Hint(self.name, self.where, None, self.path),)
