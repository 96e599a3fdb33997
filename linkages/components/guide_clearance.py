"""A slider with room in its guide: a block with four corners between two parallel walls."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import ClassVar

from linkages.components.contributed.component import component
from linkages.components.contributed.contacts import CORNERS, Contact, CornerAtWall, RigidContact
from linkages.components.contributed.references import References
from linkages.components.contributed.terms import Initial, Parameter, Path, Play
from linkages.components.contributed.touching import Touching
from linkages.spec.quantities import Angle, AngularSpeed, Length, Name, PositiveLength, Speed


@component
class GuideClearance(Touching):
    """A slider moves across its guide and turns in it as far as its corners let it.

    The block has two more free coordinates: ``name.offset``, how far its joint is from the middle
    of the guide, and ``name.tilt``, its angle in the guide. Results call its corners
    ``name.corner1`` to ``name.corner4``: those at the wall on the left of the axis, seen along it,
    the rear one first, then those at the other wall.

    Parameters
    ----------
    slider
        The slider; its joint is the middle of the block.
    size
        Distance from each wall in metres, > 0, of a block in the middle of its guide.
    length, height
        Of the block in metres, along its axis and across it.
    offset, rate
        How far the joint is from the middle of the guide at t = 0 in metres, to the left of the
        axis, and its rate in m/s.
    angle, speed
        Of the block in its guide at t = 0 (rad) and its rate (rad/s).
    """

    section: ClassVar[str] = "clearances"
    told_by: ClassVar[str] = "slider"

    slider: Name
    length: PositiveLength
    height: PositiveLength
    offset: Length = 0.0
    rate: Speed = 0.0
    angle: Angle = 0.0
    speed: AngularSpeed = 0.0

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Keys that the law has or lacks, a block that could turn over or starts in a wall."""
        found = [*self.contact_problems(), *self._of_the_block()]
        return tuple(((*self.path, key), message) for key, message in found)

    def _of_the_block(self) -> Iterator[tuple[str, str]]:
        if isinstance(self.normal, RigidContact):
            yield (
                "contact",
                f"{self.law.name} takes one contact at a time, a block has four corners; expected "
                "the law of a force, such as 'exact' with a stiffness",
            )
        width, diagonal = self.height + 2.0 * self.size, math.hypot(self.length, self.height)
        if diagonal <= width:
            yield (
                "size",
                f"the block could turn over: its diagonal is {diagonal:g} m, the guide "
                f"{width:g} m wide; expected a guide narrower than the diagonal",
            )
        elif abs(self.angle) >= math.pi / 2:
            found = math.degrees(self.angle)
            yield "angle", f"expected a block less than 90 deg from its guide, found {found:g} deg"
        elif message := self.start_problem(self.deepest, "a corner"):
            yield "offset" if abs(self.offset) > self.size else "angle", message

    @property
    def deepest(self) -> float:
        """Indentation of the deepest corner at the start in metres; negative if none touches."""
        sin, cos = math.sin(self.angle), math.cos(self.angle)
        reach = 0.5 * (self.length * abs(sin) + self.height * cos)
        return abs(self.offset) + reach - 0.5 * self.height - self.size

    @property
    def play(self) -> Play:
        """What is free to move."""
        return Play(self.name, self.slider, self.path)

    def at(self, state: Mapping[str, tuple[float, float]]) -> GuideClearance:
        """The same with another start where a state names it."""
        offset, rate = state.get(self.play.offset, (self.offset, self.rate))
        angle, speed = state.get(self.play.tilt, (self.angle, self.speed))
        return replace(self, offset=offset, rate=rate, angle=angle, speed=speed)

    def references(self) -> References:
        """The slider."""
        return References(bodies=(((*self.path, "slider"), self.slider, ("slider",)),))

    def terms(self) -> tuple[Play | Initial | Contact, ...]:
        """What is free to move and its initial state, and the contacts of four corners."""
        play = self.play
        size, length, height = (
            Parameter((*self.path, key), getattr(self, key)) for key in ("size", "length", "height")
        )
        geometries = [
            CornerAtWall(play, along, across, size, length, height) for along, across in CORNERS
        ]
        return (
            play,
            Initial(play.offset, self.offset, self.rate, self.path),
            Initial(play.tilt, self.angle, self.speed, self.path),
            *(
                Contact(f"{self.name}.corner{place}", own, self.normal, self.rubbing, self.path)
                for place, own in enumerate(geometries, 1)
            ),
        )
