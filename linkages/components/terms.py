"""What a component contributes: plain data that equations and kernels are built from.

Lengths are metres, angles radians (counter-clockwise from +x), masses kilograms.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    from linkages.components.functions import Function

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
        of `body`.
    angle
        Direction of the axis in the frame of `body`.
    body
        The body that carries the axis; None for the ground.
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


class Acting(ABC):
    """What every load says of itself; whoever asks need not know which kind it is."""

    path: Path
    unit: ClassVar[str]
    """Of its force or torque."""

    @property
    @abstractmethod
    def laws(self) -> tuple[Function, ...]:
        """The functions of time that it follows."""

    @property
    @abstractmethod
    def dissipates(self) -> bool:
        """Whether it takes energy out of every motion that works on it."""

    @property
    @abstractmethod
    def turned(self) -> tuple[str, ...]:
        """Bodies whose whole turns it feels."""


class Applied(Acting):
    """A given force or torque: what it does depends on time alone."""

    @property
    def dissipates(self) -> bool:
        """It may put energy in and take it out, as drives do, but shrinks no set of states."""
        return False

    @property
    def turned(self) -> tuple[str, ...]:
        """None: it acts whatever the position."""
        return ()


class Passive(Acting):
    """A spring or damper: what it does depends on the motion alone."""

    damping: Parameter

    @property
    def laws(self) -> tuple[Function, ...]:
        """None: its numbers are constant."""
        return ()

    @property
    def dissipates(self) -> bool:
        """Whether it is damped."""
        return not self.damping.absent


@dataclass(frozen=True)
class AxialForce(Applied):
    """A force on a sliding body along its axis (N); its guide gets the opposite one."""

    unit = "N"

    body: str
    force: Function
    path: Path

    @property
    def laws(self) -> tuple[Function, ...]:
        """The force."""
        return (self.force,)


@dataclass(frozen=True)
class AxialDamper(Passive):
    """Viscous friction in a guide: the force −damping·ṡ (N·s/m)."""

    unit = "N"

    body: str
    damping: Parameter
    path: Path

    @property
    def turned(self) -> tuple[str, ...]:
        """None: bodies that slide do not turn."""
        return ()


@dataclass(frozen=True)
class PointForce(Applied):
    """A force at a joint with given components in the ground's frame (N)."""

    unit = "N"

    joint: str
    force: tuple[Function, Function]
    path: Path

    @property
    def laws(self) -> tuple[Function, ...]:
        """Both components."""
        return self.force


@dataclass(frozen=True)
class Torque(Applied):
    """A torque on a body (N·m); ``reference`` gets the opposite one (None: the ground)."""

    unit = "N m"

    body: str
    reference: str | None
    torque: Function
    path: Path

    @property
    def laws(self) -> tuple[Function, ...]:
        """The torque."""
        return (self.torque,)


@dataclass(frozen=True)
class Spring(Passive):
    """A translational spring and damper between two joints.

    It pulls with stiffness·(distance − length) + damping·(rate of the distance).
    """

    unit = "N"

    first: str
    second: str
    stiffness: Parameter
    length: Parameter
    damping: Parameter
    path: Path

    @property
    def turned(self) -> tuple[str, ...]:
        """None: a distance is the same after a whole turn."""
        return ()


@dataclass(frozen=True)
class TorsionSpring(Passive):
    """A torsional spring and damper that turns ``body`` against ``reference`` (None: ground).

    Its torque on ``body`` is −stiffness·(θ_body − θ_reference − angle) − damping·(ω_body −
    ω_reference); whole turns count.
    """

    unit = "N m"

    body: str
    reference: str | None
    stiffness: Parameter
    angle: Parameter
    damping: Parameter
    path: Path

    @property
    def turned(self) -> tuple[str, ...]:
        """Both bodies, if it is elastic."""
        bodies = () if self.stiffness.absent else (self.body, self.reference)
        return tuple(name for name in bodies if name is not None)


@dataclass(frozen=True)
class JointFriction:
    """Viscous friction at a joint between two bodies; if not named, between the only two there.

    A mechanism turns it into a `TorsionSpring` without stiffness (N·m·s/rad).
    """

    joint: str
    bodies: tuple[str, str] | None
    damping: Parameter
    path: Path


@dataclass(frozen=True)
class ClearanceFriction:
    """Viscous friction that turns the link of a clearance with the bar that it displaces.

    A mechanism turns it into a `TorsionSpring` without stiffness (N·m·s/rad).
    """

    clearance: str
    damping: Parameter
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


# A closed union: `assert_never` behind a match finds a kind that somebody forgot.
Load = AxialForce | AxialDamper | PointForce | Torque | Spring | TorsionSpring

Friction = JointFriction | ClearanceFriction

Term = (
    Body
    | GroundPin
    | Displacement
    | Relation
    | PointMass
    | Prescribed
    | Initial
    | Gravity
    | Hint
    | Load
    | Friction
)


@dataclass(frozen=True)
class References:
    """Names that a component uses: each must be declared by another component.

    Parameters
    ----------
    joints, ground, moving
        Paths and names of joints: any, of the ground, not of the ground.
    bodies
        Paths, names and the kinds of bodies that are expected.
    points
        Paths, bodies, and joints that these must have.
    meeting
        Paths, bodies, and joints at which these must turn, as they are or with a slider that they
        carry; the body may be ``"ground"``.
    """

    joints: tuple[tuple[Path, str], ...] = ()
    ground: tuple[tuple[Path, str], ...] = ()
    moving: tuple[tuple[Path, str], ...] = ()
    bodies: tuple[tuple[Path, str, tuple[str, ...]], ...] = ()
    points: tuple[tuple[Path, str, str], ...] = ()
    meeting: tuple[tuple[Path, str, str], ...] = ()
