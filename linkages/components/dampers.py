"""Dampers along lines and about joints, and Maxwell elements.

References
----------
.. [1] J. C. Maxwell, "On the dynamical theory of gases", Phil. Trans. R. Soc. 157 (1867) 49-88.
"""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import (
    TURNING,
    ListedComponent,
    References,
    Section,
    component,
    reference,
    turning,
    two_bodies,
)
from linkages.components.contributed.functions import V, constant
from linkages.components.contributed.load_measures import (
    ClearanceFriction,
    Distance,
    JointFriction,
    Load,
    Measure,
    Slide,
    Turn,
    damper_law,
)
from linkages.components.contributed.state_laws import InternalState, negated, value_of
from linkages.components.laws import DampingLaw, TorsionalDampingLaw, function_of
from linkages.components.springs import ends, two_joints
from linkages.reading.paths import KeyPath
from linkages.spec.quantities import (
    Angle,
    Length,
    Name,
    PositiveDamping,
    PositiveStiffness,
    PositiveTorsionalDamping,
    PositiveTorsionalStiffness,
)


@component
class LineDamper(ListedComponent):
    """A damper between two joints: its force is damping times the rate of their distance.

    Parameters
    ----------
    index
        Place in the list of dampers.
    between
        Two joints; one may be fixed to the ground.
    damping
        N·s/m, ≥ 0, or a law.
    """

    section: ClassVar[str] = "dampers"

    index: int
    between: tuple[Name, Name]
    damping: DampingLaw

    def problems(self) -> tuple[tuple[KeyPath, str], ...]:
        """Two different joints."""
        return two_joints((*self.path, "between"), self.between)

    def references(self) -> References:
        """The joints."""
        return References(joints=ends((*self.path, "between"), self.between))

    def terms(self) -> tuple[Load, ...]:
        """A damper between the joints."""
        damping = function_of(self.damping, (*self.path, "damping"))
        return (Load(Distance(*self.between), damper_law(damping), self.path),)


@component
class GuideDamper(ListedComponent):
    """Viscous friction of a slider in its guide.

    Parameters
    ----------
    index
        Place in the list of dampers.
    slider
        Slider name.
    damping
        N·s/m, ≥ 0, or a law.
    """

    section: ClassVar[str] = "dampers"
    told_by: ClassVar[str] = "slider"

    index: int
    slider: Name
    damping: DampingLaw

    def references(self) -> References:
        """The slider."""
        return References(bodies=(((*self.path, "slider"), self.slider, ("slider",)),))

    def terms(self) -> tuple[Load, ...]:
        """One damper along the axis."""
        damping = function_of(self.damping, (*self.path, "damping"))
        return (Load(Slide(self.slider), damper_law(damping), self.path),)


@component
class JointDamper(ListedComponent):
    """Viscous friction in a revolute joint.

    Parameters
    ----------
    index
        Place in the list of dampers.
    joint
        A joint at which two bodies turn against each other, or one against the ground.
    damping
        N·m·s/rad, ≥ 0, or a law.
    bars
        Which two, where more meet; the first may be ``ground``.
    """

    section: ClassVar[str] = "dampers"
    told_by: ClassVar[str] = "joint"

    index: int
    joint: Name
    damping: TorsionalDampingLaw
    bars: tuple[Name, Name] | None = None

    def problems(self) -> tuple[tuple[KeyPath, str], ...]:
        """Two different bodies."""
        return two_bodies((*self.path, "bars"), self.bars) if self.bars else ()

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
        damping = function_of(self.damping, (*self.path, "damping"))
        return (JointFriction(self.joint, self.bars, damper_law(damping), self.path),)


@component
class DamperBetweenBars(ListedComponent):
    """A torsional damper between two bodies, wherever they are.

    Parameters
    ----------
    index
        Place in the list of dampers.
    bars
        Two bars or plates; the first may be ``ground``.
    damping
        N·m·s/rad, ≥ 0, or a law.
    """

    section: ClassVar[str] = "dampers"
    told_by: ClassVar[str] = "bars"

    index: int
    bars: tuple[Name, Name]
    damping: TorsionalDampingLaw

    def problems(self) -> tuple[tuple[KeyPath, str], ...]:
        """Two different bodies."""
        return two_bodies((*self.path, "bars"), self.bars)

    def references(self) -> References:
        """The bodies."""
        return References(bodies=turning((*self.path, "bars"), self.bars))

    def terms(self) -> tuple[Load, ...]:
        """A damper along their angle."""
        damping = function_of(self.damping, (*self.path, "damping"))
        angle = Turn(self.bars[1], reference(self.bars))
        return (Load(angle, damper_law(damping), self.path),)


@component
class ClearanceDamper(ListedComponent):
    """Viscous friction in a clearance: between its link and the bar that it displaces.

    Parameters
    ----------
    index
        Place in the list of dampers.
    clearance
        Clearance name.
    damping
        N·m·s/rad, ≥ 0, or a law.
    """

    section: ClassVar[str] = "dampers"
    told_by: ClassVar[str] = "clearance"

    index: int
    clearance: Name
    damping: TorsionalDampingLaw

    def references(self) -> References:
        """The clearance."""
        return References(bodies=(((*self.path, "clearance"), self.clearance, ("clearance",)),))

    def terms(self) -> tuple[ClearanceFriction, ...]:
        """Friction against a bar that the clearance knows."""
        damping = function_of(self.damping, (*self.path, "damping"))
        return (ClearanceFriction(self.clearance, damper_law(damping), self.path),)


class _Series(ListedComponent):
    """One force stretches the spring by s and moves the damper: k s = d (v - ds/dt) [1]_."""

    stiffness: float
    damping: float
    deflection: float

    def _along(self, measure: Measure) -> tuple[Load, ...]:
        stiffness, damping = self.operand("stiffness"), self.operand("damping")
        path, unit = (*self.path, "deflection"), "rad" if measure.unit == "N m" else "m"
        force = stiffness * value_of(path)
        state = InternalState(path, unit, V - force / damping, initial=self.deflection)
        energy = constant(0.5) * force * state.value
        named = "Maxwell element"
        return (Load(measure, negated(force), self.path, named, stores=energy, states=(state,)),)


@component
class MaxwellElement(_Series):
    """A spring and a damper in series between two joints.

    Parameters
    ----------
    index
        Place in the list of Maxwell elements.
    between
        Two joints; one may be fixed to the ground.
    stiffness
        Of the spring in N/m, > 0.
    damping
        Of the damper in N·s/m, > 0.
    deflection
        By how much the spring is stretched at the start, in metres.
    """

    section: ClassVar[str] = "maxwell"
    opens: ClassVar[Section] = Section(
        "list", "{between: [A, B], stiffness: 5 N/mm, damping: 20 N s/m}"
    )

    index: int
    between: tuple[Name, Name]
    stiffness: PositiveStiffness
    damping: PositiveDamping
    deflection: Length = 0.0

    def problems(self) -> tuple[tuple[KeyPath, str], ...]:
        """Two different joints."""
        return two_joints((*self.path, "between"), self.between)

    def references(self) -> References:
        """The joints."""
        return References(joints=ends((*self.path, "between"), self.between))

    def terms(self) -> tuple[Load, ...]:
        """Along the distance of the joints."""
        return self._along(Distance(*self.between))


@component
class GuideMaxwellElement(_Series):
    """A spring and a damper in series between a slider and what carries its axis.

    Parameters
    ----------
    index
        Place in the list of Maxwell elements.
    slider
        Slider name.
    stiffness
        Of the spring in N/m, > 0.
    damping
        Of the damper in N·s/m, > 0.
    deflection
        By how much the spring is stretched at the start, in metres.
    """

    section: ClassVar[str] = "maxwell"
    told_by: ClassVar[str] = "slider"

    index: int
    slider: Name
    stiffness: PositiveStiffness
    damping: PositiveDamping
    deflection: Length = 0.0

    def references(self) -> References:
        """The slider."""
        return References(bodies=(((*self.path, "slider"), self.slider, ("slider",)),))

    def terms(self) -> tuple[Load, ...]:
        """Along the axis."""
        return self._along(Slide(self.slider))


@component
class BarMaxwellElement(_Series):
    """A torsional spring and damper in series between a bar or plate and the ground.

    Parameters
    ----------
    index
        Place in the list of Maxwell elements.
    bar
        The bar or plate.
    stiffness
        Of the spring in N·m/rad, > 0.
    damping
        Of the damper in N·m·s/rad, > 0.
    deflection
        By how much the spring is turned at the start, in radians.
    """

    section: ClassVar[str] = "maxwell"
    told_by: ClassVar[str] = "bar"

    index: int
    bar: Name
    stiffness: PositiveTorsionalStiffness
    damping: PositiveTorsionalDamping
    deflection: Angle = 0.0

    def references(self) -> References:
        """The bar."""
        return References(bodies=(((*self.path, "bar"), self.bar, TURNING),))

    def terms(self) -> tuple[Load, ...]:
        """Along the angle of the bar."""
        return self._along(Turn(self.bar, None))


@component
class MaxwellElementBetweenBars(_Series):
    """A torsional spring and damper in series between two bodies.

    Parameters
    ----------
    index
        Place in the list of Maxwell elements.
    between_bars
        Two bars or plates; the first may be ``ground``.
    stiffness
        Of the spring in N·m/rad, > 0.
    damping
        Of the damper in N·m·s/rad, > 0.
    deflection
        By how much the spring is turned at the start, in radians.
    """

    section: ClassVar[str] = "maxwell"
    told_by: ClassVar[str] = "between_bars"

    index: int
    between_bars: tuple[Name, Name]
    stiffness: PositiveTorsionalStiffness
    damping: PositiveTorsionalDamping
    deflection: Angle = 0.0

    def problems(self) -> tuple[tuple[KeyPath, str], ...]:
        """Two different bodies."""
        return two_bodies((*self.path, "between_bars"), self.between_bars)

    def references(self) -> References:
        """The bodies."""
        return References(bodies=turning((*self.path, "between_bars"), self.between_bars))

    def terms(self) -> tuple[Load, ...]:
        """Along the angle of the second against the first."""
        return self._along(Turn(self.between_bars[1], reference(self.between_bars)))
