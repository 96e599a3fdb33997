"""Dry friction at joints and in guides under a constant load: Coulomb's, Stribeck's and LuGre.

References
----------
.. [1] E. Pennestrì, V. Rossi, P. Salvini, P. P. Valentini, "Review and comparison of dry friction
   force models", Nonlinear Dyn. 83 (2016) 1785-1801.
.. [2] C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky, "A new model for control of
   systems with friction", IEEE Trans. Automat. Contr. 40 (1995) 419-425: LuGre.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar, Required, TypedDict

from linkages.components.contributed.attachments import (
    AtJoint,
    Attachment,
    BetweenBars,
    BetweenJoints,
    OnSlider,
)
from linkages.components.contributed.component import Fault, ListedComponent, Section, component
from linkages.components.contributed.friction_laws import stribeck
from linkages.components.contributed.functions import (
    PRESSED,
    Function,
    Number,
    V,
    applied,
    constant,
)
from linkages.components.contributed.load_measures import Bearing, Friction, JointFriction, Load
from linkages.components.contributed.state_laws import InternalState, negated, value_of
from linkages.components.contributed.terms import axis_label
from linkages.spec.quantities import (
    Damping,
    NonNegativeForce,
    NonNegativeNumber,
    NonNegativeTorque,
    PositiveAngularSpeed,
    PositiveLength,
    PositiveSpeed,
    PositiveStiffness,
    PositiveTorsionalStiffness,
    TorsionalDamping,
)


class _Law(TypedDict, total=False):
    """What a load or a friction at a joint has of it."""

    law: Required[Function]
    stores: Function
    states: tuple[InternalState, ...]


class _Dry(Attachment, ListedComponent):
    """Friction of a size that does not follow a reaction."""

    section: ClassVar[str] = "friction"
    size: ClassVar[str]

    static: float | None
    stribeck_speed: float | None
    slip_speed: float | None
    bristle_stiffness: float | None
    bristle_damping: float

    def faults(self) -> Iterator[Fault]:
        """What breaks away is at least what slides, and comes with a speed; bristles slide."""
        sliding = getattr(self, self.size)
        if (self.static is None) != (self.stribeck_speed is None):
            missing = "stribeck_speed" if self.stribeck_speed is None else "static"
            given = "static" if missing == "stribeck_speed" else "stribeck_speed"
            yield (), f"missing key {missing!r}: it goes with {given!r}"
        elif self.static is not None and self.static < sliding:
            found = f"found {self.static:g}"
            yield "static", f"expected at least {sliding:g}, what {self.size!r} is, {found}"
        if self.bristle_stiffness is None:
            if self.bristle_damping:
                yield "bristle_damping", "expected 'bristle_stiffness' with it"
        elif self.slip_speed is not None:
            remedy = "expected no 'slip_speed' with them"
            yield "slip_speed", f"bristles are smooth themselves; {remedy}"
        elif sliding == 0:
            yield self.size, "expected > 0, for bristles slide at it"

    @property
    def _law(self) -> _Law:
        """Return −g(v)·sign(v), or smoothed [1]_, or the LuGre law [2]_.

        There g = F + (F_static − F)·exp(−(v/v_stribeck)²). Bristles of stiffness σ0 and damping σ1
        are bent by z, with ż = v − σ0·|v|·z/g, and pull with σ0·z + σ1·ż.
        """
        size: Function = Number(self.number(self.size))
        if self.static is not None and self.stribeck_speed is not None:
            static = Number(self.number("static"))
            size = stribeck(size, static, self.operand("stribeck_speed"))
        if self.bristle_stiffness is not None:
            return self._bristles(size, self.bristle_stiffness)
        if self.slip_speed is None:
            return _Law(law=applied("neg", size * applied("sign", V)))
        return _Law(law=applied("neg", size * applied("tanh", V / self.operand("slip_speed"))))

    def _bristles(self, size: Function, stiffness: float) -> _Law:
        path, unit = (*self.path, "bristle"), {"torque": "rad", "force": "m"}[self.size]
        force = self.operand("bristle_stiffness") * value_of(path)
        rate = V - force * applied("abs", V) / size
        state = InternalState(path, unit, rate, scale=getattr(self, self.size) / stiffness)
        return _Law(
            law=negated(force + Number(self.number("bristle_damping")) * rate),
            stores=constant(0.5) * force * state.value,
            states=(state,),
        )

    def terms(self) -> tuple[Load | Friction, ...]:
        """Friction along what it is attached to."""
        return (self.acting(called="friction", **self._law),)


@component
class _DryTorque(_Dry):
    """Dry friction of bodies that turn against each other.

    Parameters
    ----------
    torque
        Friction torque while it slides in N·m, ≥ 0.
    static
        Torque that it takes to break away, at least `torque`.
    stribeck_speed
        Speed in rad/s, > 0, over which it falls from `static` to `torque`; goes with `static`.
    slip_speed
        Speed in rad/s, > 0, over which friction is smoothed: nothing is held then.
    bristle_stiffness
        Torque per angle in N·m/rad, > 0, of bristles that bend before they slide (LuGre).
    bristle_damping
        Damping of the bristles in N·m·s/rad, ≥ 0.
    """

    size: ClassVar[str] = "torque"

    torque: NonNegativeTorque
    static: NonNegativeTorque | None = None
    stribeck_speed: PositiveAngularSpeed | None = None
    slip_speed: PositiveAngularSpeed | None = None
    bristle_stiffness: PositiveTorsionalStiffness | None = None
    bristle_damping: TorsionalDamping = 0.0


@component
class _DryForce(_Dry):
    """Dry friction along a line.

    Parameters
    ----------
    force
        Friction force while it slides in newtons, ≥ 0.
    static
        Force that it takes to break away, at least `force`.
    stribeck_speed
        Speed in m/s, > 0, over which it falls from `static` to `force`; goes with `static`.
    slip_speed
        Speed in m/s, > 0, over which friction is smoothed: nothing is held then.
    bristle_stiffness
        Force per displacement in N/m, > 0, of bristles that bend before they slide (LuGre).
    bristle_damping
        Damping of the bristles in N·s/m, ≥ 0.
    """

    size: ClassVar[str] = "force"

    force: NonNegativeForce
    static: NonNegativeForce | None = None
    stribeck_speed: PositiveSpeed | None = None
    slip_speed: PositiveSpeed | None = None
    bristle_stiffness: PositiveStiffness | None = None
    bristle_damping: Damping = 0.0


@component
class DryJointFriction(_DryTorque, AtJoint):
    """Dry friction at a joint where two bodies turn against each other."""

    told_by: ClassVar[str] = ""
    opens: ClassVar[Section] = Section("list", "{joint: A, torque: 0.2 N m}")


@component
class DryFrictionBetweenBars(_DryTorque, BetweenBars):
    """Dry friction between two bodies that turn against each other, wherever they are: a clutch."""


@component
class DryGuideFriction(_DryForce, OnSlider):
    """Dry friction of a slider in its guide."""


@component
class DryFrictionBetweenJoints(_DryForce, BetweenJoints):
    """Dry friction along the line through two joints: a telescope, a friction damper."""


class _Pressed(ListedComponent):
    """Friction that follows a reaction."""

    section: ClassVar[str] = "friction"

    coefficient: float

    def _friction(self, *factors: str) -> Function:
        """Return −μ·P·tanh(v/v_slip), with further factors of the definition."""
        size: Function = self.operand("coefficient") * PRESSED
        for key in factors:
            size = self.operand(key) * size
        return negated(size * applied("tanh", V / self.operand("slip_speed")))


@component
class JournalFriction(_Pressed, AtJoint):
    """Friction of a journal in its bearing that follows the reaction in the joint.

    Parameters
    ----------
    coefficient
        Friction force over reaction, ≥ 0.
    radius
        Of the journal in metres, > 0.
    slip_speed
        Speed in rad/s, > 0, over which friction is smoothed.
    """

    told_by: ClassVar[str] = "radius"

    coefficient: NonNegativeNumber
    radius: PositiveLength
    slip_speed: PositiveAngularSpeed

    def terms(self) -> tuple[JointFriction, ...]:
        """Friction between bodies that only the whole mechanism knows."""
        return (self.acting(self._friction("radius"), called="friction"),)


@component
class PressedGuideFriction(_Pressed, OnSlider):
    """Friction of a slider that follows the normal force in its guide.

    Parameters
    ----------
    coefficient
        Friction force over normal force, ≥ 0.
    slip_speed
        Speed in m/s, > 0, over which friction is smoothed.
    """

    told_by: ClassVar[str] = "coefficient"

    coefficient: NonNegativeNumber
    slip_speed: PositiveSpeed

    def terms(self) -> tuple[Load, ...]:
        """Friction along the axis, under the force across it."""
        bearing = Bearing(self.slider, axis_label(self.slider))
        return (self.acting(self._friction(), called="friction", bearing=bearing),)
