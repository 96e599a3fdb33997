"""Loads: a force that follows a law, along what it is measured by.

A measure has a value x and its rate v. The law gives the force that increases x, as a function of
x, v and time; so its power is force · v, and whatever a measure is, any law goes with it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from linkages.components.contributed.functions import Function, Measured, Number, Operation, V, X
from linkages.components.contributed.state_laws import (
    NOTHING,
    addends,
    folded,
    leaves,
    monomial,
    stored,
    sum_of,
    time_functions,
)
from linkages.components.contributed.terms import Parameter, Path


@dataclass(frozen=True)
class Distance:
    """The distance of two joints (m). A force that increases it pushes them apart."""

    unit: ClassVar[str] = "N"

    first: str
    second: str


@dataclass(frozen=True)
class Turn:
    """The angle of a body against another one, or the ground (None); whole turns count (rad).

    A torque that increases it acts on ``body``, the opposite one on ``reference``.
    """

    unit: ClassVar[str] = "N m"

    body: str
    reference: str | None

    @property
    def bodies(self) -> tuple[str, ...]:
        """Those that turn."""
        return (self.body,) if self.reference is None else (self.body, self.reference)


@dataclass(frozen=True)
class Slide:
    """The displacement of a sliding body (m). What carries its axis gets the opposite force."""

    unit: ClassVar[str] = "N"

    body: str


@dataclass(frozen=True)
class Coordinate:
    """A coordinate of a joint in the ground's frame (m): `axis` 0 is x, 1 is y."""

    unit: ClassVar[str] = "N"

    joint: str
    axis: int


# A closed union: `assert_never` behind a match finds a measure that somebody forgot.
Measure = Distance | Turn | Slide | Coordinate


@dataclass(frozen=True)
class Load:
    """A force or torque along a measure.

    Parameters
    ----------
    measure
        What it acts along.
    law
        The force (N, N·m) as a function of time and of the measure's value `X` and rate `V`.
    path
        Where it stands in the definition file.
    """

    measure: Measure
    law: Function
    path: Path

    @property
    def unit(self) -> str:
        """Of the force or torque."""
        return self.measure.unit

    @property
    def twists(self) -> bool:
        """Whether it is a torque."""
        return self.unit == "N m"

    @property
    def given(self) -> bool:
        """Whether the force is a function of time, as it is written: not a spring or damper."""
        return not any(isinstance(leaf, Measured) for leaf in leaves(self.law))

    @cached_property
    def force(self) -> Function:
        """The law without what exact zeros remove."""
        return folded(self.law)

    @property
    def absent(self) -> bool:
        """Whether exact zeros remove all of it."""
        return self.force == NOTHING

    @property
    def elastic(self) -> bool:
        """Whether the force depends on the value of the measure."""
        return X in leaves(self.force)

    @property
    def dissipates(self) -> bool:
        """Whether the force depends on a rate; what follows time alone shrinks no set of states."""
        return V in leaves(self.force)

    @property
    def turned(self) -> tuple[str, ...]:
        """Bodies whose whole turns it feels."""
        return self.measure.bodies if isinstance(self.measure, Turn) and self.elastic else ()

    @property
    def laws(self) -> tuple[Function, ...]:
        """The functions of time that it follows: all of a given force, the factors of another."""
        return (self.law,) if self.given else tuple(time_functions(self.force))

    @property
    def deflection(self) -> Function:
        """What it is a spring of: x, less where it is relaxed."""
        products = map(monomial, addends(self.force))
        return next((m.base for m in products if m is not None and m.base is not None), X)

    @cached_property
    def energy(self) -> Function:
        """The potential energy that it has in a closed form, a function of `X` (J)."""
        return sum_of(energy for term in addends(self.force) if (energy := stored(term)))

    @cached_property
    def working(self) -> Function:
        """The part of the force whose work is in no `energy`."""
        return sum_of(term for term in addends(self.force) if stored(term) is None)

    @cached_property
    def still(self) -> Function:
        """The part of the force that no rate is in."""
        return sum_of(term for term in addends(self.force) if V not in leaves(term))


@dataclass(frozen=True)
class JointFriction:
    """What acts at a joint where two bodies turn; if not named, between the only two there.

    A mechanism makes it a `Load` along their angle.
    """

    joint: str
    bodies: tuple[str, str] | None
    law: Function
    path: Path


@dataclass(frozen=True)
class ClearanceFriction:
    """What turns the link of a clearance with the bar that it displaces.

    A mechanism makes it a `Load` along their angle.
    """

    clearance: str
    law: Function
    path: Path


Friction = JointFriction | ClearanceFriction


def damper_law(damping: Parameter) -> Function:
    """Return −damping·v."""
    return Operation("neg", (Operation("mul", (Number(damping), V)),))


def spring_law(stiffness: Parameter, relaxed: Parameter, damping: Parameter) -> Function:
    """Return −damping·v − stiffness·(x − relaxed)."""
    deflection = Operation("sub", (X, Number(relaxed)))
    spring = Operation("mul", (Number(stiffness), deflection))
    return Operation("sub", (damper_law(damping), spring))
