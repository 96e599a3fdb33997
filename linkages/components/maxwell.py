"""Maxwell elements: a spring and a damper in series, along whatever springs act along.

References
----------
.. [1] J. C. Maxwell, "On the dynamical theory of gases", Phil. Trans. R. Soc. 157 (1867) 49-88.
"""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import Section, component
from linkages.components.contributed.functions import V, constant
from linkages.components.contributed.internal import InternalState, value_of
from linkages.components.contributed.listed import (
    TURNING,
    ListedComponent,
    reference,
    turning,
    two_bodies,
)
from linkages.components.contributed.measures import Distance, Load, Measure, Slide, Turn
from linkages.components.contributed.references import References
from linkages.components.contributed.state_laws import negated
from linkages.components.contributed.terms import Path
from linkages.components.spring import ends, two_joints
from linkages.spec.quantities import (
    Angle,
    Length,
    Name,
    PositiveDamping,
    PositiveStiffness,
    PositiveTorsionalDamping,
    PositiveTorsionalStiffness,
)


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

    def problems(self) -> tuple[tuple[Path, str], ...]:
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

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Two different bodies."""
        return two_bodies((*self.path, "between_bars"), self.between_bars)

    def references(self) -> References:
        """The bodies."""
        return References(bodies=turning((*self.path, "between_bars"), self.between_bars))

    def terms(self) -> tuple[Load, ...]:
        """Along the angle of the second against the first."""
        return self._along(Turn(self.between_bars[1], reference(self.between_bars)))
