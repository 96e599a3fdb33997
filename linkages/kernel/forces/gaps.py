"""Gaps between bodies that may touch, and forces across them.

Laws know a gap by its indentation, by the rates of that and of slip, and by what a force and a
friction there act on.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import TYPE_CHECKING, assert_never

from linkages.components.contributed.normal_forces import Contact, CornerAtWall, PinInHole
from linkages.components.contributed.terms import Body
from linkages.kernel.forces.generalised_forces import Acting, Forces, Torques, Velocities
from linkages.kernel.scalars import Scalar, ScalarGraph, Vector

if TYPE_CHECKING:
    from linkages.kernel.model import Model
    from linkages.kernel.velocities import Accelerations

NEAREST = 1e-9
"""Offset over size below which it has no direction."""


class Touchable(ABC):
    """How far two bodies are apart where they may touch."""

    size: Scalar
    """Length that indentations are compared with (m)."""

    @property
    @abstractmethod
    def indentation(self) -> Scalar:
        """Negative where the gap is open (m)."""

    @property
    def smooth(self) -> Scalar:
        """What the sign of the indentation is seen from (m): it is smooth where that is not."""
        return self.indentation

    @abstractmethod
    def rate(self, velocities: Velocities) -> Scalar:
        """Rate of the indentation, at velocities that may be partial ones."""

    @abstractmethod
    def pushed(self, accelerations: Accelerations) -> Scalar:
        """Second derivative of the indentation."""


class Gap(Touchable):
    """A gap along which both bodies may slip."""

    @abstractmethod
    def slip(self, velocities: Velocities) -> Scalar:
        """Velocity along the wall, at velocities that may be partial ones."""

    @property
    @abstractmethod
    def offset(self) -> Vector:
        """From where what touches would be without play to where it is."""

    @abstractmethod
    def offset_rate(self, velocities: Velocities) -> Vector:
        """Its rate, at velocities that may be partial ones."""

    @abstractmethod
    def turned(self, order: int) -> Scalar:
        """The angle of the play (`order` 0), and its rates."""

    @abstractmethod
    def forces(self, force: Scalar, friction: Scalar) -> Forces:
        """A normal force and friction along the slip as forces on both bodies."""

    @abstractmethod
    def torques(self, force: Scalar, friction: Scalar) -> Torques:
        """Their torques about the points at which `forces` act."""


class PinGap(Gap):
    """A journal in a bearing.

    Both bodies touch at one point C, a radius of the journal away from its centre in the direction
    n_h from the centre of the bearing to that of the journal. Slip is the velocity of the journal's
    body against the bearing's at C, along n_h turned by +90°.
    """

    def __init__(self, model: Model, geometry: PinInHole) -> None:
        self.model, self.graph, self.geometry = model, model.graph, geometry
        self.other = model.mechanism.carrier(geometry.joint)
        self.size = model.inputs.parameter(geometry.size)
        self.radius = model.inputs.parameter(geometry.pin_radius)

    @cached_property
    def offset(self) -> Vector:
        x, y = (self.model.positions.displacements[name] for name in self.geometry.axes)
        return Vector(x, y)

    def offset_rate(self, velocities: Velocities) -> Vector:
        x, y = (velocities.moving(name) for name in self.geometry.axes)
        return Vector(x, y)

    @cached_property
    def distance(self) -> Scalar:
        """Length of the offset; some small number where that has no direction."""
        least = self.size * NEAREST
        square = self.offset.square
        return self.graph.sqrt(self.graph.select(square - least * least, square, least * least))

    @cached_property
    def normal(self) -> Vector:
        """Direction of the offset; shorter than 1 where that has none."""
        return self.offset * (1.0 / self.distance)

    @cached_property
    def _squares(self) -> Scalar:
        """Difference of squares, which keeps the digits of a difference of lengths."""
        return self.offset.square - self.size * self.size

    @cached_property
    def indentation(self) -> Scalar:
        return self._squares / (self.distance + self.size)

    @property
    def smooth(self) -> Scalar:
        return self._squares * (0.5 / self.size)

    def rate(self, velocities: Velocities) -> Scalar:
        return self.normal.dot(self.offset_rate(velocities))

    @cached_property
    def _speed(self) -> Scalar:
        return self.rate(self.model.velocities)

    def pushed(self, accelerations: Velocities) -> Scalar:
        pushed = self.normal.dot(self.offset_rate(accelerations))
        along = self.offset_rate(self.model.velocities).square - self._speed * self._speed
        return pushed + along / self.distance

    def slip(self, velocities: Velocities) -> Scalar:
        body, other = self.turning(velocities)
        pin, hole = (other, body) if self.geometry.hole else (body, other)
        along = self.normal.turned.dot(self.offset_rate(velocities))
        return along + self.radius * pin - (self.radius + self.distance) * hole

    def turning(self, velocities: Velocities) -> tuple[Scalar, Scalar]:
        """Angular speeds of the displaced body and of the other one."""
        other = self.graph.zero if self.other is None else velocities.turning(self.other)
        return velocities.turning(self.geometry.body), other

    def turned(self, order: int) -> Scalar:
        """Direction of the offset (`order` 0) and its rates; 0 where it has no direction."""
        if order == 0:
            return self.graph.apply("atan2", self.offset.y, self.offset.x)
        across = self.normal.turned * (1.0 / self.distance)
        turning = across.dot(self.offset_rate(self.model.velocities))
        if order == 1:
            return turning
        pushed = across.dot(self.offset_rate(self.model.accelerations))
        return pushed - 2.0 * turning * self._speed / self.distance

    def forces(self, force: Scalar, friction: Scalar) -> Forces:
        """On the displaced body through its offset, and the opposite at the joint."""
        return self.between(self.normal.turned * friction - self.normal * force)

    def between(self, acting: Vector) -> Forces:
        """A force on the displaced body through its offset, and the opposite at the joint."""
        geometry = self.geometry
        return [
            (geometry.axes[1], geometry.displaced, acting),
            (self.other, geometry.joint, -acting),
        ]

    def torques(self, force: Scalar, friction: Scalar) -> Torques:  # noqa: ARG002
        """Of the friction at C, about the centres of journal and bearing."""
        on_pin = self.radius * friction
        on_hole = -(self.radius + self.distance) * friction
        bodies = (self.other, self.geometry.body)
        pin, hole = bodies if self.geometry.hole else bodies[::-1]
        return [(pin, on_pin), (hole, on_hole)]


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
        play = self.geometry.play
        turned = self._arm.turned * velocities.moving(play.tilt)
        return Vector(turned.x, turned.y + velocities.moving(play.offset))

    @property
    def indentation(self) -> Scalar:
        return self.side * self.offset.y - self.size

    def rate(self, velocities: Velocities) -> Scalar:
        return self.side * self.offset_rate(velocities).y

    def pushed(self, accelerations: Velocities) -> Scalar:
        turning = self.model.velocities.moving(self.geometry.play.tilt)
        return self.rate(accelerations) - self.side * (self._arm.y * (turning * turning))

    def slip(self, velocities: Velocities) -> Scalar:
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
        result: Torques = [(self._block.name, self._arm.cross(own))]
        if bearing is None:
            return result
        positions = self.model.positions
        unit = positions.unit(self.geometry.play.slider)
        middle = positions.joints[next(iter(self._block.points))] - positions.joints[point]
        corner = middle + unit.times(self._arm)
        return [*result, (bearing, -corner.cross(unit.times(own)))]


class GapNodes(Acting):
    """A gap, the forces across it, and what they store and dissipate."""

    model: Model
    graph: ScalarGraph
    contact: Contact
    gap: Gap

    def __init__(self, model: Model, contact: Contact) -> None:
        self.model, self.graph, self.contact = model, model.graph, contact
        match contact.geometry:
            case PinInHole() as geometry:
                self.gap = PinGap(model, geometry)
            case CornerAtWall() as geometry:
                self.gap = CornerGap(model, geometry)
            case _ as geometry:
                assert_never(geometry)

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
        return -(self.normal_loss + self.friction_loss)
