"""Rigid contacts of a mechanism together: what one does depends on which others are closed.

With the derivatives N_i of the indentations by the free coordinates, and their inertia J, forces λ
of closed contacts change second derivatives of indentations by −W λ, and impulses their rates, with
W_ij = N_i J⁻¹ N_jᵀ (Delassus's matrix). Forces press, and bodies part where they would have to
pull, so modes of contacts are the solution of a linear complementarity problem [1]_.

References
----------
.. [1] F. Pfeiffer, C. Glocker, Multibody Dynamics with Unilateral Contacts, Wiley 1996.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING

from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.graph.symmetric import solve_symmetric

if TYPE_CHECKING:
    from linkages.kernel.forces.impacts import Unilateral
    from linkages.kernel.model import Model

DEPENDENT = 1e-10
"""Part of W_ii that is left of a pivot below which closed contacts count as dependent."""


class Walls:
    """All rigid contacts of a model.

    Parameters
    ----------
    model
        Whose contacts they are.
    contacts
        In their order.
    """

    def __init__(self, model: Model, contacts: Sequence[Unilateral]) -> None:
        self.model, self.graph, self.contacts = model, model.graph, list(contacts)

    @cached_property
    def moved(self) -> list[list[Scalar]]:
        """J⁻¹N_iᵀ of all contacts."""
        return [solve_symmetric(self.model.mass_matrix, own) for own in self._along]

    @cached_property
    def _along(self) -> list[list[Scalar]]:
        return [[c.gap.rate(partial) for partial in self.model.partials] for c in self.contacts]

    def mobility(self, one: int, other: int) -> Scalar:
        """W_ij of two contacts."""
        pairs = zip(self._along[one], self.moved[other], strict=True)
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

    @cached_property
    def _closed(self) -> list[Scalar]:
        return [self.model.switches.add(c.touch, c.nearness) for c in self.contacts]

    @cached_property
    def touching(self) -> list[Scalar]:
        """Modes: which contacts are closed."""
        for mode, contact in zip(self._closed, self.contacts, strict=True):
            self.model.switches.jumps(mode, contact.rates_behind)
        return self._closed

    @cached_property
    def pressing(self) -> list[Scalar]:
        """Modes: which closed contacts press."""
        names = [f"{c.name}: press" for c in self.contacts]
        return self.model.switches.together(names, self.touching, self._needed)

    @cached_property
    def forces(self) -> list[Scalar]:
        """Forces of closed contacts that press; 0 of others."""
        if len(self.contacts) == 1 and self.contacts[0].rubbing is not None:
            return [self.rubbed[0]]
        if len(self.contacts) == 1:
            (mode,), graph = self.pressing, self.graph
            return [graph.select(mode, self._needed([mode])[0], graph.zero)]
        return self._solved(self.pressing)

    @cached_property
    def rubbed(self) -> tuple[Scalar, Scalar]:
        """Normal force and friction of the only contact."""
        (contact,), (pressing,), (touching,) = self.contacts, self.pressing, self.touching
        assert contact.rubbing is not None
        return contact.rubbing.forces(contact.needed, touching, pressing)

    def _needed(self, modes: Sequence[Scalar]) -> list[Scalar]:
        """The force that would keep each contact closed, where others press as modes say."""
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

    def impulses(self, contact: Unilateral) -> list[Scalar]:
        """Impulses of all contacts in an impact of one.

        Others that are closed, or touched at the same time, press as well or part; impulses of
        those that are open are 0. Newton's law holds for all that press [1]_.
        """
        own = self.place(contact)
        if contact.rubbing is not None:
            return [contact.rubbing.impulse(contact.fall)]
        if len(self.contacts) == 1:
            return [contact.fall * self.mass(0)]
        others = [k for k in range(len(self.contacts)) if k != own]
        found: list[Scalar] = []
        for pressing in _subsets(others):
            impulses, fits = self._tried(own, pressing)
            chosen = found or impulses
            found = [
                self.graph.select(fits, one, other)
                for one, other in zip(impulses, chosen, strict=True)
            ]
        return found

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
            there = select(self._closed[k], graph.one, contact.together)
            if k in pressing:
                holds = select(there, impulses[k], -graph.one)
            else:
                fall = graph.total(self.mobility(k, j) * p for j, p in solved.items())
                holds = select(there, contact.slowest + fall - contact.fall, graph.one)
            fits = select(holds - fits, fits, holds)
        return impulses, fits


def _subsets(places: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """All of them, the smaller ones first."""
    for count in range(len(places) + 1):
        yield from combinations(places, count)
