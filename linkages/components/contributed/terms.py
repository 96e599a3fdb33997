"""What a component contributes: plain data that equations and kernels are built from.

Lengths are metres, angles radians (counter-clockwise from +x), masses kilograms.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from linkages.components.contributed.functions import Function

Path = tuple[str | int, ...]


@dataclass(frozen=True)
class Parameter:
    """A number of the definition file: an argument of the kernel, never a part of its text.

    Parameters
    ----------
    path
        Where it stands in the definition file, e.g. ``("bars", "crank1", "length")``.
    value
        In SI units.
    structural
        Whether an exact zero is structure that removes terms (a massless bar, no gravity).
    kept
        Whether it stays an argument of the kernel whatever its value: sensitivities to it are
        asked for.
    """

    path: Path
    value: float
    structural: bool = False
    kept: bool = False

    @property
    def absent(self) -> bool:
        """Whether everything multiplied by this number is left out of the kernel."""
        return self.structural and self.value == 0.0 and not self.kept


ZERO = Parameter((), 0.0, structural=True)


Origin = str | tuple[Parameter, Parameter]


@dataclass(frozen=True)
class Guide:
    """A straight axis that a body slides along.

    Parameters
    ----------
    origin
        The point of the axis that displacements count from: a joint, or coordinates in the frame
        of `body`. A joint that moves carries the axis along, which keeps its direction.
    angle
        Direction of the axis in the frame of `body`.
    body
        The body whose frame the direction counts from, and that carries the axis unless a moving
        joint does; None for the ground.
    """

    origin: Origin
    angle: Parameter
    body: str | None = None


def axis_label(slider: str) -> str:
    """Return what the point is called that a slider's displacement counts from.

    It is a point of the body that carries the axis; no name of a definition file contains a dot.
    """
    return f"{slider}.axis"


def point_words(point: str, joint: str = "joint ") -> str:
    """What messages call a point: a joint, or the axis of a slider, which has no name in files."""
    slider = point.removesuffix(".axis")
    return f"{joint}{point}" if slider == point else f"the axis of {slider}"


@dataclass(frozen=True, kw_only=True)
class Body:
    """A rigid body with one coordinate: an angle, or a displacement along ``guide``.

    Parameters
    ----------
    name, kind, path
        Name, what it is called in reports (``"bar"``, ``"plate"``, …), place in the file.
    points
        Joint name → coordinates in the body's own frame. The frame of a sliding body has its
        first axis along its guide and its origin at its first joint.
    mass, inertia
        ``inertia`` is about the centre of mass.
    centre
        Centre of mass in the body's own frame.
    guide
        The axis of a sliding body; None for a body that turns.
    """

    name: str
    kind: str
    path: Path
    points: Mapping[str, tuple[Parameter, Parameter]]
    mass: Parameter = ZERO
    inertia: Parameter = ZERO
    centre: tuple[Parameter, Parameter] = (ZERO, ZERO)
    guide: Guide | None = None

    @property
    def rotates(self) -> bool:
        """Whether the coordinate is an angle."""
        return self.guide is None

    @property
    def afloat(self) -> bool:
        """Whether a joint carries its axis, in a mechanism that has resolved all other origins."""
        return self.guide is not None and isinstance(self.guide.origin, str)

    @property
    def axis(self) -> str:
        """The point that the displacement of a sliding body of a mechanism counts from."""
        origin = None if self.guide is None else self.guide.origin
        return origin if isinstance(origin, str) else axis_label(self.name)


@dataclass(frozen=True)
class GroundPin:
    """A joint fixed to the ground."""

    joint: str
    position: tuple[Parameter, Parameter]


@dataclass(frozen=True)
class Displacement:
    """At ``joint``, the point of ``body`` is called ``renamed`` and reached along ``links``.

    Parameters
    ----------
    name
        Of the clearance.
    joint, body, renamed
        The point of `body` at `joint` is called `renamed`.
    links
        Massless bodies from the joint to that point: one that turns while pin and hole stay in
        contact, or two that slide along x and y where they may part.
    """

    name: str
    joint: str
    body: str
    renamed: str
    links: tuple[Body, ...]


@dataclass(frozen=True)
class Relation:
    """The angle of a body follows from others: θ = offset + Σ ratio·θ_other (welds, gears).

    Parameters
    ----------
    body
        A body that turns.
    parts
        Other bodies that turn, with their ratios. A ratio of exactly 1 is structure.
    offset
        In radians.
    path
        Where it stands in the definition file.
    """

    body: str
    parts: tuple[tuple[str, Parameter], ...]
    offset: Parameter
    path: Path


@dataclass(frozen=True)
class PointMass:
    """A mass concentrated at a joint (kg)."""

    joint: str
    mass: Parameter
    path: Path


@dataclass(frozen=True)
class Prescribed:
    """A coordinate (angle or displacement) that is a given function of time."""

    body: str
    law: Function
    path: Path


@dataclass(frozen=True)
class Initial:
    """A free coordinate and its state at t = 0."""

    body: str
    position: float
    speed: float
    path: Path


@dataclass(frozen=True)
class Gravity:
    """Uniform gravitational acceleration (m/s²)."""

    x: Parameter
    y: Parameter


@dataclass(frozen=True)
class Hint:
    """Where a joint is at t = 0: about there, or on which side."""

    joint: str
    position: tuple[float, float] | None
    side: int | None
    path: Path
