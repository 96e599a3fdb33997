"""Dampers along lines and about joints, and Maxwell elements.

References
----------
.. [1] J. C. Maxwell, "On the dynamical theory of gases", Phil. Trans. R. Soc. 157 (1867) 49-88.
"""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.attachments import (
    AtJoint,
    Attached,
    Attachment,
    BetweenBars,
    BetweenJoints,
    InClearance,
    OnBar,
    OnBars,
    OnSlider,
)
from linkages.components.contributed.component import ListedComponent, Section, component
from linkages.components.contributed.functions import V, constant
from linkages.components.contributed.load_measures import (
    Friction,
    Load,
    damper_law,
)
from linkages.components.contributed.state_laws import InternalState, negated, value_of
from linkages.components.laws import DampingLaw, TorsionalDampingLaw, function_of
from linkages.spec.quantities import (
    Angle,
    Length,
    PositiveDamping,
    PositiveStiffness,
    PositiveTorsionalDamping,
    PositiveTorsionalStiffness,
)


class _Damper(Attachment, ListedComponent):
    """Its force is damping times the rate of what it is attached to."""

    damping: DampingLaw | TorsionalDampingLaw

    def terms(self) -> tuple[Load | Friction, ...]:
        """One damper."""
        return (self.acting(damper_law(function_of(self.damping, (*self.path, "damping")))),)


@component
class LineDamper(_Damper, BetweenJoints):
    """A damper between two joints: its force is damping times the rate of their distance.

    Parameters
    ----------
    damping
        N·s/m, ≥ 0, or a law.
    """

    section: ClassVar[str] = "dampers"
    told_by: ClassVar[str] = ""

    damping: DampingLaw


@component
class GuideDamper(_Damper, OnSlider):
    """Viscous friction of a slider in its guide.

    Parameters
    ----------
    damping
        N·s/m, ≥ 0, or a law.
    """

    section: ClassVar[str] = "dampers"

    damping: DampingLaw


@component
class JointDamper(_Damper, AtJoint):
    """Viscous friction in a revolute joint.

    Parameters
    ----------
    damping
        N·m·s/rad, ≥ 0, or a law.
    """

    section: ClassVar[str] = "dampers"

    damping: TorsionalDampingLaw


@component
class DamperBetweenBars(_Damper, OnBars):
    """A torsional damper between two bodies, wherever they are.

    Parameters
    ----------
    damping
        N·m·s/rad, ≥ 0, or a law.
    """

    section: ClassVar[str] = "dampers"

    damping: TorsionalDampingLaw


@component
class ClearanceDamper(_Damper, InClearance):
    """Viscous friction in a clearance: between its link and the bar that it displaces.

    Parameters
    ----------
    damping
        N·m·s/rad, ≥ 0, or a law.
    """

    section: ClassVar[str] = "dampers"

    damping: TorsionalDampingLaw


class _Series(Attached, ListedComponent):
    """One force stretches the spring by s and moves the damper: k s = d (v - ds/dt) [1]_."""

    stiffness: float
    damping: float
    deflection: float

    def terms(self) -> tuple[Load, ...]:
        """One load, whose deflection is an internal state."""
        stiffness, damping = self.operand("stiffness"), self.operand("damping")
        path, unit = (*self.path, "deflection"), "rad" if self.measure.unit == "N m" else "m"
        force = stiffness * value_of(path)
        state = InternalState(path, unit, V - force / damping, initial=self.deflection)
        energy = constant(0.5) * force * state.value
        law, called = negated(force), "Maxwell element"
        return (self.acting(law, called=called, stores=energy, states=(state,)),)


@component
class _LineSeries(_Series):
    """A spring and a damper in series.

    Parameters
    ----------
    stiffness
        Of the spring in N/m, > 0.
    damping
        Of the damper in N·s/m, > 0.
    deflection
        By how much the spring is stretched at the start, in metres.
    """

    stiffness: PositiveStiffness
    damping: PositiveDamping
    deflection: Length = 0.0


@component
class _TorsionalSeries(_Series):
    """A torsional spring and damper in series.

    Parameters
    ----------
    stiffness
        Of the spring in N·m/rad, > 0.
    damping
        Of the damper in N·m·s/rad, > 0.
    deflection
        By how much the spring is turned at the start, in radians.
    """

    stiffness: PositiveTorsionalStiffness
    damping: PositiveTorsionalDamping
    deflection: Angle = 0.0


@component
class MaxwellElement(_LineSeries, BetweenJoints):
    """A spring and a damper in series between two joints."""

    section: ClassVar[str] = "maxwell"
    told_by: ClassVar[str] = ""
    opens: ClassVar[Section] = Section(
        "list", "{between: [A, B], stiffness: 5 N/mm, damping: 20 N s/m}"
    )


@component
class GuideMaxwellElement(_LineSeries, OnSlider):
    """A spring and a damper in series between a slider and what carries its axis."""

    section: ClassVar[str] = "maxwell"


@component
class BarMaxwellElement(_TorsionalSeries, OnBar):
    """A torsional spring and damper in series between a bar or plate and the ground."""

    section: ClassVar[str] = "maxwell"


@component
class MaxwellElementBetweenBars(_TorsionalSeries, BetweenBars):
    """A torsional spring and damper in series between two bodies."""

    section: ClassVar[str] = "maxwell"
