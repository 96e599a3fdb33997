"""Springs, dampers and Maxwell elements, along lines and about joints.

References
----------
.. [1] J. C. Maxwell, "On the dynamical theory of gases", Phil. Trans. R. Soc. 157 (1867) 49-88.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
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
from linkages.components.contributed.attachments import ends as ends
from linkages.components.contributed.attachments import two_joints as two_joints
from linkages.components.contributed.component import Fault, ListedComponent, Section, component
from linkages.components.contributed.functions import (
    Interpolation,
    Number,
    Table,
    V,
    X,
    applied,
    constant,
    extremes,
    unpaired,
)
from linkages.components.contributed.load_measures import Friction, Load, damper_law, spring_law
from linkages.components.contributed.state_laws import InternalState, negated, value_of
from linkages.components.laws import (
    DampingLaw,
    StiffnessLaw,
    TorsionalDampingLaw,
    TorsionalStiffnessLaw,
    function_of,
)
from linkages.spec.quantities import (
    Angle,
    Force,
    Length,
    NonNegativeLength,
    PositiveDamping,
    PositiveStiffness,
    PositiveTorsionalDamping,
    PositiveTorsionalStiffness,
    Torque,
)

TURNED_BODIES = {"bars": "two bodies that it turns against each other are 'between_bars'"}
"""What to write instead of keys of other sections."""


class _Spring(Attached, ListedComponent):
    """A spring and a damper side by side."""

    section: ClassVar[str] = "springs"
    relaxed: ClassVar[str]

    stiffness: StiffnessLaw | TorsionalStiffnessLaw
    damping: DampingLaw | TorsionalDampingLaw

    def terms(self) -> tuple[Load, ...]:
        """A spring and damper; numbers of exactly zero are structure."""
        law = spring_law(
            function_of(self.stiffness, (*self.path, "stiffness")),
            self.number(self.relaxed),
            function_of(self.damping, (*self.path, "damping")),
        )
        return (self.acting(law),)


@component
class JointSpring(_Spring, BetweenJoints):
    """A spring and a damper side by side that pull two joints together.

    Parameters
    ----------
    stiffness
        N/m, ≥ 0, or a law.
    length
        Length without force in metres, ≥ 0.
    damping
        N·s/m, ≥ 0, or a law.
    """

    told_by: ClassVar[str] = ""
    misplaced: ClassVar[Mapping[str, str]] = TURNED_BODIES
    relaxed: ClassVar[str] = "length"

    stiffness: StiffnessLaw
    length: NonNegativeLength
    damping: DampingLaw = 0.0


@component
class ConstantForceSpring(ListedComponent, BetweenJoints):
    """A spring that pulls two joints together with a constant force, and a damper beside it.

    Parameters
    ----------
    force
        Newtons; one below zero pushes.
    damping
        N·s/m, ≥ 0, or a law.
    """

    section: ClassVar[str] = "springs"
    told_by: ClassVar[str] = "force"

    force: Force
    damping: DampingLaw = 0.0

    def terms(self) -> tuple[Load, ...]:
        """One spring, whose energy is force times distance."""
        force = Number(self.number("force"))
        law = damper_law(function_of(self.damping, (*self.path, "damping"))) - force
        return (self.acting(law, called="constant-force spring", stores=force * X),)


@component
class _TorsionalSpring(_Spring):
    """A torsional spring and damper.

    Parameters
    ----------
    stiffness
        N·m/rad, ≥ 0, or a law.
    angle
        Angle without torque in radians: of the bar, or of the second body against the first; whole
        turns count.
    damping
        N·m·s/rad, ≥ 0, or a law.
    """

    relaxed: ClassVar[str] = "angle"

    stiffness: TorsionalStiffnessLaw
    angle: Angle = 0.0
    damping: TorsionalDampingLaw = 0.0


@component
class GuideSpring(_Spring, OnSlider):
    """A spring and a damper between a slider and what carries its axis, along that axis.

    Parameters
    ----------
    stiffness
        N/m, ≥ 0, or a law.
    position
        Position of the slider on its axis without force, in metres.
    damping
        N·s/m, ≥ 0, or a law.
    """

    relaxed: ClassVar[str] = "position"

    stiffness: StiffnessLaw
    position: Length = 0.0
    damping: DampingLaw = 0.0


@component
class BarSpring(_TorsionalSpring, OnBar):
    """A torsional spring and damper that turn a bar or plate against the ground."""


@component
class SpringBetweenBars(_TorsionalSpring, BetweenBars):
    """A torsional spring and damper between two bodies."""


class _Tabulated(Attached, ListedComponent):
    """What pulls back along a measure, as a table says."""

    section: ClassVar[str] = "springs"
    places: ClassVar[str]
    values: ClassVar[str]

    interpolation: Interpolation

    def _table(self) -> Table:
        path, places = (*self.path, self.values), getattr(self, self.places)
        return Table(path, places, getattr(self, self.values), False, self.interpolation, over=X)

    def faults(self) -> tuple[Fault, ...]:
        """Enough increasing places, and a value for each."""
        points = {key: getattr(self, key) for key in (self.places, self.values)}
        if fault := unpaired(points, "2" if self.interpolation == "linear" else "3"):
            return (fault,)
        places = points[self.places]
        if not all(map(math.isfinite, extremes(self._table(), places[0], places[-1]))):
            return ((self.places, f"expected {self.places} that are further apart"),)
        return ()

    def terms(self) -> tuple[Load, ...]:
        """One load."""
        if self.faults():  # reported
            return ()
        return (self.acting(applied("neg", self._table()), called="spring"),)


@component
class TabulatedSpring(_Tabulated, BetweenJoints):
    """A spring between two joints whose pull is a table over its length.

    Parameters
    ----------
    lengths
        Distances of the joints in metres, increasing, at least three (two for straight lines).
    forces
        The pull at each of them in newtons; below zero it pushes. Beyond the lengths it goes on in
        a straight line.
    interpolation
        ``pchip``, ``linear`` or ``spline``.
    """

    told_by: ClassVar[str] = "lengths"
    places: ClassVar[str] = "lengths"
    values: ClassVar[str] = "forces"

    lengths: tuple[NonNegativeLength, ...]
    forces: tuple[Force, ...]
    interpolation: Interpolation = "pchip"


@component
class TabulatedGuideSpring(_Tabulated, OnSlider):
    """A spring in the guide of a slider whose force is a table over the slider's position.

    Parameters
    ----------
    positions
        Positions on the axis in metres, increasing, at least three (two for straight lines).
    forces
        The pull at each of them in newtons, against the direction of the axis. Beyond the positions
        it goes on in a straight line.
    interpolation
        ``pchip``, ``linear`` or ``spline``.
    """

    told_by: ClassVar[str] = "positions"
    places: ClassVar[str] = "positions"
    values: ClassVar[str] = "forces"

    positions: tuple[Length, ...]
    forces: tuple[Force, ...]
    interpolation: Interpolation = "pchip"


@component
class TabulatedTorsionalSpring(_Tabulated, BetweenBars):
    """A spring between two bodies whose torque is a table over their angle.

    Parameters
    ----------
    angles
        Angles of the second against the first in radians, increasing, at least three (two for
        straight lines); whole turns count.
    torques
        The torque at each of them in N·m that turns the second back. Beyond the angles it goes on
        in a straight line.
    interpolation
        ``pchip``, ``linear`` or ``spline``.
    """

    told_by: ClassVar[str] = "angles"
    places: ClassVar[str] = "angles"
    values: ClassVar[str] = "torques"

    angles: tuple[Angle, ...]
    torques: tuple[Torque, ...]
    interpolation: Interpolation = "pchip"


class _Damper(Attachment, ListedComponent):
    """Its force is damping times the rate of what it is attached to."""

    section: ClassVar[str] = "dampers"

    damping: DampingLaw | TorsionalDampingLaw

    def terms(self) -> tuple[Load | Friction, ...]:
        """One damper."""
        return (self.acting(damper_law(function_of(self.damping, (*self.path, "damping")))),)


@component
class _LinearDamper(_Damper):
    """A damper along a line.

    Parameters
    ----------
    damping
        N·s/m, ≥ 0, or a law.
    """

    damping: DampingLaw


@component
class _TorsionalDamper(_Damper):
    """A damper of bodies that turn against each other.

    Parameters
    ----------
    damping
        N·m·s/rad, ≥ 0, or a law.
    """

    damping: TorsionalDampingLaw


@component
class LineDamper(_LinearDamper, BetweenJoints):
    """A damper between two joints: its force is damping times the rate of their distance."""

    told_by: ClassVar[str] = ""


@component
class GuideDamper(_LinearDamper, OnSlider):
    """Viscous friction of a slider in its guide."""


@component
class JointDamper(_TorsionalDamper, AtJoint):
    """Viscous friction in a revolute joint."""


@component
class DamperBetweenBars(_TorsionalDamper, OnBars):
    """A torsional damper between two bodies, wherever they are."""


@component
class ClearanceDamper(_TorsionalDamper, InClearance):
    """Viscous friction in a clearance: between its link and the bar that it displaces."""


class _Series(Attached, ListedComponent):
    """One force stretches the spring by s and moves the damper: k s = d (v - ds/dt) [1]_."""

    section: ClassVar[str] = "maxwell"

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

    told_by: ClassVar[str] = ""
    misplaced: ClassVar[Mapping[str, str]] = TURNED_BODIES
    opens: ClassVar[Section] = Section(
        "list", "{between: [A, B], stiffness: 5 N/mm, damping: 20 N s/m}"
    )


@component
class GuideMaxwellElement(_LineSeries, OnSlider):
    """A spring and a damper in series between a slider and what carries its axis."""


@component
class BarMaxwellElement(_TorsionalSeries, OnBar):
    """A torsional spring and damper in series between a bar or plate and the ground."""


@component
class MaxwellElementBetweenBars(_TorsionalSeries, BetweenBars):
    """A torsional spring and damper in series between two bodies."""
