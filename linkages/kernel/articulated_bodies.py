"""Equations of motion of trees of bodies, with as many operations as there are bodies, times some.

The bodies beyond a joint answer to its acceleration a by a force f = Φ a + π, which is symmetric in
all of them: the articulated inertia Φ has three numbers and π two [1]_. A body of the inertia c
about the joint P by which it hangs turns by x'' where τ = c x'' + b·a_P + s is given: eliminating
x'' adds Φ = A − b bᵀ/c to what the body before it carries. That is L D Lᵀ of the matrix J_ij from
the leaves to the ground, of which no entry is formed.

References
----------
.. [1] R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, chapter 7.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from linkages.kernel.forces.generalised_forces import Acting
from linkages.kernel.scalars import Scalar, Vector, section

if TYPE_CHECKING:
    from linkages.kernel.model import Model, MotionField


@dataclass(frozen=True)
class Symmetric:
    """A symmetric 2×2 matrix."""

    xx: Scalar
    xy: Scalar
    yy: Scalar

    def __add__(self, other: Symmetric) -> Symmetric:
        return Symmetric(self.xx + other.xx, self.xy + other.xy, self.yy + other.yy)

    def times(self, vector: Vector) -> Vector:
        """Its product with a vector."""
        x, y = vector.x, vector.y
        return Vector(self.xx * x + self.xy * y, self.xy * x + self.yy * y)

    def without(self, one: Vector, other: Vector) -> Symmetric:
        """The same less the product of two parallel vectors, a bᵀ."""
        xy = self.xy - one.x * other.y
        return Symmetric(self.xx - one.x * other.x, xy, self.yy - one.y * other.y)


@dataclass(frozen=True)
class Member:
    """A body of the tree."""

    name: str
    entry: str  # the point that it hangs from
    arms: dict[str, Vector]  # point that it places → velocity there at unit rate of its coordinate


@dataclass(frozen=True)
class Articulated:
    """What a body with all that hangs from it answers to an acceleration of its entry."""

    inertia: Scalar  # c, about the entry
    bound: Scalar  # what c cannot exceed, to compare it with
    reciprocal: Scalar | None  # 1/c; None for a body that is driven
    answer: Vector  # b/c, of the coupling b of both


class BodyTree:
    """The bodies of a model that hang from the ground and from one another."""

    def __init__(self, model: Model) -> None:
        self._model, self._graph = model, model.graph
        self._free = frozenset(model.topology.free)
        positions = model.positions
        self.members = [
            Member(name, entry, {p: positions.along(name, entry, p).turned for p in labels})
            for block in model.topology.blocks
            for name, entry, labels in block.placements
        ]
        self._zero = Vector(self._graph.zero, self._graph.zero)
        self._ground = frozenset(model.mechanism.anchors)
        self._articulated: dict[str, Articulated] | None = None

    @property
    def articulated(self) -> dict[str, Articulated]:
        """The articulated inertias of all bodies, by name."""
        if self._articulated is None:
            with section("articulated inertias"):
                self._articulated = self._eliminated()
        return self._articulated

    def _eliminated(self) -> dict[str, Articulated]:
        inertia, zero = self._model.inertia, self._graph.zero
        beyond = {joint: Symmetric(m, zero, m) for joint, m in inertia.masses.items()}
        nothing = Symmetric(zero, zero, zero)
        couplings: dict[str, list[tuple[Scalar, Vector, Vector]]] = {}
        arms = {member.name: member.arms for member in self.members}
        for one in inertia.couplings:
            own = arms[one.body]
            ends = own.get(one.first, self._zero), own.get(one.second, self._zero)
            couplings.setdefault(one.body, []).append((one.factor, *ends))
        result: dict[str, Articulated] = {}
        for member in reversed(self.members):
            total, b, c = nothing, self._zero, inertia.moments.get(member.name, zero)
            bound = c
            for point, arm in member.arms.items():
                own_inertia = beyond.get(point, nothing)
                moved = own_inertia.times(arm)
                total, b, c = total + own_inertia, b + moved, c + arm.dot(moved)
                bound = bound + (own_inertia.xx + own_inertia.yy) * arm.square
            for factor, first, second in couplings.get(member.name, ()):
                b = b + (second - first).turned * factor
                c = c - 2.0 * factor * first.cross(second)
            reciprocal, answer = None, self._zero
            if member.name in self._free:
                reciprocal = 1.0 / c
                answer = b * reciprocal
                total = total.without(b, answer)
            result[member.name] = Articulated(c, bound, reciprocal, answer)
            if member.entry not in self._ground:
                beyond[member.entry] = beyond.get(member.entry, nothing) + total
        return result

    def solved(self, right: Sequence[Scalar]) -> list[Scalar]:
        """The solution x of J x = right over the free coordinates."""
        with section("accelerations along the tree of bodies"):
            given = dict(zip(self._model.topology.free, right, strict=True))
            found: dict[str, Scalar] = {}
            carried: dict[str, Vector] = {}
            for member in reversed(self.members):
                own = self.articulated[member.name]
                total, turning = self._zero, self._graph.zero
                for point, arm in member.arms.items():
                    force = carried.get(point, self._zero)
                    total, turning = total + force, turning + arm.dot(force)
                if own.reciprocal is not None:
                    rest = given[member.name] - turning
                    found[member.name] = rest * own.reciprocal
                    total = total + own.answer * rest
                if member.entry not in self._ground:
                    carried[member.entry] = carried.get(member.entry, self._zero) + total
            moved: dict[str, Vector] = {}
            for member in self.members:
                entry = moved.get(member.entry, self._zero)
                rate = self._graph.zero
                if member.name in found:
                    rate = found[member.name] - self.articulated[member.name].answer.dot(entry)
                    found[member.name] = rate
                for point, arm in member.arms.items():
                    moved[point] = entry + arm * rate
            return [found[name] for name in self._model.topology.free]

    def required(
        self, accelerations: MotionField, acting: Iterable[Acting], names: Iterable[str]
    ) -> list[Scalar]:
        """Generalised forces on coordinates that a motion needs beyond gravity and loads."""
        with section("forces along the tree of bodies"):
            at, about = self._model.inertia.forces(accelerations, self._model.gravity)
            for load in acting:
                for _, joint, force in load.forces():
                    at[joint] = at.get(joint, self._zero) - force
                for body, torque in load.torques():
                    if body is not None:
                        about[body] = about.get(body, self._graph.zero) - torque
            for member in reversed(self.members):
                turning = about.get(member.name, self._graph.zero)
                for point, arm in member.arms.items():
                    force = at.get(point, self._zero)
                    turning = turning + arm.dot(force)
                    if member.entry not in self._ground:
                        at[member.entry] = at.get(member.entry, self._zero) + force
                about[member.name] = turning
            return [about[name] for name in names]
