"""Rigid contacts of a mechanism together.

With the derivatives N_i of the indentations by the free coordinates, and their inertia J, forces λ
of closed contacts change second derivatives of indentations by −W λ, and impulses their rates, with
W_ij = N_i J⁻¹ N_jᵀ (Delassus's matrix). Forces press, and bodies part where they would have to
pull, so modes of contacts are the solution of a linear complementarity problem [1]_.

References
----------
.. [1] F. Pfeiffer, C. Glocker, Multibody Dynamics with Unilateral Contacts, Wiley 1996.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING

from linkages.components.contributed.normal_forces import CornerAtWall
from linkages.kernel.differentiation import solve_symmetric
from linkages.kernel.forces.collisions import Collision, RestingContacts
from linkages.kernel.scalars import Scalar

if TYPE_CHECKING:
    from linkages.kernel.forces.rigid_impacts import RigidFriction, Unilateral
    from linkages.kernel.model import Model

DEPENDENT = 1e-10
"""Part of W_ii that is left of a pivot below which closed contacts count as dependent."""

PROXIMAL = 1e-7
"""Part of W_ii by which impulses that depend on each other are told apart."""


class RigidContacts:
    """All rigid contacts of a model."""

    def __init__(self, model: Model, contacts: Sequence[Unilateral]) -> None:
        self.model, self.graph, self.contacts = model, model.graph, list(contacts)
        self.rough: dict[int, RigidFriction] = {
            k: c.rubbing for k, c in enumerate(self.contacts) if c.rubbing is not None
        }

    @cached_property
    def moved(self) -> list[list[Scalar]]:
        """J⁻¹N_iᵀ of all contacts."""
        return [self.model.accelerated(own) for own in self._across]

    @cached_property
    def _across(self) -> list[list[Scalar]]:
        return [[c.gap.rate(partial) for partial in self.model.partials] for c in self.contacts]

    def mobility(self, one: int, other: int) -> Scalar:
        """W_ij of two contacts."""
        pairs = zip(self._across[one], self.moved[other], strict=True)
        found = self.graph.total(a * b for a, b in pairs)
        if one != other:
            return found
        # concentric, an offset has no direction: any mass will do where nothing touches
        return self.graph.select(-found, self.graph.one, found)

    def mass(self, place: int) -> Scalar:
        """What resists along the indentation of one contact, 1/W_ii."""
        return 1.0 / self.mobility(place, place)

    def place(self, contact: Unilateral) -> int:
        """Place of a contact among all."""
        return self.contacts.index(contact)

    def along(self, place: int) -> int:
        """Place of the friction of a contact among all forces: normal ones, then frictions."""
        return len(self.contacts) + list(self.rough).index(place)

    def product(self, one: int, other: int) -> Scalar:
        """By how much a force changes what another one acts along: −d', or the slip."""
        count, rough = len(self.contacts), list(self.rough)
        if one < count and other < count:
            return self.mobility(*sorted((one, other)))
        if one < count:
            one, other = other, one
        own = self.rough[rough[one - count]]
        if other < count:
            pairs = zip(self._across[other], own.moved, strict=True)
            return -self.graph.total(a * b for a, b in pairs)
        if one == other:
            return own.tangential
        pairs = zip(self.rough[rough[other - count]].along_slip, own.moved, strict=True)
        return self.graph.total(a * b for a, b in pairs)

    def pushed(self, place: int, forces: Sequence[Scalar]) -> Scalar:
        """By how much forces change −d″, or the rate of a slip; and impulses rates."""
        return self.graph.total(self.product(place, k) * f for k, f in enumerate(forces))

    def pushed_all(self, forces: Sequence[Scalar]) -> list[Scalar]:
        """The same of all."""
        return [self.pushed(place, forces) for place in range(len(forces))]

    def slip_rate(self, place: int) -> Scalar:
        """Rate of a slip as if no rigid contact pressed."""
        model, slip = self.model, self.rough[place].slip
        known = [*model.unheld_accelerations, *([self.graph.zero] * len(model.internal))]
        return model.switches.rates([slip], model.integrated_accelerations(known))[0]

    def pressed(
        self,
        pressing: Sequence[Scalar],
        senses: Mapping[int, Scalar],
        stuck: Mapping[int, Scalar],
        right: Sequence[Scalar],
        before: Sequence[Scalar] | None = None,
    ) -> list[Scalar]:
        """Forces of all contacts, or impulses: normal ones, then frictions.

        Of forces that depend on each other those nearest to `before` are found (proximal point).
        """
        graph, count = self.graph, len(self.contacts)
        size = count + len(self.rough)
        unit = [[graph.one if i == j else graph.zero for j in range(size)] for i in range(size)]
        rows, sides = [], []

        def constraint(place: int) -> tuple[list[Scalar], Scalar]:
            row, side = [self.product(place, j) for j in range(size)], right[place]
            if before is None:
                return row, side
            little = PROXIMAL * row[place]
            row[place] = row[place] + little
            return row, side + little * before[place]

        for k, presses in enumerate(pressing):
            own, side = constraint(k)
            rows.append(self._either(presses, own, unit[k]))
            sides.append(graph.select(presses, side, graph.zero))
        for k, rubbing in self.rough.items():
            place = self.along(k)
            slips = list(unit[place])
            slips[k] = rubbing.friction * senses[k]
            slips = [rubbing.tangential * value for value in slips]
            side = graph.zero
            if k in stuck:
                held, holding = constraint(place)
                slips = self._either(stuck[k], held, slips)
                side = graph.select(stuck[k], holding, side)
            rows.append(self._either(pressing[k], slips, unit[place]))
            sides.append(graph.select(pressing[k], side, graph.zero))
        return graph.solve(rows, sides)

    def _either(self, mode: Scalar, one: list[Scalar], other: list[Scalar]) -> list[Scalar]:
        return [self.graph.select(mode, a, b) for a, b in zip(one, other, strict=True)]

    def apart(self, one: int, other: int) -> bool:
        """Whether two contacts never touch at once: corners on one side of a block."""
        first, second = (self.contacts[k].geometry for k in (one, other))
        if not (isinstance(first, CornerAtWall) and isinstance(second, CornerAtWall)):
            return False
        return first.play == second.play and first.along == second.along

    @cached_property
    def closed(self) -> list[Scalar]:
        """The same before what impacts do is known."""
        add = self.model.switches.add
        return [add(c.touch, c.nearness, falling=c.nearness_kept) for c in self.contacts]

    @cached_property
    def touching(self) -> list[Scalar]:
        """Modes: which contacts are closed."""
        for mode, contact in zip(self.closed, self.contacts, strict=True):
            self.model.switches.jumps(mode, contact.rates_behind)
        return self.closed

    @cached_property
    def pressing(self) -> list[Scalar]:
        """Modes: which closed contacts press."""
        names = [f"{c.name}: press" for c in self.contacts]
        return self.model.switches.add_coupled(
            names, self.touching, self._holding, couples_others=bool(self.rough) and len(names) > 1
        )

    @cached_property
    def _forces(self) -> list[Scalar]:
        """Normal forces of all contacts, then frictions."""
        pressing = self.pressing
        if self.rough:
            return RestingContacts(self, pressing).forces
        if len(self.contacts) == 1:
            (mode,), graph = pressing, self.graph
            return [graph.select(mode, self._needed([mode])[0], graph.zero)]
        return self._solved(pressing)

    def force(self, place: int) -> Scalar:
        """Force of a contact, if it is closed and presses; otherwise 0."""
        return self._forces[place]

    def _holding(self, modes: Sequence[Scalar]) -> list[Scalar]:
        """What is positive where a contact has a force: it presses, or adhesion holds it."""
        needed = self._needed(modes)
        if not self.rough:
            return [n + c.adhesion for n, c in zip(needed, self.contacts, strict=True)]
        result = []
        for place, (own, contact) in enumerate(zip(needed, self.contacts, strict=True)):
            held = self.graph.select(modes[place], self.graph.one, self.mobility(place, place))
            zero = contact.adhesion is self.graph.zero
            result.append(own if zero else own + contact.adhesion * held)
        return result

    def _needed(self, modes: Sequence[Scalar]) -> list[Scalar]:
        """What is positive where a contact has to press, where others do as modes say."""
        if self.rough:
            return RestingContacts(self, modes).needed()
        if len(self.contacts) == 1:
            (contact,) = self.contacts
            return [self.mass(0) * contact.needed]
        return [
            self._solved([*modes[:own], self.touching[own], *modes[own + 1 :]])[own]
            for own in range(len(modes))
        ]

    def _solved(self, modes: Sequence[Scalar]) -> list[Scalar]:
        """Forces that keep those contacts closed whose mode is positive; 0 of others."""
        zero, select = self.graph.zero, self.graph.select
        matrix = [
            [select(modes[i], select(modes[j], self.mobility(i, j), zero), zero) for j in range(i)]
            + [self.mobility(i, i)]
            for i in range(len(modes))
        ]
        right = [select(m, c.needed, zero) for m, c in zip(modes, self.contacts, strict=True)]
        return solve_symmetric(matrix, right, self._reciprocal(range(len(modes))))

    def _reciprocal(self, places: Sequence[int]) -> Callable[[int, Scalar], Scalar]:
        """Of pivots of W for some contacts: of those that depend on each other the first carry."""
        zero, select = self.graph.zero, self.graph.select

        def found(row: int, pivot: Scalar) -> Scalar:
            own = self.mobility(places[row], places[row])
            enough = pivot - DEPENDENT * own
            return select(enough, 1.0 / select(enough, pivot, own), zero)

        return found

    @cached_property
    def _collision(self) -> Collision:
        return Collision(self)

    def impulses(self, contact: Unilateral) -> list[Scalar]:
        """Impulses of all contacts in an impact of one: normal ones, then those of friction.

        Others that are closed, or touched at the same time, press as well or part. Newton's law
        holds for all that press [1]_.
        """
        own, zero = self.place(contact), self.graph.zero
        if not self.rough:
            return self._smooth(own)
        alone = [zero] * (len(self.contacts) + len(self.rough))
        if (rubbing := contact.rubbing) is None:
            alone[own] = contact.fall * self.mass(own)
        else:
            alone[own] = rubbing.impulse(contact.fall)
            alone[self.along(own)] = rubbing.along(alone[own])
        if contact.law.impact == "moreau":
            return self._collision.impulses
        for there in self._partners(contact):
            alone = self._either(there, self._collision.impulses, alone)
        return alone

    def restored(self, contact: Unilateral) -> Scalar:
        """The part of its restitution that an impact of one contact has, lest energy grow."""
        if not self.rough:
            return self.graph.one
        if contact.law.impact == "moreau":
            return self._collision.restored
        found = self.graph.one
        for there in self._partners(contact):
            found = self._either(there, [self._collision.restored], [found])[0]
        return found

    def _partners(self, contact: Unilateral) -> list[Scalar]:
        """Not negative for others that take part in an impact of one contact."""
        own, count = self.place(contact), len(self.contacts)
        others = [k for k in range(count) if k != own and not self.apart(own, k)]
        return [self._collision.taking[k] for k in others]

    def rubbed(self, contact: Unilateral) -> list[Scalar]:
        """Energy that each friction takes in an impact, which contacts share in proportion."""
        impulses, found = self.impulses(contact), []
        for k, rubbing in self.rough.items():
            place = self.along(k)
            lost = -(impulses[place] * (rubbing.slip + 0.5 * self.pushed(place, impulses)))
            if rubbing is contact.rubbing and contact.law.impact != "moreau":
                path = rubbing.lost(impulses[k])
                for there in self._partners(contact):
                    path = self.graph.select(there, lost, path)
                lost = path
            found.append(lost)
        return found

    def _smooth(self, own: int) -> list[Scalar]:
        """The same without friction."""
        contact = self.contacts[own]
        if len(self.contacts) == 1:
            return [contact.fall * self.mass(0)]
        others = [k for k in range(len(self.contacts)) if k != own]
        found: list[Scalar] = []
        for pressing in (own for n in range(len(others) + 1) for own in combinations(others, n)):
            impulses, fits = self._tried(own, pressing)
            chosen = found or impulses
            found = self._either(fits, impulses, chosen)
        return found

    def kept(self, place: int) -> Scalar:
        """Rate at which the impact of another contact may part a closed one that stays closed.

        Otherwise impacts of two contacts at which a body comes to rest would part them in turn.
        """
        least = self.contacts[place].least_rate
        return self.graph.select(self.closed[place], least, self.graph.zero)

    def _tried(self, own: int, pressing: tuple[int, ...]) -> tuple[list[Scalar], Scalar]:
        """Impulses where these others press, and a number that is not negative if they can."""
        graph, select = self.graph, self.graph.select
        taking = (own, *pressing)
        falls = [self.contacts[k].fall for k in taking]
        rows = [[self.mobility(i, j) for j in taking[: n + 1]] for n, i in enumerate(taking)]
        reciprocal = self._reciprocal(taking)
        solved = dict(zip(taking, solve_symmetric(rows, falls, reciprocal), strict=True))
        impulses = [solved.get(k, graph.zero) for k in range(len(self.contacts))]
        fits = graph.one
        for k, contact in enumerate(self.contacts):
            if k == own:
                continue
            there = select(self.closed[k], graph.one, contact.together)
            if k in pressing:
                holds = select(there, impulses[k] + self.kept(k) * self.mass(k), -graph.one)
            else:
                fall = graph.total(self.mobility(k, j) * p for j, p in solved.items())
                holds = select(there, contact.slowest + fall - contact.fall, graph.one)
            fits = select(holds - fits, fits, holds)
        return impulses, fits
