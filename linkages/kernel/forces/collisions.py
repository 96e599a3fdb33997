"""Several rigid contacts at once: simultaneous impacts, and resting contact under friction.

Each contact that is closed or touched obeys Newton's law across the wall, and Coulomb's law along
it for the slip behind the impact [1]_, [2]_: contacts press or part, hold or slip. With Newton's
law energy may grow under friction. Impulses are then between these and those of an impact without
restitution, by which it never grows, such that it does not.

References
----------
.. [1] P. Flores, R. Leine, C. Glocker, Multibody Syst. Dyn. 23 (2010) 165.
.. [2] R. I. Leine, N. van de Wouw, Stability and Convergence of Mechanical Systems with Unilateral
       Constraints, Springer 2008.

Forces λ of contacts that press keep indentations at zero. One that slips has friction −μ s λ
against the sense s of its slip, one that holds has what keeps the slip at zero. In either case that
is one linear system for all. Corners of one block, or points of one body at one wall, slip alike
where two of them press, so that nothing says which of them holds it: their forces are then between
those of slip in both senses, such that the slip stays zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING

from linkages.components.contributed.normal_forces import (
    WITHOUT_ROOM,
    CornerAtWall,
    RoundAtWall,
)
from linkages.kernel.scalars import Scalar

if TYPE_CHECKING:
    from linkages.kernel.forces.rigid_contacts import RigidContacts

FURTHER, EACH = 4, 1
"""How often it is found anew which contacts press and slip, and so much more for each of them."""

SAME = 1e-7
"""Of all impulses: how far they are from those before where it has been found."""


class Collision:
    """Impulses of all contacts in an impact of those that touch."""

    def __init__(self, walls: RigidContacts) -> None:
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
        result = walls.pressed(pressing, senses, stuck, right, before)
        for _ in range(FURTHER + EACH * len(self.contacts)):
            before, pressing = result, self._pressing(result, falls)
            senses, stuck = self._slipping(result)
            result = walls.pressed(pressing, senses, stuck, right, before)
        off = graph.total((u - v) * (u - v) for u, v in zip(result, before, strict=True))
        size = graph.total(u * u for u in result)
        # nothing fits: no number, so that the motion ends
        fits = graph.select(SAME * SAME * size - off, graph.one, graph.zero)
        return [value / fits for value in result]

    def _sign(self, value: Scalar) -> Scalar:
        return self.graph.select(value, self.graph.one, -self.graph.one)

    def _pressing(self, impulses: Sequence[Scalar], falls: Sequence[Scalar]) -> list[Scalar]:
        """Not negative where a contact has to press."""
        result = []
        for k, (there, fall) in enumerate(zip(self.taking, falls, strict=True)):
            left = fall - self.walls.pushed(k, impulses)
            needed = impulses[k] * self.walls.mobility(k, k) + left
            if isinstance(self.contacts[k].geometry, WITHOUT_ROOM):  # corners share their forces
                needed = needed + self.walls.kept(k)
            result.append(self.graph.select(there, needed, -self.graph.one))
        return result

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


class RestingContacts:
    """Forces of rigid contacts of which some have friction, and the modes of these."""

    def __init__(self, walls: RigidContacts, pressing: Sequence[Scalar]) -> None:
        self.walls, self.graph, self.pressing = walls, walls.graph, list(pressing)
        self.switches, self.contacts = walls.model.switches, walls.contacts
        self._several = len(self.contacts) > 1
        self._blocks = self._corners()
        self._senses = self._pins() | self._guided()

    def _corners(self) -> dict[str, list[int]]:
        """Blocks in guides and bodies at walls, and the places of their corners among contacts."""
        result: dict[str, list[int]] = {}
        for place in self.walls.rough:
            geometry = self.contacts[place].geometry
            if isinstance(geometry, CornerAtWall | RoundAtWall) and geometry.together:
                result.setdefault(geometry.together, []).append(place)
        return result

    def _pins(self) -> dict[int, Scalar]:
        """Modes of slip of all contacts but those of blocks."""
        guided = {corner for corners in self._blocks.values() for corner in corners}
        return {
            place: self.switches.add(
                f"{self.contacts[place].name}: slip",
                rubbing.slip,
                active=self.pressing[place],
                stick=True,
                couples_others=self._several,
            )
            for place, rubbing in self.walls.rough.items()
            if place not in guided
        }

    def _guided(self) -> dict[int, Scalar]:
        """Modes of slip of blocks, for each of their corners."""
        result: dict[int, Scalar] = {}
        one = self.graph.one
        for name, corners in self._blocks.items():
            rests = self._of(corners, [one] * len(corners), -one)
            active = self.switches.add(f"{name}: rest", rests)
            slip = self._of(corners, [self.walls.rough[k].slip for k in corners], one)
            mode = self.switches.add(
                f"{name}: slip", slip, active=active, stick=True, couples_others=True
            )
            result |= dict.fromkeys(corners, mode)
        return result

    def _of(self, places: Sequence[int], values: Sequence[Scalar], otherwise: Scalar) -> Scalar:
        """The value of the first of these contacts that presses."""
        for place, value in reversed(list(zip(places, values, strict=True))):
            otherwise = self.graph.select(self.pressing[place], value, otherwise)
        return otherwise

    @cached_property
    def _endless(self) -> Scalar:
        """1, or 0 where something jams, so that forces are infinite and the motion ends."""
        walls, graph, result = self.walls, self.graph, self.graph.one
        jams: list[tuple[str, Scalar, Scalar | None]] = [
            (self.contacts[k].name, rubbing.jamming, walls.touching[k])
            for k, rubbing in walls.rough.items()
        ]
        for pair in combinations(range(len(self.contacts)), 2):
            if {*pair} & {*walls.rough} and not walls.apart(*pair):
                name = " and ".join(self.contacts[k].name for k in pair)
                jams.append((name, self.minor(*pair), None))
        for name, function, active in jams:
            mode = self.switches.add(f"{name}: jam", function, active=active)
            result = graph.select(mode, graph.zero, result)
        return result

    def minor(self, one: int, other: int) -> Scalar:
        """Positive where two contacts that press and slip jam each other."""
        graph = self.graph
        (a, b), (c, d) = ([self._sliding(row, k) for k in (one, other)] for row in (one, other))
        both = graph.select(self.pressing[other], b * c - a * d, -graph.one)
        return graph.select(self.pressing[one], both, -graph.one)

    def _sliding(self, row: int, column: int) -> Scalar:
        """By how much a force of one contact, with its friction, lowers d″ of another one."""
        result = self.walls.mobility(row, column)
        if (rubbing := self.walls.rough.get(column)) is None:
            return result
        mixed = -self.walls.product(row, self.walls.along(column))
        return result + rubbing.friction * self._senses[column] * mixed

    @cached_property
    def forces(self) -> list[Scalar]:
        """Normal forces of all contacts, then frictions of those that have some."""
        result = [value / self._endless for value in self._shared(list(self._blocks.values()), {})]
        walls, guided = self.walls, {k for corners in self._blocks.values() for k in corners}
        for places in [*self._blocks.values(), *([k] for k in self._senses if k not in guided)]:
            most = self.graph.total(walls.rough[k].friction * result[k] for k in places)
            taken = self.graph.total(result[walls.along(k)] for k in places)
            self.switches.set_sliding_value(self._senses[places[0]], -taken, most)
        return result

    def _shared(self, blocks: list[list[int]], chosen: dict[int, Scalar]) -> list[Scalar]:
        """The same where some blocks slip in given senses."""
        if not blocks:
            return self._solved(chosen)
        graph, (corners, *others) = self.graph, blocks
        up, down = (
            self._shared(others, chosen | dict.fromkeys(corners, sense))
            for sense in (graph.one, -graph.one)
        )
        pulled, pushed = (self._slip_rate(corners, forces) for forces in (up, down))
        mode = self._senses[corners[0]]
        stuck = self.switches.is_sliding(mode)
        share = pushed / graph.select(stuck, pushed - pulled, graph.one)
        return [
            graph.select(stuck, b + share * (a - b), graph.select(mode, a, b))
            for a, b in zip(up, down, strict=True)
        ]

    def _slip_rate(self, corners: Sequence[int], forces: Sequence[Scalar]) -> Scalar:
        """Rate of the slip of a block under forces of all contacts."""
        walls = self.walls
        rates = [walls.slip_rate(k) + walls.pushed(walls.along(k), forces) for k in corners]
        return self._of(corners, rates, self.graph.one)

    def _solved(self, chosen: dict[int, Scalar]) -> list[Scalar]:
        """Forces where blocks slip in given senses, and others slip or hold as modes say."""
        walls, rough = self.walls, self.walls.rough
        stuck = {k: self.switches.is_sliding(m) for k, m in self._senses.items() if k not in chosen}
        senses = {k: chosen.get(k, self._senses[k]) for k in rough}
        right = [contact.needed for contact in self.contacts]
        right += [-walls.slip_rate(k) for k in rough]
        return walls.pressed(self.pressing, senses, stuck, right)

    def needed(self) -> list[Scalar]:
        """Forces of contacts that press, and of others the d″ that these leave."""
        result = []
        for place, (mode, contact) in enumerate(zip(self.pressing, self.contacts, strict=True)):
            left = contact.needed - self.walls.pushed(place, self.forces)
            result.append(self.graph.select(mode, self.forces[place], left))
        return result
