"""Corners of a block between the walls of its guide."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

from linkages.components.contributed.contacts import CornerAtWall
from linkages.components.contributed.terms import Body
from linkages.kernel.forces.gaps import Gap
from linkages.kernel.forces.loads import Forces, Torques, Velocities
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.graph.vectors import Vector

if TYPE_CHECKING:
    from linkages.kernel.model import Model


class CornerGap(Gap):
    """A corner of a block and a wall of its guide.

    All vectors count along the guide and across it. The middle of the block is e across the guide,
    the block is turned by φ in it, and the corner is at r from its middle. With σ = ±1 for the
    upper and the lower wall the indentation is σ(e + r_y) − height/2 − size. Slip is the velocity
    of the corner along the guide.
    """

    def __init__(self, model: Model, geometry: CornerAtWall) -> None:
        self.model, self.graph, self.geometry = model, model.graph, geometry
        self.size = model.inputs.parameter(geometry.size)
        self.side = float(geometry.across)
        half = model.inputs.parameter(geometry.length) * (0.5 * geometry.along)
        self._half_height = model.inputs.parameter(geometry.height) * 0.5
        self._corner = Vector(half, self._half_height * self.side)

    @cached_property
    def _turn(self) -> Vector:
        """Cosine and sine of φ."""
        angle = self.model.positions.angle(self.geometry.play.tilt)
        return Vector(self.graph.cos(angle), self.graph.sin(angle))

    @cached_property
    def _arm(self) -> Vector:
        """From the middle of the block to the corner, r."""
        return self._turn.times(self._corner)

    @cached_property
    def offset(self) -> Vector:
        """From where the corner of a block without play would be to where it is."""
        turn = self._turn
        # cos φ − 1 without loss of digits
        turned = Vector(-(turn.y * turn.y) / (turn.x + 1.0), turn.y).times(self._corner)
        across = self.model.positions.displacement(self.geometry.play.offset)
        return Vector(turned.x, turned.y + across)

    def offset_rate(self, velocities: Velocities) -> Vector:
        """Its rate, at velocities that may be partial ones."""
        play = self.geometry.play
        turned = self._arm.turned * velocities.moving(play.tilt)
        return Vector(turned.x, turned.y + velocities.moving(play.offset))

    @property
    def indentation(self) -> Scalar:
        """Negative where the gap is open."""
        return self.side * self.offset.y - self.size

    @property
    def smooth(self) -> Scalar:
        """The indentation itself."""
        return self.indentation

    def rate(self, velocities: Velocities) -> Scalar:
        """Rate of the indentation."""
        return self.side * self.offset_rate(velocities).y

    def pushed(self, accelerations: Velocities) -> Scalar:
        """Second derivative of the indentation."""
        turning = self.model.velocities.moving(self.geometry.play.tilt)
        return self.rate(accelerations) - self.side * (self._arm.y * (turning * turning))

    def slip(self, velocities: Velocities) -> Scalar:
        """Velocity of the corner along the wall."""
        slider = velocities.moving(self.geometry.play.slider)
        return slider + self.offset_rate(velocities).x

    def turned(self, order: int) -> Scalar:
        """The angle of the block in its guide, and its rates."""
        tilt = self.geometry.play.tilt
        if order == 0:
            return self.model.positions.angle(tilt)
        return (self.model.velocities, self.model.accelerations)[order - 1].moving(tilt)

    @cached_property
    def _bearing(self) -> tuple[str | None, str]:
        """What the walls belong to (None: the ground), and the point of it where forces act."""
        mechanism, joint = self.model.mechanism, next(iter(self._block.points))
        guide = mechanism.bodies[self.geometry.play.slider].guide
        assert guide is not None
        if guide.body is None:
            return None, joint
        return guide.body, next(iter(mechanism.bodies[guide.body].points))

    @property
    def _block(self) -> Body:
        return self.model.mechanism.bodies[self.geometry.play.block]

    def _acting(self, force: Scalar, friction: Scalar) -> Vector:
        """The force on the block."""
        return Vector(friction, force * -self.side)

    def forces(self, force: Scalar, friction: Scalar) -> Forces:
        """On the block at its middle, and the opposite on what has the walls."""
        unit = self.model.positions.unit(self.geometry.play.slider)
        acting = unit.times(self._acting(force, friction))
        bearing, point = self._bearing
        block = self._block
        return [(block.name, next(iter(block.points)), acting), (bearing, point, -acting)]

    def torques(self, force: Scalar, friction: Scalar) -> Torques:
        """Of both at the corner, about these points."""
        own = self._acting(force, friction)
        bearing, point = self._bearing
        found: Torques = [(self._block.name, self._arm.cross(own))]
        if bearing is None:
            return found
        positions = self.model.positions
        unit = positions.unit(self.geometry.play.slider)
        middle = positions.joints[next(iter(self._block.points))] - positions.joints[point]
        corner = middle + unit.times(self._arm)
        return [*found, (bearing, -corner.cross(unit.times(own)))]
