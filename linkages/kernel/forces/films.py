"""A film of oil between journal and bearing: the pressure in a short journal bearing.

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
from functools import cached_property
from typing import TYPE_CHECKING

from linkages.components.contributed.contacts import Contact, OilFilm
from linkages.kernel.forces.across import GapNodes
from linkages.kernel.forces.gaps import NEAREST, PinGap
from linkages.kernel.forces.loads import Forces, Torques, Velocities
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.graph.vectors import Vector

if TYPE_CHECKING:
    from linkages.kernel.model import Model


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
        """They do not."""
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
    def _stiff(self) -> Scalar:
        """η R L³/c³."""
        size, width = self.gap.size, self.width
        ratio = width / size
        return self.viscosity * self.gap.radius * ratio * ratio * ratio

    @cached_property
    def _acting(self) -> Vector:
        """On the displaced body, through its centre of the gap."""
        size, offset, squeezed, root = self.gap.size, self.gap.offset, self._velocity, self._root
        cube = root * root * root
        across = 3.0 * offset.dot(squeezed) / (size * size * cube * root * root)
        found = (squeezed * (1.0 / cube) + offset * across) * self._angle
        if not self.film.whole:
            x, y = self._along.x, self._along.y
            side = y * (4.0 + 2.0 * x * x / (1.0 - y * y))
            ends = squeezed * (6.0 * x) + squeezed.turned * side
            found = found + ends * (1.0 / (cube * root))
        return found * (-0.5 * self._stiff)

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
        """A film stores nothing."""
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
        """Power at some velocities: its generalised force if they are partial ones."""
        squeezing = self._acting.dot(self._squeezed(velocities))
        return squeezing - self._torque * self._sheared(velocities)

    @cached_property
    def _torque(self) -> Scalar:
        return self._shear * self._sheared(self.model.velocities)

    def forces(self) -> Forces:
        """On both centres."""
        return self.gap.between(self._acting)

    def torques(self) -> Torques:
        """Of shear; that of the pressure about the other centre is shared equally."""
        offset, acting = self.gap.offset, self._acting
        shared = -0.5 * offset.turned.dot(acting)
        body, other = self.gap.geometry.body, self.gap.other
        return [(body, shared - self._torque), (other, shared + self._torque)]
