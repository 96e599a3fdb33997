"""Gravity, parameters, initial state, assembly branch and defaults of a simulation."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from linkages.components.contributed.component import Component, Fault, Section, component
from linkages.components.contributed.terms import (
    PARAMETERS,
    Gravity,
    Hint,
    Initial,
    NamedNumber,
    named_number,
)
from linkages.operations import formula_functions
from linkages.options.run import SimulationOptions
from linkages.spec.formulas import CALLED, Constant
from linkages.spec.grammar import CONSTANTS
from linkages.spec.law_fields import PlaceRule
from linkages.spec.quantities import (
    AccelerationVector,
    Angle,
    AngularSpeed,
    BarName,
    Duration,
    JointName,
    Length,
    Name,
    Point,
    SliderName,
    Speed,
)


@component
class UniformGravity(Component):
    """Gravitational acceleration, the same everywhere.

    Parameters
    ----------
    acceleration
        Components along x and y in m/s².
    """

    section: ClassVar[str] = "gravity"

    acceleration: AccelerationVector

    def terms(self) -> tuple[Gravity, ...]:
        """A component of exactly zero is structure: its terms are left out."""
        return (Gravity(*self.pair(self.acceleration)),)


TARGETS = "targets"
"""The section of points that paths are compared with."""

MAX_POINTS = 1000
"""Of a target: each is looked for along the whole path."""

RESERVED = ("t", "and", "or", "not", "rate", *CONSTANTS, *CALLED, *formula_functions())
"""Words that mean something else in formulas."""


@component
class NumberOfFormulas(Component):
    """A number that any formula may use by its name.

    Parameters
    ----------
    name
        A word of letters, digits and _ that means nothing else in formulas.
    value
        In SI, or with a unit.
    """

    section: ClassVar[str] = PARAMETERS
    opens: ClassVar[Section] = Section("mapping", "friction_force: 30 kN", field="value")

    name: Name
    value: Annotated[Constant, PlaceRule()]

    def faults(self) -> Iterator[Fault]:
        """A name that formulas can read."""
        if not self.name.isidentifier():
            yield (), f"expected a word of letters, digits and _, found {self.name!r}"
        elif self.name in RESERVED:
            yield (), f"{self.name!r} means something else in formulas"

    def terms(self) -> tuple[NamedNumber, ...]:
        """The number itself."""
        return (NamedNumber(named_number(self.name, self.value.value)),)


@component
class Target(Component):
    """Points that the path of a joint is compared with, by measures of their distances.

    Parameters
    ----------
    name
        A word of letters, digits and _, which measures name.
    points
        The points, [x, y] in metres; or ``file``, ``columns`` and ``units``, as tables of laws have
        them.
    """

    section: ClassVar[str] = TARGETS
    opens: ClassVar[Section] = Section("mapping", "wanted: {points: [[0.1, 0.2], [0.1, 0.3]]}")

    name: Name
    points: tuple[tuple[Length, Length], ...]

    def faults(self) -> Iterator[Fault]:
        """A name that measures can read, and points."""
        if not self.name.isidentifier():
            yield (), f"expected a word of letters, digits and _, found {self.name!r}"
        elif not 0 < len(self.points) <= MAX_POINTS:
            yield "points", f"expected 1 to {MAX_POINTS} points, found {len(self.points)}"

    def terms(self) -> tuple[()]:
        """None: it says nothing about the mechanism."""
        return ()


@component
class SimulationDefaults(SimulationOptions, Component):
    """How the file's author wants the mechanism to be simulated.

    Parameters
    ----------
    end
        Simulated time in seconds.
    """

    section: ClassVar[str] = "simulate"

    end: Duration = 1.0

    def terms(self) -> tuple[()]:
        """None: it says nothing about the mechanism."""
        return ()


class _Free(Component):
    """A coordinate that nothing drives."""

    section: ClassVar[str] = "free"
    start: ClassVar[str]

    name: str
    speed: float

    def terms(self) -> tuple[Initial, ...]:
        """One free coordinate."""
        value, keys = getattr(self, self.start), ((self.start,), ("speed",))
        return (Initial(self.name, value, self.speed, self.path, keys),)


@component
class FreeAngle(_Free):
    """The angle of a bar or plate that nothing drives.

    Parameters
    ----------
    name
        The bar or plate.
    angle, speed
        State at t = 0 in rad and rad/s.
    """

    start: ClassVar[str] = "angle"

    name: BarName
    angle: Angle
    speed: AngularSpeed = 0.0


@component
class FreePosition(_Free):
    """The displacement of a slider that nothing drives.

    Parameters
    ----------
    name
        The slider.
    position, speed
        State at t = 0 in m and m/s.
    """

    told_by: ClassVar[str] = "position"
    start: ClassVar[str] = "position"

    name: SliderName
    position: Length
    speed: Speed = 0.0


SIDES = {"left": 1, "right": -1}


@component
class AssemblyHint(Component):
    """Where a joint is at t = 0.

    Parameters
    ----------
    name
        Joint name.
    where
        About where the joint is, or its side ("left" or "right") seen along the line between
        its two neighbour joints, in the order in which their bars stand in the file.
    """

    section: ClassVar[str] = "assembly"

    name: JointName
    where: Annotated[Literal["left", "right"] | Point, Field(union_mode="left_to_right")]

    def terms(self) -> tuple[Hint, ...]:
        """One hint."""
        if isinstance(self.where, str):
            return (Hint(self.name, None, SIDES[self.where], self.path),)
        return (Hint(self.name, self.where, None, self.path),)
