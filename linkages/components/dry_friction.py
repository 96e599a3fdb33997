"""Dry friction at joints and in guides under a constant load: Coulomb's and Stribeck's.

References
----------
.. [1] E. Pennestrì, V. Rossi, P. Salvini, P. P. Valentini, "Review and comparison of dry friction
   force models", Nonlinear Dyn. 83 (2016) 1785-1801.
"""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import Section, component
from linkages.components.contributed.friction_laws import stribeck
from linkages.components.contributed.functions import Function, Number, V, applied
from linkages.components.contributed.listed import ListedComponent, turning, two_bodies
from linkages.components.contributed.measures import JointFriction, Load, Slide
from linkages.components.contributed.references import References
from linkages.components.contributed.terms import Parameter, Path
from linkages.spec.quantities import (
    Name,
    NonNegativeForce,
    NonNegativeTorque,
    PositiveAngularSpeed,
    PositiveSpeed,
)


class _Dry(ListedComponent):
    static: float | None
    stribeck_speed: float | None
    slip_speed: float | None

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """What breaks away is at least what slides, and comes with a speed."""
        if (self.static is None) != (self.stribeck_speed is None):
            missing = "stribeck_speed" if self.stribeck_speed is None else "static"
            given = "static" if missing == "stribeck_speed" else "stribeck_speed"
            return ((self.path, f"missing key {missing!r}: it goes with {given!r}"),)
        return ()

    def _less(self, key: str) -> tuple[tuple[Path, str], ...]:
        """What is wrong if less breaks away than slides."""
        sliding = getattr(self, key)
        if self.static is None or self.static >= sliding:
            return ()
        message = f"expected at least {sliding:g}, what {key!r} is, found {self.static:g}"
        return (((*self.path, "static"), message),)

    def _law(self, key: str) -> Function:
        """Return −(F + (F_static − F)·exp(−(v/v_stribeck)²))·sign(v), or smoothed [1]_."""
        size: Function = Number(self.number(key))
        if self.static is not None and self.stribeck_speed is not None:
            static = Number(self.number("static"))
            size = stribeck(size, static, self._number("stribeck_speed"))
        if self.slip_speed is None:
            return applied("neg", size * applied("stick", V))
        return applied("neg", size * applied("tanh", V / self._number("slip_speed")))

    def _number(self, key: str) -> Number:
        return Number(Parameter((*self.path, key), getattr(self, key)))


@component
class DryJointFriction(_Dry):
    """Dry friction at a joint where two bodies turn against each other.

    Parameters
    ----------
    index
        Place in the list of frictions.
    joint
        A joint at which two bodies turn against each other, or one against the ground.
    torque
        Friction torque while it slides in N·m, ≥ 0.
    bars
        Which two, where more meet; the first may be ``ground``.
    static
        Torque that it takes to break away, at least `torque`.
    stribeck_speed
        Speed in rad/s, > 0, over which it falls from `static` to `torque`; goes with `static`.
    slip_speed
        Speed in rad/s, > 0, over which friction is smoothed: nothing is held then.
    """

    section: ClassVar[str] = "friction"
    opens: ClassVar[Section] = Section("list", "{joint: A, torque: 0.2 N m}")

    index: int
    joint: Name
    torque: NonNegativeTorque
    bars: tuple[Name, Name] | None = None
    static: NonNegativeTorque | None = None
    stribeck_speed: PositiveAngularSpeed | None = None
    slip_speed: PositiveAngularSpeed | None = None

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Two different bodies, and a friction that breaks away."""
        bodies = two_bodies((*self.path, "bars"), self.bars) if self.bars else ()
        return (*bodies, *super().problems(), *self._less("torque"))

    def references(self) -> References:
        """The joint, and the bodies that have it."""
        path, bars = (*self.path, "bars"), self.bars or ()
        return References(
            joints=(((*self.path, "joint"), self.joint),),
            bodies=turning(path, bars),
            meeting=tuple(((*path, place), bar, self.joint) for place, bar in enumerate(bars)),
        )

    def terms(self) -> tuple[JointFriction, ...]:
        """Friction between bodies that only the whole mechanism knows."""
        law = self._law("torque")
        return (JointFriction(self.joint, self.bars, law, self.path, called="friction"),)


@component
class DryGuideFriction(_Dry):
    """Dry friction of a slider in its guide.

    Parameters
    ----------
    index
        Place in the list of frictions.
    slider
        Slider name.
    force
        Friction force while it slides in newtons, ≥ 0.
    static
        Force that it takes to break away, at least `force`.
    stribeck_speed
        Speed in m/s, > 0, over which it falls from `static` to `force`; goes with `static`.
    slip_speed
        Speed in m/s, > 0, over which friction is smoothed: nothing is held then.
    """

    section: ClassVar[str] = "friction"
    told_by: ClassVar[str] = "slider"

    index: int
    slider: Name
    force: NonNegativeForce
    static: NonNegativeForce | None = None
    stribeck_speed: PositiveSpeed | None = None
    slip_speed: PositiveSpeed | None = None

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """A friction that breaks away."""
        return (*super().problems(), *self._less("force"))

    def references(self) -> References:
        """The slider."""
        return References(bodies=(((*self.path, "slider"), self.slider, ("slider",)),))

    def terms(self) -> tuple[Load, ...]:
        """Friction along the axis."""
        return (Load(Slide(self.slider), self._law("force"), self.path, called="friction"),)
