"""Friction that follows joint reactions.

A friction is w·P with the size P of a reaction, and reactions are linear in accelerations and
forces: P_k = |F_k + Σ_j A_kj w_j P_j|, with what F_k would be without these frictions. Where the
sum of all |w_j A_kj|² is below one, the right side brings any two sets of P closer together, so
there is one solution (Banach); one friction alone has it in a closed form. Where the sum is one or
more there may be none or two, as of wedges that lock themselves and in Painlevé's paradox, and P is
no number (B. Brogliato, Nonsmooth Mechanics, 3rd ed., Springer 2016, chapter 5).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from linkages.components.contributed.functions import PRESSED, constant
from linkages.components.contributed.load_measures import Bearing
from linkages.components.contributed.state_laws import exchanged
from linkages.kernel.scalars import Level, Scalar, Vector, section
from linkages.kernel.velocities import Accelerations, Rates

if TYPE_CHECKING:
    from linkages.kernel.forces.generalised_forces import LoadNodes
    from linkages.kernel.model import Model

STEPS = 6
"""Of Newton's iteration, from the solutions without coupling: errors are squared in each."""

Parts = list[Scalar]
"""Components of a reaction: x and y at a joint, one across an axis."""


@dataclass(frozen=True)
class _Friction:
    """What a unit of the force of a friction does to accelerations, and the force per reaction."""

    nodes: LoadNodes
    weight: Scalar
    effects: list[Scalar]
    moved: Rates


class ReactionFrictions:
    """The frictions of a model that follow reactions.

    `accelerated`: whether they change the accelerations; not where these are given as they are.
    """

    def __init__(
        self, model: Model, loads: Sequence[LoadNodes], *, accelerated: bool = True
    ) -> None:
        self._model, self._graph, self._accelerated = model, model.graph, accelerated
        self._frictions = [self._friction(nodes) for nodes in loads]
        bearings = (nodes.load.bearing for nodes in loads)
        self._virtual = {b: self._apart(b) for b in dict.fromkeys(bearings) if b is not None}
        self._places = {bearing: place for place, bearing in enumerate(self._virtual)}

    def _friction(self, nodes: LoadNodes) -> _Friction:
        model, one = self._model, constant(1.0)
        law = exchanged(nodes.load.force, lambda leaf: one if leaf == PRESSED else leaf)
        effects: list[Scalar] = [model.graph.zero] * len(model.partials)
        if self._accelerated:
            effects = model.accelerated([nodes.rate(p) for p in model.partials])
        known = dict(zip(model.topology.free, effects, strict=True))
        moved = Rates(model.positions, known, f"f{nodes.index}")
        return _Friction(nodes, nodes.value(law), effects, moved)

    def _apart(self, bearing: Bearing) -> list[Rates]:
        """Motions in which a body moves away from a point, all coordinates at rest."""
        positions, graph = self._model.positions, self._graph
        body = self._model.mechanism.bodies[bearing.body]
        axes = [Vector(graph.one, graph.zero), Vector(graph.zero, graph.one)]
        if not body.rotates and bearing.point == body.axis:
            axes = [positions.unit(body.name).turned]
        label = f"r{positions.body_numbers[body.name]}_"

        def way(place: int, axis: Vector) -> Rates:
            apart = (bearing.body, bearing.point, axis)
            return self._model.unactuated(
                lambda known: Rates(positions, known, f"{label}{place}", apart=apart)
            )

        return [way(place, axis) for place, axis in enumerate(axes)]

    @section("reactions that press frictions")
    def solved(self, free: list[Scalar]) -> tuple[list[Scalar], dict[int, Scalar]]:
        """Accelerations with the frictions, and the size of the reaction of each by its index."""
        changed = list(free)
        sizes = self._pressed(self._model.moving_with(free))
        result: dict[int, Scalar] = {}
        for one in self._frictions:
            size = result[one.nodes.index] = sizes[self._place(one)]
            for place, effect in enumerate(one.effects):
                changed[place] = changed[place] + effect * (one.weight * size)
        return changed, result

    def forces(self, accelerations: Accelerations) -> dict[LoadNodes, Scalar]:
        """The force of each friction along its measure, at given accelerations."""
        sizes = self._pressed(accelerations)
        return {one.nodes: one.weight * sizes[self._place(one)] for one in self._frictions}

    def _pressed(self, accelerations: Accelerations) -> list[Scalar]:
        """Sizes of all reactions, from accelerations without these frictions."""
        model, ways = self._model, self._virtual.values()
        given = [
            [model.required_of(accelerations, way, model.unpressed) for way in own] for own in ways
        ]
        return self._sizes(given, [self._felt(own) for own in ways])

    def _place(self, friction: _Friction) -> int:
        bearing = friction.nodes.load.bearing
        assert bearing is not None
        return self._places[bearing]

    def _felt(self, ways: Sequence[Rates]) -> list[Parts]:
        """What the frictions under each reaction add to one of them, per newton of the former."""
        result = [[self._graph.zero for _ in ways] for _ in self._places]
        for friction in self._frictions:
            parts = result[self._place(friction)]
            for axis, way in enumerate(ways):
                parts[axis] = parts[axis] + friction.weight * self._grown(way, friction)
        return result

    def _grown(self, way: Rates, friction: _Friction) -> Scalar:
        """What a unit of the force of a friction adds to a reaction."""
        assert way.apart is not None
        inertia, moved = self._model.inertia, friction.moved
        force = inertia.product(moved, way) + inertia.apart(moved, *way.apart)
        return force - friction.nodes.rate(way)

    def _sizes(self, given: list[Parts], felt: list[list[Parts]]) -> list[Scalar]:
        graph = self._graph
        root = graph.sqrt(1.0 - graph.total(_dot(a, a) for row in felt for a in row))
        room = root * root  # no number where the frictions may lock
        sides = self._sides(given)
        if len(given) == 1:
            sizes = [self._alone(given[0], felt[0][0], room, sides[0])]
        else:
            own = [1.0 - _dot(row[k], row[k]) for k, row in enumerate(felt)]
            sizes = [self._alone(f, felt[k][k], own[k], sides[k]) for k, f in enumerate(given)]
            for _ in range(STEPS):
                sizes = self._newton(given, felt, sizes, sides)
        self._watch(given, felt, sizes, sides)
        return [size * (room / room) for size in sizes]

    def _sides(self, given: list[Parts]) -> list[Scalar | None]:
        """For a reaction across an axis its sign: a mode whose function `_watch` adds."""
        switches, count = self._model.switches, 0
        result: list[Scalar | None] = []
        for parts in given:
            if len(parts) > 1 or not self._accelerated:
                result.append(None)
            elif parts[0].level <= Level.PARAMETERS:
                result.append(self._graph.select(parts[0], self._graph.one, -self._graph.one))
            else:
                result.append(switches.next_mode(count))
                count += 1
        return result

    def _watch(
        self,
        given: list[Parts],
        felt: list[list[Parts]],
        sizes: list[Scalar],
        sides: list[Scalar | None],
    ) -> None:
        for k, (bearing, side) in enumerate(zip(self._places, sides, strict=True)):
            if side is not None and given[k][0].level > Level.PARAMETERS:
                (force,) = self._reaction(given[k], felt[k], sizes)
                added = self._model.switches.add(f"{bearing.body}: side of its guide", force)
                assert added is side

    def _alone(self, given: Parts, felt: Parts, room: Scalar, side: Scalar | None) -> Scalar:
        """The positive root of P² = |F + A P|²."""
        if side is not None:
            return given[0] / (side - felt[0])
        along = _dot(given, felt)
        return (along + self._graph.sqrt(along * along + room * _dot(given, given))) / room

    def _reaction(self, given: Parts, felt: list[Parts], sizes: list[Scalar]) -> Parts:
        total, pairs = self._graph.total, list(zip(felt, sizes, strict=True))
        return [
            part + total(parts[axis] * size for parts, size in pairs)
            for axis, part in enumerate(given)
        ]

    def _newton(
        self,
        given: list[Parts],
        felt: list[list[Parts]],
        sizes: list[Scalar],
        sides: list[Scalar | None],
    ) -> list[Scalar]:
        """One step towards P_k = |F_k + Σ_j A_kj P_j|."""
        matrix, right = [], []
        for k, side in enumerate(sides):
            reaction = self._reaction(given[k], felt[k], sizes)
            size = (
                self._graph.sqrt(_dot(reaction, reaction)) if side is None else reaction[0] * side
            )
            unit = [part / size for part in reaction] if side is None else [side]
            slopes = [_dot(unit, parts) for parts in felt[k]]
            matrix.append([(1.0 if j == k else 0.0) - slope for j, slope in enumerate(slopes)])
            right.append(size - sizes[k])
        steps = self._graph.solve(matrix, right)
        return [size + step for size, step in zip(sizes, steps, strict=True)]


def _dot(a: Parts, b: Parts) -> Scalar:
    first, *others = [x * y for x, y in zip(a, b, strict=True)]
    return sum(others, first)
