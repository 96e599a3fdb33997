"""Gaps between bodies that may touch, and forces across them.

Laws know a gap by its indentation, by the rates of that and of slip, and by what a force and a
friction there act on.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, assert_never

from linkages.components.contributed.normal_forces import (
    Contact,
    CornerAtWall,
    FollowerOnCam,
    PinInHole,
    RoundAtWall,
)
from linkages.components.contributed.terms import Body
from linkages.kernel.cams import CamNodes
from linkages.kernel.forces.generalised_forces import Acting, Forces, Torques, Velocities
from linkages.kernel.scalars import Scalar, ScalarGraph, Vector
from linkages.kernel.velocities import Rates

if TYPE_CHECKING:
    from linkages.kernel.model import Model
    from linkages.kernel.velocities import Accelerations

NEAREST = 1e-9
"""Offset over size below which it has no direction."""


class Touchable(ABC):
    """How far two bodies are apart where they may touch."""

    model: Model
    graph: ScalarGraph
    size: Scalar
    """Length that indentations are compared with (m)."""
    near: ClassVar[float] = 1e-7
    """Distance from the wall over size within which what is at rest touches it."""
    kept: ClassVar[float] = near
    """The same of what touches it already."""

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


class RadialGap(Gap):
    """A gap along the line through two points: they touch where these are `reach` apart."""

    reach: Scalar
    """Distance of the two points at which they touch (m)."""

    def signed(self, value: Scalar) -> Scalar:
        """A value of points that move apart, as one that indents."""
        return value

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
        return self.signed(self.offset.square - self.reach * self.reach)

    @cached_property
    def indentation(self) -> Scalar:
        return self._squares / (self.distance + self.reach)

    @property
    def smooth(self) -> Scalar:
        return self._squares * (0.5 / self.reach)

    def rate(self, velocities: Velocities) -> Scalar:
        return self.signed(self.normal.dot(self.offset_rate(velocities)))

    @cached_property
    def _parting(self) -> Scalar:
        return self.normal.dot(self.offset_rate(self.model.velocities))

    def pushed(self, accelerations: Velocities) -> Scalar:
        pushed = self.normal.dot(self.offset_rate(accelerations))
        along = self.offset_rate(self.model.velocities).square - self._parting * self._parting
        return self.signed(pushed + along / self.distance)

    def turned(self, order: int) -> Scalar:
        """Direction of the offset (`order` 0) and its rates; 0 where it has no direction."""
        if order == 0:
            return self.graph.apply("atan2", self.offset.y, self.offset.x)
        across = self.normal.turned * (1.0 / self.distance)
        turning = across.dot(self.offset_rate(self.model.velocities))
        if order == 1:
            return turning
        pushed = across.dot(self.offset_rate(self.model.accelerations))
        return pushed - 2.0 * turning * self._parting / self.distance


class PinGap(RadialGap):
    """A journal in a bearing.

    Both bodies touch at one point C, a radius of the journal away from its centre in the direction
    n_h from the centre of the bearing to that of the journal. Slip is the velocity of the journal's
    body against the bearing's at C, along n_h turned by +90°.
    """

    def __init__(self, model: Model, geometry: PinInHole) -> None:
        self.model, self.graph, self.geometry = model, model.graph, geometry
        self.other = model.mechanism.carrier(geometry.joint)
        self.size = self.reach = model.inputs.parameter(geometry.size)
        self.radius = model.inputs.parameter(geometry.pin_radius)

    @cached_property
    def offset(self) -> Vector:
        x, y = (self.model.positions.displacements[name] for name in self.geometry.axes)
        return Vector(x, y)

    def offset_rate(self, velocities: Velocities) -> Vector:
        x, y = (velocities.moving(name) for name in self.geometry.axes)
        return Vector(x, y)

    def slip(self, velocities: Velocities) -> Scalar:
        body, other = self.turning(velocities)
        pin, hole = (other, body) if self.geometry.hole else (body, other)
        along = self.normal.turned.dot(self.offset_rate(velocities))
        return along + self.radius * pin - (self.radius + self.distance) * hole

    def turning(self, velocities: Velocities) -> tuple[Scalar, Scalar]:
        """Angular speeds of the displaced body and of the other one."""
        other = self.graph.zero if self.other is None else velocities.turning(self.other)
        return velocities.turning(self.geometry.body), other

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


class WallGap(Gap):
    """A round on one body and a wall of another.

    The vector ρ leads from a point of the wall's body to the middle of the round, n is the unit
    vector out of the wall, and u the one along it, with n on its left. They touch at C = −r n from
    the middle of the round. Slip is the velocity of the round's body against the wall's at C,
    along u.
    """

    geometry: RoundAtWall

    def __init__(self, model: Model, geometry: RoundAtWall) -> None:
        self.model, self.graph, self.geometry = model, model.graph, geometry
        self.size = model.inputs.parameter(geometry.size)
        self.radius = model.inputs.parameter(geometry.radius)
        self.wall, self._through = model.mechanism.placed(geometry.wall, geometry.through)
        self.body, self._middle = model.mechanism.placed(geometry.body, geometry.joint)

    @property
    @abstractmethod
    def outwards(self) -> Vector:
        """The direction n."""

    def apart(self, joints: Mapping[str, Vector]) -> Vector:
        """ρ, or its rate, from those of joints."""
        return joints[self._middle] - joints[self._through]

    @cached_property
    def arm(self) -> Vector:
        """ρ."""
        return self.apart(self.model.positions.joints)

    def wall_turning(self, velocities: Velocities) -> Scalar:
        """Angular speed of what has the wall."""
        return self._turning(self.wall, velocities)

    def _turning(self, body: str | None, velocities: Velocities) -> Scalar:
        return self.graph.zero if body is None else velocities.turning(body)

    def slip(self, velocities: Velocities) -> Scalar:
        n, wall = self.outwards, self.wall_turning(velocities)
        rolling = self.radius * (self._turning(self.body, velocities) - wall)
        return rolling + wall * n.dot(self.arm) - n.turned.dot(self.apart(velocities.joints))

    def _acting(self, force: Scalar, friction: Scalar) -> Vector:
        return self.outwards * force - self.outwards.turned * friction

    def forces(self, force: Scalar, friction: Scalar) -> Forces:
        """On the round through its middle, and the opposite at the point of the wall."""
        acting = self._acting(force, friction)
        return [(self.body, self._middle, acting), (self.wall, self._through, -acting)]

    def torques(self, force: Scalar, friction: Scalar) -> Torques:
        """Of both at C, about these points."""
        lever = self.arm - self.outwards * self.radius
        on_wall = -lever.cross(self._acting(force, friction))
        return [(self.body, self.radius * friction), (self.wall, on_wall)]


class LineGap(WallGap):
    """A round and a straight wall: the indentation is r − n·ρ."""

    @cached_property
    def _along(self) -> Vector:
        """The direction u."""
        assert self.geometry.angle is not None
        own = self.model.positions.frames.direction(self.geometry.angle)
        return own if self.wall is None else self.model.positions.unit(self.wall).times(own)

    @property
    def outwards(self) -> Vector:
        return self._along.turned

    @cached_property
    def offset(self) -> Vector:
        """Along the wall, and the room to it."""
        return Vector(self._along.dot(self.arm), -self.indentation)

    def offset_rate(self, velocities: Velocities) -> Vector:
        apart, wall = self.apart(velocities.joints), self.wall_turning(velocities)
        along = self._along.dot(apart) + wall * self.outwards.dot(self.arm)
        return Vector(along, -self.rate(velocities))

    @cached_property
    def indentation(self) -> Scalar:
        return self.radius - self.outwards.dot(self.arm)

    def rate(self, velocities: Velocities) -> Scalar:
        wall = self.wall_turning(velocities)
        return wall * self._along.dot(self.arm) - self.outwards.dot(self.apart(velocities.joints))

    def pushed(self, accelerations: Velocities) -> Scalar:
        wall = self.wall_turning(self.model.velocities)
        slid = 2.0 * self._along.dot(self.apart(self.model.velocities.joints))
        turned = slid + wall * self.outwards.dot(self.arm)
        return self.rate(accelerations) + wall * turned

    def turned(self, order: int) -> Scalar:
        """The direction towards the wall, and its rates."""
        if order == 0:
            return self.graph.apply("atan2", -self.outwards.y, -self.outwards.x)
        return self.wall_turning((self.model.velocities, self.model.accelerations)[order - 1])


class CircleGap(RadialGap, WallGap):
    """A round within or beside a circular wall: ρ is the offset."""

    def __init__(self, model: Model, geometry: RoundAtWall) -> None:
        super().__init__(model, geometry)
        circle = model.inputs.parameter(geometry.circle)
        self.reach = circle - self.radius if geometry.inside else circle + self.radius

    def signed(self, value: Scalar) -> Scalar:
        return value if self.geometry.inside else -value

    @property
    def offset(self) -> Vector:
        return self.arm

    def offset_rate(self, velocities: Velocities) -> Vector:
        return self.apart(velocities.joints)

    @property
    def outwards(self) -> Vector:
        return -self.normal if self.geometry.inside else self.normal


class FollowerGap(Gap):
    """A follower and its cam, as `linkages.kernel.cams` describes them.

    Slip is the velocity of a flat face against the cam, to the right as seen along the guide.
    """

    kept = 1e-4  # a spline has corners in its second derivative: steps err as much as they may
    TOUCHING: ClassVar[float] = 1e-9
    """Room over size at which they touch: a start on the cam has some round-off of rate."""

    def __init__(self, model: Model, geometry: FollowerOnCam) -> None:
        self.model, self.graph, self.geometry = model, model.graph, geometry
        self.size = model.inputs.parameter(geometry.size)
        self._offset = model.inputs.parameter(geometry.offset)
        self.cam = CamNodes(model.positions, geometry.slider, geometry.cam, geometry.lift)

    def _parted(self, velocities: Velocities) -> Vector:
        return self.cam.parted(velocities.apart if isinstance(velocities, Rates) else None)

    @property
    def indentation(self) -> Scalar:
        slid = self.model.positions.displacement(self.geometry.slider)
        return self.cam.lift + self._offset - slid

    @property
    def smooth(self) -> Scalar:
        return self.indentation + self.TOUCHING * self.size

    def rate(self, velocities: Velocities) -> Scalar:
        lifted = self.cam.slope * velocities.turning(self.geometry.cam)
        parted = self.cam.pressing.dot(self._parted(velocities))
        return lifted - velocities.moving(self.geometry.slider) - parted

    def pushed(self, accelerations: Accelerations) -> Scalar:
        turning = self.model.velocities.turning(self.geometry.cam)
        bent = self.model.positions.lift(self.geometry.bends, self.cam.angle)
        lifted = self.cam.slope * accelerations.turning(self.geometry.cam)
        return lifted + bent * (turning * turning) - accelerations.moving(self.geometry.slider)

    def slip(self, velocities: Velocities) -> Scalar:
        """None of what rolls, or where the size of the cam is not known."""
        if not self.cam.profile.flat or self.cam.height is None:
            return self.graph.zero
        turned = self.cam.height * velocities.turning(self.geometry.cam)
        return turned + self.cam.across.dot(self._parted(velocities))

    @property
    def offset(self) -> Vector:
        """The lift, and the room to the cam."""
        return Vector(self.cam.lift, -self.indentation)

    def offset_rate(self, velocities: Velocities) -> Vector:
        lifted = self.cam.slope * velocities.turning(self.geometry.cam)
        return Vector(lifted, -self.rate(velocities))

    def turned(self, order: int) -> Scalar:
        """The direction along the guide towards the cam, and its rates."""
        if order == 0:
            return self.graph.apply("atan2", -self.cam.along.y, -self.cam.along.x)
        return self.graph.zero

    def forces(self, force: Scalar, friction: Scalar) -> Forces:
        """On the follower at its joint, and the opposite at the pivot of the cam."""
        return [*self.cam.forces(force, friction)]

    def torques(self, force: Scalar, friction: Scalar) -> Torques:
        """Of both where they touch, about these points."""
        return [*self.cam.torques(force, friction)]


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
            case RoundAtWall() as geometry:
                straight = geometry.angle is not None
                self.gap = (LineGap if straight else CircleGap)(model, geometry)
            case FollowerOnCam() as geometry:
                self.gap = FollowerGap(model, geometry)
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
