"""Stops at the ends of travel, and ropes that become taut.

Springs push back, or bodies bounce at once and come to rest there.

References
----------
.. [1] B. V. Derjaguin, V. M. Muller, Y. P. Toporov, J. Colloid Interface Sci. 53 (1975) 314.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar

from linkages.components.contributed.attachments import (
    Attached,
    BetweenJoints,
    OnBars,
    OnSlider,
)
from linkages.components.contributed.component import Fault, ListedComponent, Section, component
from linkages.components.contributed.contact_laws import Ratio
from linkages.components.contributed.functions import V, X, applied
from linkages.components.contributed.load_measures import End, Load
from linkages.components.contributed.normal_forces import RigidContact
from linkages.components.contributed.state_laws import sum_of
from linkages.components.contributed.terms import Parameter
from linkages.reading.paths import dotted
from linkages.spec.quantities import (
    Angle,
    Damping,
    Length,
    NonNegativeForce,
    NonNegativeLength,
    NonNegativeTorque,
    PositiveAngularSpeed,
    PositiveSpeed,
    PositiveStiffness,
    PositiveTorsionalStiffness,
    TorsionalDamping,
)

USUAL_RATE = 1e-3
"""Bounces slower than this end in rest (m/s, rad/s), unless `least_rate` is given."""


class _Stop(Attached, ListedComponent):
    """A spring at each end, or a bounce."""

    section: ClassVar[str] = "stops"
    misplaced: ClassVar[Mapping[str, str]] = {
        "friction": "nothing slides along a stop; friction is for a wall: expected one under "
        "'contacts', with 'friction'"
    }

    lower: float | None
    upper: float | None
    stiffness: float | None
    damping: float
    pulls: bool
    adhesion: float
    restitution: float | None
    least_rate: float | None

    def faults(self) -> Iterator[Fault]:
        """At least one end, the upper one above the lower one, and one of two laws."""
        if self.lower is None and self.upper is None:
            yield (), "missing key 'lower' or 'upper': a stop is somewhere"
        elif self.lower is not None and self.upper is not None and self.lower >= self.upper:
            yield "upper", f"expected more than 'lower', {self.lower:g}, found {self.upper:g}"
        if self.restitution is None:
            if self.stiffness is None:
                yield (), "missing key 'stiffness' or 'restitution': a stop pushes or throws back"
            if self.least_rate is not None:
                yield "least_rate", "a stop with 'stiffness' has none; it is for 'restitution'"
            if self.pulls and not self.damping:
                yield "pulls", "without 'damping' a spring that is pressed in does not pull"
            return
        if self.stiffness is not None:
            yield "restitution", "'stiffness' is given as well; expected one of the two"
        if self.damping:
            yield "damping", "a stop with 'restitution' has none; it is for 'stiffness'"
        if self.pulls:
            yield "pulls", "a stop with 'restitution' has none; expected 'adhesion'"
        if self.restitution > 1.0:
            yield "restitution", f"expected at most 1, found {self.restitution:g}"

    def terms(self) -> tuple[Load | End, ...]:
        """A load along the measure, or the ends at which it bounces."""
        if self.restitution is None:
            return (self._load(),) if self.stiffness is not None else ()
        rate = USUAL_RATE if self.least_rate is None else self.least_rate
        law = RigidContact(
            Parameter((*self.path, "restitution"), self.restitution),
            Parameter((*self.path, "least_rate"), rate),
            adhesion=Parameter((*self.path, "adhesion"), self.adhesion) if self.adhesion else None,
        )
        return tuple(
            End(f"{dotted(self.path)}.{key}", self.measure, limit, key == "upper", law, self.path)
            for key in ("lower", "upper")
            if getattr(self, key) is not None
            for limit in [Parameter((*self.path, key), getattr(self, key))]
        )

    def _load(self) -> Load:
        """A spring and a damper at each end, which push back; adhesion is the same at any depth.

        That is the law of Derjaguin, Muller and Toporov [1]_ with a linear spring.
        """
        depths = []
        if self.upper is not None:
            depths.append((X - self.operand("upper"), -1.0))
        if self.lower is not None:
            depths.append((self.operand("lower") - X, 1.0))
        stiffness = self.operand("stiffness")
        pushes, energies = [], []
        for depth, sense in depths:
            push, inside = stiffness * depth, applied("max", depth, 0)
            if self.damping:
                push = push - sense * self.operand("damping") * V
                push = push if self.pulls else applied("max", push, 0)
            if self.adhesion:
                push = push - self.operand("adhesion")
            if self.damping or self.adhesion:
                pushes.append(sense * applied("where", depth, push, 0))
            else:
                pushes.append(sense * stiffness * inside)
            if not self.damping:
                energy = 0.5 * stiffness * inside * inside
                adheres = self.operand("adhesion") * inside if self.adhesion else None
                energies.append(energy if adheres is None else energy - adheres)
        stores = sum_of(energies) if energies else None
        return self.acting(sum_of(pushes), called="stop", stores=stores)


@component
class GuideStop(_Stop, OnSlider):
    """Stops of a slider on its axis.

    Parameters
    ----------
    stiffness
        N/m, > 0.
    lower, upper
        Positions from which a stop pushes back, in metres; one of them may be left out.
    damping
        N·s/m, ≥ 0, while it pushes.
    pulls
        Whether damping pulls as well, where the body leaves the stop faster than its spring.
    adhesion
        Largest force in newtons by which the stop holds the body that touches it, ≥ 0.
    restitution
        In the place of a stiffness: ratio of the rates after and before an impact, from 0 to 1.
    least_rate
        A bounce slower than this ends in rest, in m/s; 0.001 if not given.
    """

    told_by: ClassVar[str] = ""
    opens: ClassVar[Section] = Section("list", "{slider: piston, upper: 0.3, stiffness: 1e6}")

    stiffness: PositiveStiffness | None = None
    lower: Length | None = None
    upper: Length | None = None
    damping: Damping = 0.0
    pulls: bool = False
    adhesion: NonNegativeForce = 0.0
    restitution: Ratio | None = None
    least_rate: PositiveSpeed | None = None


@component
class AngleStop(_Stop, OnBars):
    """Stops of a bar or plate that turns, against the ground or another one.

    Parameters
    ----------
    bars
        Two bars or plates: the angle is that of the second against the first, which may be
        ``ground``; whole turns count.
    stiffness
        N·m/rad, > 0.
    lower, upper
        Angles from which a stop pushes back, in radians; one of them may be left out.
    damping
        N·m·s/rad, ≥ 0, while it pushes.
    pulls
        Whether damping pulls as well, where the bar leaves the stop faster than its spring.
    adhesion
        Largest torque in N·m by which the stop holds the bar that touches it, ≥ 0.
    restitution
        In the place of a stiffness: ratio of the rates after and before an impact, from 0 to 1.
    least_rate
        A bounce slower than this ends in rest, in rad/s; 0.001 if not given.
    """

    stiffness: PositiveTorsionalStiffness | None = None
    lower: Angle | None = None
    upper: Angle | None = None
    damping: TorsionalDamping = 0.0
    pulls: bool = False
    adhesion: NonNegativeTorque = 0.0
    restitution: Ratio | None = None
    least_rate: PositiveAngularSpeed | None = None


@component
class DistanceStop(_Stop, BetweenJoints):
    """Ends of the distance of two joints: a rope that gets taut, a telescope that is pushed in.

    Parameters
    ----------
    stiffness
        N/m, > 0.
    lower, upper
        Distances from which it pushes apart or pulls together, in metres; one may be left out.
    damping
        N·s/m, ≥ 0, while it does so.
    pulls
        Whether damping acts also where the joints return faster than the spring.
    adhesion
        Largest force in newtons by which an end that is reached holds the joints, ≥ 0.
    restitution
        In the place of a stiffness: ratio of the rates after and before an impact, from 0 to 1.
    least_rate
        A bounce slower than this ends in rest, in m/s; 0.001 if not given.
    """

    stiffness: PositiveStiffness | None = None
    lower: NonNegativeLength | None = None
    upper: NonNegativeLength | None = None
    damping: Damping = 0.0
    pulls: bool = False
    adhesion: NonNegativeForce = 0.0
    restitution: Ratio | None = None
    least_rate: PositiveSpeed | None = None
