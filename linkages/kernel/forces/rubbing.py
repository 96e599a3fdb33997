"""Coulomb friction of a rigid contact, and its impacts while no other one touches.

A normal force λ and friction f along the slip change the rate d' of the indentation and the slip
w by d″ = … − W_nn λ + W_nt f and w' = … − W_nt λ + W_tt f, with the derivatives N and T of
indentation and slip by the free coordinates: W_nn = N J⁻¹ Nᵀ, W_nt = N J⁻¹ Tᵀ, W_tt = T J⁻¹ Tᵀ.
Impulses do the same to rates. In an impact the impulse grows along straight pieces [1]_, [2]_:
friction opposes the slip until that ends; then it holds, or as much of it as there is.

References
----------
.. [1] E. J. Routh, Dynamics of a System of Rigid Bodies, Macmillan 1860.
.. [2] Y. Wang, M. T. Mason, Two-dimensional rigid-body collisions with friction, J. Appl. Mech. 59
       (1992) 635.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.graph.symmetric import solve_symmetric

if TYPE_CHECKING:
    from linkages.components.contributed.terms import Parameter
    from linkages.kernel.forces.gaps import Gap
    from linkages.kernel.forces.impacts import Unilateral


class Rubbing:
    """Friction of a rigid contact, and its impacts while no other one touches.

    Parameters
    ----------
    contact
        Whose friction it is.
    gap
        Along which it slips.
    friction
        Coulomb's coefficient.
    """

    def __init__(self, contact: Unilateral, gap: Gap, friction: Parameter) -> None:
        self.model, self.graph, self.gap = contact.model, contact.graph, gap
        self.contact, self.law, self.path = contact, contact.law, friction.path
        self.friction = self.model.inputs.parameter(friction)

    @cached_property
    def slip(self) -> Scalar:
        """The actual slip."""
        return self.gap.slip(self.model.velocities)

    @cached_property
    def along_slip(self) -> list[Scalar]:
        """T, the derivatives of the slip by the rates of the free coordinates."""
        return [self.gap.slip(partial) for partial in self.model.partials]

    @cached_property
    def moved(self) -> list[Scalar]:
        """J⁻¹Tᵀ."""
        return solve_symmetric(self.model.mass_matrix, self.along_slip)

    @cached_property
    def normal(self) -> Scalar:
        """W_nn."""
        place = self.model.walls.place(self.contact)
        return self.model.walls.mobility(place, place)

    @cached_property
    def mixed(self) -> Scalar:
        """W_nt."""
        across = [self.gap.rate(partial) for partial in self.model.partials]
        return self.graph.total(a * b for a, b in zip(across, self.moved, strict=True))

    @cached_property
    def tangential(self) -> Scalar:
        """W_tt."""
        found = self.graph.total(a * b for a, b in zip(self.along_slip, self.moved, strict=True))
        # concentric, as for W_nn: what touches slips
        return self.graph.select(-found, self.graph.one, found)

    @property
    def jamming(self) -> Scalar:
        """Positive where W_nn < μ |W_nt|: no finite force keeps a sliding contact closed."""
        pushed = self.friction * self.mixed
        return pushed * pushed - self.normal * self.normal

    @cached_property
    def _sense(self) -> Scalar:
        return self.graph.select(self.slip, self.graph.one, -self.graph.one)

    @cached_property
    def _first(self) -> Scalar:
        """By how much impulses lower the rate, over them, while it slips."""
        return self.normal + self.friction * self._sense * self.mixed

    @cached_property
    def _slows(self) -> Scalar:
        """By how much impulses lower the slip, over them; it ends where that is positive."""
        return self._sense * self.mixed + self.friction * self.tangential

    @cached_property
    def _until(self) -> Scalar:
        """The impulse at which slip ends."""
        slows = self.graph.select(-self._slows, self.graph.one, self._slows)
        return self._sense * self.slip / slows

    @cached_property
    def _holds(self) -> Scalar:
        """Impulse along the wall over the normal one behind the end of slip."""
        ratio, most = self.mixed / self.tangential, self.friction
        ratio = self.graph.select(ratio - most, most, ratio)
        return self.graph.select(-most - ratio, -most, ratio)

    @cached_property
    def _second(self) -> Scalar:
        """As `_first`, behind the end of slip."""
        return self.normal - self._holds * self.mixed

    def _by_piece(self, beyond: Scalar, first: Scalar, second: Scalar) -> Scalar:
        """The one that holds while it slips, or behind the end of slip."""
        graph = self.graph
        return graph.select(-self._slows, first, graph.select(-beyond, first, second))

    def impulse(self, fall: Scalar) -> Scalar:
        """Normal impulse that lowers the rate of the indentation by so much."""
        slope = self.graph.select(-self._first, self.graph.one, self._first)
        beyond = fall - self._first * self._until
        return self._by_piece(beyond, fall / slope, self._until + beyond / self._second)

    def along(self, impulse: Scalar) -> Scalar:
        """Impulse of friction along the slip that goes with a normal impulse."""
        slipping, beyond = -self.friction * self._sense, impulse - self._until
        held = slipping * self._until + self._holds * beyond
        return self._by_piece(beyond, slipping * impulse, held)

    def lost(self, impulse: Scalar) -> Scalar:
        """Energy that friction takes along the path of a normal impulse.

        Along each piece that is the impulse of friction against the mean slip.
        """
        sliding = self._by_piece(impulse - self._until, impulse, self._until)
        first, whole = self.along(sliding), self.along(impulse)
        between, behind = (
            self.slip - self.mixed * normal + self.tangential * along
            for normal, along in ((sliding, first), (impulse, whole))
        )
        return -0.5 * (first * (self.slip + between) + (whole - first) * (between + behind))

    def rebound(self, restitution: Scalar, speed: Scalar) -> Scalar:
        """Rate at which it leaves, of an impact at a speed."""
        if self.law.impact == "poisson":
            whole = (1.0 + restitution) * self.impulse(speed)
            beyond = whole - self._until
            later = self._first * self._until + self._second * beyond
            return self._by_piece(beyond, self._first * whole, later) - speed
        wanted = restitution * speed
        beyond = speed + wanted - self._first * self._until
        most = self._most(self._by_piece(beyond, self.graph.zero, self._until), speed)
        return self._by_piece(beyond, wanted, self.graph.select(most - wanted, wanted, most))

    def _most(self, until: Scalar, speed: Scalar) -> Scalar:
        """The fastest rebound behind the end of slip by which energy does not grow.

        Until then so much is lost; later −d' dP − w dF is gained, with both rates linear in P.
        """
        rate = speed - self._first * until
        lost = 0.5 * until * (speed + rate + self.friction * self._sense * self.slip)
        held = self._holds
        bent = self._second - held * (self.mixed - held * self.tangential)
        further = (rate + self.graph.sqrt(rate * rate + 2.0 * bent * lost)) / bent
        return self._second * further - rate
