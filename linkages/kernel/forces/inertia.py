"""Inertia of a mechanism: masses at joints, moments of inertia of bodies.

A rigid body whose centre of mass lies at P + (λ + iμ)(Q − P), in complex notation and with two of
its points P and Q at distance L, moves exactly like a mass m(1 − λ) at P, a mass mλ at Q and the
moment of inertia J − mL²(λ − λ² − μ²), plus, if μ ≠ 0, a coupling −mμ (v_P × v_Q) in the energy.
Masses of all bodies at a joint add up, and the sums depend on parameters alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from linkages.components.contributed.terms import Body
from linkages.kernel.positions import Positions
from linkages.kernel.scalars import Scalar, Vector, section


class MotionField(Protocol):
    """Velocities or accelerations of bodies and joints."""

    joints: dict[str, Vector]

    def turning(self, name: str) -> Scalar:
        """Angular speed or acceleration of a body."""
        ...


@dataclass(frozen=True)
class Coupling:
    """A body whose centre of mass is off the line through two of its points."""

    factor: Scalar
    first: str
    second: str
    body: str


class Inertia:
    """Masses and moments of inertia, and the quadratic forms that they define."""

    @section("masses at joints and moments of inertia")
    def __init__(self, positions: Positions) -> None:
        self._positions = positions
        self._graph = positions.graph
        self.masses: dict[str, Scalar] = {}
        self.shares: dict[tuple[str, str], Scalar] = {}
        self.moments: dict[str, Scalar] = {}
        self.couplings: list[Coupling] = []
        for body in positions.topology.mechanism.bodies.values():
            if body.rotates:
                self._add_turning(body)
            else:
                self._add_sliding(body)
        for term in positions.topology.mechanism.point_masses:
            if not term.mass.absent:
                self._add_mass(term.joint, positions.inputs.parameter(term.mass))
        for joint, mass in self.masses.items():
            if mass.label is None and mass.operands:
                mass.label = f"joint{positions.numbers[joint]}_mass"

    def _add_mass(self, joint: str, mass: Scalar) -> None:
        self.masses[joint] = self.masses.get(joint, self._graph.zero) + mass

    def _add_share(self, body: Body, joint: str, mass: Scalar) -> None:
        self.shares[body.name, joint] = mass
        self._add_mass(joint, mass)

    def _add_sliding(self, body: Body) -> None:
        """The centre of mass of a slider lies at its first point."""
        if not body.mass.absent:
            first = next(iter(body.points))
            self._add_share(body, first, self._positions.inputs.parameter(body.mass))
        if not body.inertia.absent:
            self.moments[body.name] = self._positions.inputs.parameter(body.inertia)

    def _add_turning(self, body: Body) -> None:
        inputs = self._positions.inputs
        moment = inputs.parameter(body.inertia)
        if not body.mass.absent:
            mass = inputs.parameter(body.mass)
            first, *others = body.points
            centre = inputs.vector(body.centre) - inputs.vector(body.points[first])
            if others:
                second = others[0]
                base = self._positions.in_frame(body.name, first, second)
                ratio = centre.times(Vector(base.x, -base.y)) * (1.0 / base.square)
                self._add_share(body, first, mass * (1.0 - ratio.x))
                self._add_share(body, second, mass * ratio.x)
                share = ratio.x - ratio.x * ratio.x - ratio.y * ratio.y
                moment = moment - mass * base.square * share
                if ratio.y.constant != 0.0:
                    self.couplings.append(Coupling(mass * ratio.y, first, second, body.name))
            else:  # a body with one point has its centre of mass there
                self._add_share(body, first, mass)
        if moment.constant != 0.0:
            if moment.label is None and moment.operands:
                moment.label = f"body{self._positions.body_numbers[body.name]}_moment"
            self.moments[body.name] = moment

    def product(self, a: MotionField, b: MotionField, offset: Vector | None = None) -> Scalar:
        """Σ m a·b + Σ J α β over all masses and moments.

        Parameters
        ----------
        a, b
            Two motions; with two velocities of the same motion this is twice the kinetic energy,
            with two partial velocities the inertia term J_ij of the paper's Eq. 5.
        """
        terms: list[Scalar] = []
        for joint, mass in self.masses.items():
            vector = a.joints[joint] if offset is None else a.joints[joint] - offset
            weighted = b.joints[joint] * mass
            terms.append(vector.dot(weighted))
        terms += [a.turning(n) * (b.turning(n) * moment) for n, moment in self.moments.items()]
        for c in self.couplings:
            first, second = a.joints[c.first], a.joints[c.second]
            if offset is not None:
                first, second = first - offset, second - offset
            skew = first.dot(b.joints[c.second].turned) - second.dot(b.joints[c.first].turned)
            terms.append(c.factor * skew)
        return self._graph.total(terms)

    def apart(
        self, a: MotionField, body: str, point: str, velocity: Vector, offset: Vector | None = None
    ) -> Scalar:
        """What the masses of a body at one of its points add where it moves away from that point.

        `product` takes all masses at a joint to move with it.
        """

        def at(joint: str) -> Vector:
            return a.joints[joint] if offset is None else a.joints[joint] - offset

        share = self.shares.get((body, point), self._graph.zero)
        total = at(point).dot(velocity * share)
        for c in self.couplings:
            if c.body == body and point == c.second:
                total = total + c.factor * at(c.first).dot(velocity.turned)
            if c.body == body and point == c.first:
                total = total - c.factor * at(c.second).dot(velocity.turned)
        return total

    def moment_of_mass(self) -> Vector:
        """Σ m x: total mass times the place of the common centre of mass, in kg·m."""
        total = Vector(self._graph.zero, self._graph.zero)
        places = self._positions.joints
        for joint, mass in self.masses.items():
            total = total + places[joint] * mass
        for c in self.couplings:
            total = total + (places[c.second] - places[c.first]).turned * c.factor
        return total
