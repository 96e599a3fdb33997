"""What a component contributes: plain data that equations and kernels are built from.

Lengths are metres, angles radians (counter-clockwise from +x), masses kilograms.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

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
    """

    path: Path
    value: float
    structural: bool = False

    @property
    def absent(self) -> bool:
        """Whether everything multiplied by this number is left out of the kernel."""
        return self.structural and self.value == 0.0


ZERO = Parameter((), 0.0, structural=True)


Origin = str | tuple[Parameter, Parameter]


@dataclass(frozen=True)
class Guide:
    """A straight axis fixed to the ground: a point on it (or a ground joint) and its direction."""

    origin: Origin
    angle: Parameter


@dataclass(frozen=True, kw_only=True)
class Body:
    """A rigid body with one coordinate: an angle, or a displacement along ``guide``.

    Parameters
    ----------
    name, kind, path
        Name, what it is called in reports (``"bar"``, ``"plate"``, …), place in the file.
    points
        Joint name → coordinates in the body's own frame.
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


@dataclass(frozen=True)
class GroundPin:
    """A joint fixed to the ground."""

    joint: str
    position: tuple[Parameter, Parameter]


@dataclass(frozen=True)
class Displacement:
    """At ``joint``, the point of ``body`` is called ``renamed`` and joined by body ``link``."""

    joint: str
    body: str
    renamed: str
    link: Body


@dataclass(frozen=True)
class Prescribed:
    """A coordinate that is a given function of time: ``start + speed·t``."""

    body: str
    start: Parameter
    speed: Parameter
    path: Path


@dataclass(frozen=True)
class Initial:
    """A free coordinate and its state at t = 0."""

    body: str
    position: float
    speed: float
    path: Path


@dataclass(frozen=True)
class AxialForce:
    """A constant force on a sliding body along its axis (N)."""

    body: str
    force: Parameter
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


Term = Body | GroundPin | Displacement | Prescribed | Initial | AxialForce | Gravity | Hint


@dataclass(frozen=True)
class References:
    """Names that a component uses: each must be declared by another component."""

    joints: tuple[tuple[Path, str], ...] = ()
    ground: tuple[tuple[Path, str], ...] = ()
    bodies: tuple[tuple[Path, str, tuple[str, ...]], ...] = ()  # path, name, expected kinds
