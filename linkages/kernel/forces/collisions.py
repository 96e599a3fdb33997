"""Impacts in which several rigid contacts take part, of which some have friction.

Each contact that is closed or touched obeys Newton's law across the wall, and Coulomb's law along
it for the slip behind the impact [1]_, [2]_: contacts press or part, hold or slip. With Newton's
law energy may grow under friction. Impulses are then between these and those of an impact without
restitution, by which it never grows, such that it does not.

References
----------
.. [1] P. Flores, R. Leine, C. Glocker, Multibody Syst. Dyn. 23 (2010) 165.
.. [2] R. I. Leine, N. van de Wouw, Stability and Convergence of Mechanical Systems with Unilateral
       Constraints, Springer 2008.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from linkages.kernel.graph.scalars import Scalar

if TYPE_CHECKING:
    from linkages.kernel.forces.walls import Walls

FURTHER, EACH = 4, 1
"""How often it is found anew which contacts press and slip, and so much more for each of them."""

SAME = 1e-7
"""Of all impulses: how far they are from those before where it has been found."""


class Collision:
    """Impulses of all contacts in an impact of those that touch.

    Parameters
    ----------
    walls
        All contacts.
    """

    def __init__(self, walls: Walls) -> None:
        self.walls, self.graph, self.contacts = walls, walls.graph, walls.contacts

    @cached_property
    def taking(self) -> list[Scalar]:
        """Not negative for contacts that take part."""
        graph, closed = self.graph, self.walls.closed
        return [
            graph.select(mode, graph.one, contact.met)
            for mode, contact in zip(closed, self.contacts, strict=True)
        ]

    @property
    def impulses(self) -> list[Scalar]:
        """Normal ones of all contacts, then those of friction."""
        plastic, more, part = self._parts
        return [p + part * m for p, m in zip(plastic, more, strict=True)]

    @property
    def restored(self) -> Scalar:
        """The part of the restitution with which energy does not grow, at most 1."""
        return self._parts[2]

    @cached_property
    def _parts(self) -> tuple[list[Scalar], list[Scalar], Scalar]:
        """Impulses without restitution, what it adds, and the part of that which is taken."""
        whole = self._found([contact.shared_fall for contact in self.contacts])
        plastic = self._found([contact.stopping_fall for contact in self.contacts])
        more = [one - other for one, other in zip(whole, plastic, strict=True)]
        product = self.walls.pushed_all(more)
        rates = [-contact.speed for contact in self.contacts]
        rates += [rubbing.slip for rubbing in self.walls.rough.values()]
        behind = [v + u for v, u in zip(rates, self.walls.pushed_all(plastic), strict=True)]
        # ΔT = c + b θ + a θ² from no restitution (θ = 0) to all of it
        a = 0.5 * self._dot(more, product)
        b = self._dot(more, behind)
        c = 0.5 * self._dot(plastic, [u + v for u, v in zip(rates, behind, strict=True)])
        graph, grows = self.graph, a + b + c
        radicand = graph.select(-grows, graph.one, b * b - 4.0 * a * c)
        under = graph.select(-grows, graph.one, b + graph.sqrt(radicand))
        return plastic, more, graph.select(-grows, graph.one, -2.0 * c / under)

    def _dot(self, one: Sequence[Scalar], other: Sequence[Scalar]) -> Scalar:
        return self.graph.total(a * b for a, b in zip(one, other, strict=True))

    def _found(self, falls: Sequence[Scalar]) -> list[Scalar]:
        """Impulses that lower rates of indentations by so much, or more where contacts part.

        Which press and slip is guessed, and guessed again from what impulses that asks for.
        """
        walls, graph = self.walls, self.graph
        right = [*falls, *(-rubbing.slip for rubbing in walls.rough.values())]
        pressing, senses = self.taking, {k: self._sign(r.slip) for k, r in walls.rough.items()}
        stuck = dict.fromkeys(walls.rough, -graph.one)
        before = [graph.zero] * len(right)
        found = walls.pressed(pressing, senses, stuck, right, before)
        for _ in range(FURTHER + EACH * len(self.contacts)):
            before, pressing = found, self._pressing(found, falls)
            senses, stuck = self._slipping(found)
            found = walls.pressed(pressing, senses, stuck, right, before)
        off = graph.total((u - v) * (u - v) for u, v in zip(found, before, strict=True))
        size = graph.total(u * u for u in found)
        # nothing fits: no number, so that the motion ends
        fits = graph.select(SAME * SAME * size - off, graph.one, graph.zero)
        return [value / fits for value in found]

    def _sign(self, value: Scalar) -> Scalar:
        return self.graph.select(value, self.graph.one, -self.graph.one)

    def _pressing(self, impulses: Sequence[Scalar], falls: Sequence[Scalar]) -> list[Scalar]:
        """Not negative where a contact has to press."""
        found = []
        for k, (there, fall) in enumerate(zip(self.taking, falls, strict=True)):
            left = fall - self.walls.pushed(k, impulses)
            needed = impulses[k] * self.walls.mobility(k, k) + left
            found.append(self.graph.select(there, needed, -self.graph.one))
        return found

    def _slipping(self, impulses: Sequence[Scalar]) -> tuple[dict[int, Scalar], dict[int, Scalar]]:
        """Senses of slips behind, and what is not negative where one holds."""
        walls, graph = self.walls, self.graph
        senses, stuck = {}, {}
        for k, rubbing in walls.rough.items():
            place = walls.along(k)
            behind = rubbing.slip + walls.pushed(place, impulses)
            wanted = impulses[place] * rubbing.tangential - behind
            most = rubbing.friction * impulses[k] * rubbing.tangential
            senses[k] = self._sign(-wanted)
            stuck[k] = most - graph.select(wanted, wanted, -wanted)
        return senses, stuck
