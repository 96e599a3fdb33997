"""How far two bodies are apart where they may touch: functions of the configuration.

A contact is a gap, a law of the force across it, and friction along it. Laws know a gap by its
indentation, by the rates of that and of slip, and by what a force and a friction there act on.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import TYPE_CHECKING

from linkages.components.contributed.contacts import PinInHole
from linkages.kernel.forces.loads import Forces, Torques, Velocities
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.graph.vectors import Vector

if TYPE_CHECKING:
    from linkages.kernel.model import Model

NEAREST = 1e-9
"""Offset over size below which it has no direction."""


class Gap(ABC):
    """A gap.

    Attributes
    ----------
    size
        Length that indentations are compared with (m).
    """

    size: Scalar

    @property
    @abstractmethod
    def indentation(self) -> Scalar:
        """Negative where the gap is open (m)."""

    @property
    @abstractmethod
    def smooth(self) -> Scalar:
        """What the sign of the indentation is seen from (m): it is smooth where that is not."""

    @abstractmethod
    def rate(self, velocities: Velocities) -> Scalar:
        """Rate of the indentation, at velocities that may be partial ones."""

    @abstractmethod
    def pushed(self, accelerations: Velocities) -> Scalar:
        """Second derivative of the indentation."""

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
        """From the pin of the joint to the displaced point."""
        x, y = (self.model.positions.displacements[name] for name in self.geometry.axes)
        return Vector(x, y)

    def offset_rate(self, velocities: Velocities) -> Vector:
        """Its rate, at velocities that may be partial ones."""
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
        """Negative where the gap is open."""
        return self._squares / (self.distance + self.size)

    @property
    def smooth(self) -> Scalar:
        """What the sign of the indentation is seen from (m): it is smooth where that is not."""
        return self._squares * (0.5 / self.size)

    def rate(self, velocities: Velocities) -> Scalar:
        """Rate of the indentation."""
        return self.normal.dot(self.offset_rate(velocities))

    @cached_property
    def _speed(self) -> Scalar:
        return self.rate(self.model.velocities)

    def pushed(self, accelerations: Velocities) -> Scalar:
        """Second derivative of the indentation."""
        pushed = self.normal.dot(self.offset_rate(accelerations))
        along = self.offset_rate(self.model.velocities).square - self._speed * self._speed
        return pushed + along / self.distance

    def slip(self, velocities: Velocities) -> Scalar:
        """Slip of the journal in the bearing."""
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
