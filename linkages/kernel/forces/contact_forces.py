"""Normal force, friction and oil film at one point of contact.

With the offset o of both centres, its rate o′ and the mean ω̄ of both angular speeds, the film is
squeezed with the velocity w = o′ − ω̄ ẑ×o. In the direction n it is h = c − o·n thick. Reynolds'
equation of a bearing that is short beside its diameter, h³/(12 η) ∂²p/∂z² = −w·n, has the pressure
p = (6 η/h³) (L²/4 − z²) w·n. With x and y, what o/c is along w and across it, its integrals over
the half where it is positive, and over the whole circle, are second derivatives of
∫ dψ/(1 − x cos ψ − y sin ψ), which is (π + 2 atan(x/Q))/Q and 2π/Q with Q² = 1 − x² − y² [1]_ [2]_.
Oil is sheared where the film is.

References
----------
.. [1] F. W. Ocvirk, "Short-bearing approximation for full journal bearings", NACA TN 2808, 1952.
.. [2] J. F. Booker, "Dynamically loaded journal bearings: mobility method of solution", J. Basic
   Eng. 87 (1965) 537-546, who looks along w as well.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from functools import cached_property
from typing import TYPE_CHECKING, assert_never

from linkages.components.contributed.functions import Function, Internal, Measured
from linkages.components.contributed.normal_forces import (
    Contact,
    CornerAtWall,
    FollowerOnCam,
    NormalForce,
    OilFilm,
    PinInHole,
    RoundAtWall,
)
from linkages.kernel.forces.bearing_gaps import PinGap, ProfiledGap
from linkages.kernel.forces.gaps import (
    NEAREST,
    CircleGap,
    CornerGap,
    FollowerGap,
    Gap,
    LineGap,
)
from linkages.kernel.forces.generalised_forces import Acting, Forces, Torques, Velocities
from linkages.kernel.inputs import value_of
from linkages.kernel.scalars import Scalar, ScalarGraph, Vector

if TYPE_CHECKING:
    from linkages.kernel.model import Model


def friction_force(
    model: Model, name: str, law: Function, *, normal: Scalar, slip: Scalar, active: Scalar
) -> Scalar:
    """Force of friction along the direction of slip, with modes where its law has corners.

    `law` is the force along the slip over the normal force, as a function of the slip `V`.
    """

    def mode(_: Function, node: Scalar) -> Scalar:
        return model.switches.side(f"{name}: slip", node, active)

    return normal * value_of(law, model.inputs, lambda _: slip, mode)


LEAST = 1e-30
"""Indentation in metres that a smaller one counts as, so that roots and logarithms exist."""


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
                number = [c.name for c in model.mechanism.contacts].index(contact.name)
                worn = geometry.profile
                self.gap = ProfiledGap(model, geometry, number) if worn else PinGap(model, geometry)
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


class ContactNodes(GapNodes):
    """A contact: a normal force, and friction under it."""

    @property
    @abstractmethod
    def pressing(self) -> Scalar:
        """Mode: whether a force presses."""

    @cached_property
    def friction(self) -> Scalar:
        if self.contact.friction is None:
            return self.graph.zero
        slip, law = self.gap.slip(self.model.velocities), self.contact.friction
        return friction_force(
            self.model, self.contact.name, law, normal=self.force, slip=slip, active=self.pressing
        )

    def power(self, velocities: Velocities) -> Scalar:
        result = -(self.force * self.gap.rate(velocities))
        if self.friction is self.graph.zero:
            return result
        return result + self.friction * self.gap.slip(velocities)

    @cached_property
    def friction_loss(self) -> Scalar:
        return -(self.friction * self.gap.slip(self.model.velocities))

    def forces(self) -> Forces:
        return self.gap.forces(self.force, self.friction)

    def torques(self) -> Torques:
        return self.gap.torques(self.force, self.friction)


class PressingNodes(ContactNodes):
    """A contact whose force follows a law of indentation and rate."""

    def __init__(self, model: Model, contact: Contact, law: NormalForce) -> None:
        super().__init__(model, contact)
        self.law = law

    @property
    def touching(self) -> Scalar:
        return self.model.switches.add(self.touch, self.gap.smooth)

    @property
    def pressing(self) -> Scalar:
        """Mode: whether the law presses while they touch; otherwise the contact is slack."""
        law, touching = self.law.pressing, self.touching
        if law is None:
            return touching
        name = f"{self.contact.name}: press"
        return self.model.switches.add(name, self.value(law), active=touching)

    @cached_property
    def pressed(self) -> Scalar:
        """The indentation where they touch, as laws take it."""
        return self.graph.select(
            self.gap.indentation - LEAST, self.gap.indentation, self.graph.lift(LEAST)
        )

    def value(self, law: Function) -> Scalar:
        """What a law gives, such as the force or the energy."""
        return value_of(law, self.model.inputs, self._measured)

    def _measured(self, found: Measured | Internal) -> Scalar:
        if isinstance(found, Internal):
            return self.model.sense(found)
        return getattr(self, ("pressed", "speed", "first_rate")[found.order])

    @property
    def first_rate(self) -> Scalar:
        """Rate of the indentation at the last touch, not below the least one that counts."""
        assert self.law.least_rate is not None
        least = self.model.inputs.parameter(self.law.least_rate)
        kept = self.graph.select(self.speed - least, self.speed, least)
        _ = self.touching
        return self.model.switches.memory(self.touch, kept)

    def _while_touching(self, value: Scalar) -> Scalar:
        return self.graph.select(self.touching, value, self.graph.zero)

    @cached_property
    def force(self) -> Scalar:
        force = self.value(self.law.force)
        return self.graph.select(self.pressing, force, self.graph.zero)

    @property
    def potential(self) -> Scalar:
        """Energy of the elastic part, in slack as well."""
        return self._while_touching(self.value(self.law.energy))

    @cached_property
    def normal_loss(self) -> Scalar:
        elastic = self._while_touching(self.value(self.law.elastic))
        return (self.force - elastic) * self.speed


class FilmNodes(GapNodes):
    """A film that fills the gap, so that journal and bearing never touch."""

    gap: PinGap

    def __init__(self, model: Model, contact: Contact, film: OilFilm) -> None:
        super().__init__(model, contact)
        self.film = film
        self.width = model.inputs.parameter(film.width)
        self.viscosity = model.inputs.parameter(film.viscosity)

    @property
    def touching(self) -> Scalar:
        return -self.graph.one

    def _squeezed(self, velocities: Velocities) -> Vector:
        """The velocity w."""
        own, other = self.gap.turning(velocities)
        return self.gap.offset_rate(velocities) - self.gap.offset.turned * (0.5 * (own + other))

    @cached_property
    def _along(self) -> Vector:
        """Where the centres are, seen from the direction of w, over the size: x and y."""
        size, squeezed = self.gap.size, self._velocity
        least = NEAREST * size  # per second: at rest w has no direction
        square = squeezed.square
        speed = self.graph.sqrt(self.graph.select(square - least * least, square, least * least))
        scale = 1.0 / (size * speed)
        offset = self.gap.offset
        return Vector(offset.dot(squeezed) * scale, offset.dot(squeezed.turned) * scale)

    @cached_property
    def _velocity(self) -> Vector:
        return self._squeezed(self.model.velocities)

    @cached_property
    def _root(self) -> Scalar:
        """Q; not a number where the film has no thickness, so that steps do not go there."""
        size = self.gap.size
        return self.graph.sqrt(1.0 - self.gap.offset.square / (size * size))

    @cached_property
    def _angle(self) -> Scalar:
        """How far the film reaches, as Sommerfeld's angle."""
        if self.film.whole:
            return self.graph.lift(2.0 * math.pi)
        return math.pi + 2.0 * self.graph.apply("atan", self._along.x / self._root)

    @cached_property
    def _acting(self) -> Vector:
        """On the displaced body, through its centre of the gap."""
        size, offset, squeezed, root = self.gap.size, self.gap.offset, self._velocity, self._root
        cube = root * root * root
        across = 3.0 * offset.dot(squeezed) / (size * size * cube * root * root)
        result = (squeezed * (1.0 / cube) + offset * across) * self._angle
        if not self.film.whole:
            x, y = self._along.x, self._along.y
            side = y * (4.0 + 2.0 * x * x / (1.0 - y * y))
            ends = squeezed * (6.0 * x) + squeezed.turned * side
            result = result + ends * (1.0 / (cube * root))
        ratio = self.width / size
        stiffness = self.viscosity * self.gap.radius * ratio * ratio * ratio  # η R L³/c³
        return result * (-0.5 * stiffness)

    @cached_property
    def _shear(self) -> Scalar:
        """Torque over the difference of angular speeds: η R³ L/c times the reach of the film."""
        radius, size = self.gap.radius, self.gap.size
        return self.viscosity * radius * radius * radius * self.width / size * (
            self._angle / self._root
        )  # fmt: skip

    @cached_property
    def force(self) -> Scalar:
        """What the pressure has towards the middle."""
        return -self.gap.normal.dot(self._acting)

    @cached_property
    def friction(self) -> Scalar:
        """What the pressure has along the wall."""
        return self.gap.normal.turned.dot(self._acting)

    @property
    def potential(self) -> Scalar:
        return self.graph.zero

    @cached_property
    def normal_loss(self) -> Scalar:
        """Power lost as oil is squeezed."""
        return -self._acting.dot(self._velocity)

    @cached_property
    def friction_loss(self) -> Scalar:
        """Power lost as oil is sheared."""
        turning = self._sheared(self.model.velocities)
        return self._shear * turning * turning

    def _sheared(self, velocities: Velocities) -> Scalar:
        own, other = self.gap.turning(velocities)
        return own - other

    def power(self, velocities: Velocities) -> Scalar:
        squeezing = self._acting.dot(self._squeezed(velocities))
        return squeezing - self._torque * self._sheared(velocities)

    @cached_property
    def _torque(self) -> Scalar:
        return self._shear * self._sheared(self.model.velocities)

    def forces(self) -> Forces:
        return self.gap.between(self._acting)

    def torques(self) -> Torques:
        """Of shear; that of the pressure about the other centre is shared equally."""
        offset, acting = self.gap.offset, self._acting
        shared = -0.5 * offset.turned.dot(acting)
        body, other = self.gap.geometry.body, self.gap.other
        return [(body, shared - self._torque), (other, shared + self._torque)]
