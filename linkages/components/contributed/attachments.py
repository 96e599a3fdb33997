"""What a load acts along: the keys of an entry that say so, its names, and its measure.

A component of a load is a law with an attachment: ``class GuideSpring(_Spring, OnSlider)``. The law
asks `acting` for the load along whatever it is attached to.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from typing import Any, ClassVar

from linkages.components.contributed.component import (
    Component,
    References,
    component,
    reference,
)
from linkages.components.contributed.functions import Function
from linkages.components.contributed.load_measures import (
    ClearanceFriction,
    Distance,
    Friction,
    JointFriction,
    Load,
    Measure,
    Slide,
    Turn,
)
from linkages.reading.paths import KeyPath
from linkages.spec.quantities import (
    BarName,
    BarPair,
    ClearanceName,
    JointName,
    SliderName,
)


class Attachment(Component):
    """Says what a law acts along."""

    @abstractmethod
    def acting(self, law: Function, **more: Any) -> Load | Friction:
        """The term of a law; `more` are further fields of it, such as `called`."""


class Attached(Attachment):
    """Acts along a measure."""

    @property
    @abstractmethod
    def measure(self) -> Measure:
        """What it acts along."""

    def acting(self, law: Function, **more: Any) -> Load:
        """The load of a law."""
        return Load(self.measure, law, self.path, **more)


@component
class BetweenJoints(Attached):
    """Acts along the line through two joints.

    Parameters
    ----------
    between
        Two joints; one may be fixed to the ground.
    """

    told_by: ClassVar[str] = "between"

    between: tuple[JointName, JointName]

    @property
    def measure(self) -> Distance:
        """Their distance."""
        return Distance(*self.between)


def ends(path: KeyPath, joints: tuple[str, ...]) -> tuple[tuple[KeyPath, str], ...]:
    """References to the joints of a list at a path."""
    return tuple(((*path, place), joint) for place, joint in enumerate(joints))


def two_joints(path: KeyPath, joints: tuple[str, str]) -> tuple[tuple[KeyPath, str], ...]:
    """What is wrong with a pair of joints."""
    if joints[0] == joints[1]:
        return ((path, f"expected two different joints, found {joints[0]!r} twice"),)
    return ()


@component
class OnSlider(Attached):
    """Acts along the axis of a slider; what carries the axis gets the opposite force.

    Parameters
    ----------
    slider
        Slider name.
    """

    told_by: ClassVar[str] = "slider"

    slider: SliderName

    @property
    def measure(self) -> Slide:
        """Its displacement."""
        return Slide(self.slider)


@component
class OnBar(Attached):
    """Turns a bar or plate against the ground.

    Parameters
    ----------
    bar
        The bar or plate.
    """

    told_by: ClassVar[str] = "bar"

    bar: BarName

    @property
    def measure(self) -> Turn:
        """Its angle."""
        return Turn(self.bar, None)


class _OnPair(Attached):
    """Turns the second of two bodies against the first, which may be ``ground``."""

    key: ClassVar[str]

    @property
    def measure(self) -> Turn:
        """The angle of the second against the first."""
        bodies = getattr(self, self.key)
        return Turn(bodies[1], reference(bodies))


@component
class BetweenBars(_OnPair):
    """Turns two bodies against each other, wherever they are.

    Parameters
    ----------
    between_bars
        Two bars or plates; the first may be ``ground``.
    """

    told_by: ClassVar[str] = "between_bars"
    key: ClassVar[str] = "between_bars"

    between_bars: BarPair


@component
class OnBars(_OnPair):
    """Turns two bodies against each other, wherever they are.

    Parameters
    ----------
    bars
        Two bars or plates; the first may be ``ground``.
    """

    told_by: ClassVar[str] = "bars"
    key: ClassVar[str] = "bars"

    bars: BarPair


@component
class AtJoint(Attachment):
    """Turns two bodies against each other that meet at a joint.

    Parameters
    ----------
    joint
        A joint at which two bodies turn against each other, or one against the ground.
    bars
        Which two, where more meet; the first may be ``ground``.
    """

    told_by: ClassVar[str] = "joint"

    joint: JointName
    bars: BarPair | None = None

    def references(self) -> References:
        """The joint, and the bodies that have it."""
        named = enumerate(self.bars or ())
        meeting = tuple(((*self.path, "bars", place), bar, self.joint) for place, bar in named)
        return replace(super().references(), meeting=meeting)

    def acting(self, law: Function, **more: Any) -> JointFriction:
        """Friction between bodies that only the whole mechanism knows."""
        return JointFriction(self.joint, self.bars, law, self.path, **more)


@component
class InClearance(Attachment):
    """Turns the link of a clearance with the bar that it displaces.

    Parameters
    ----------
    clearance
        Clearance name.
    """

    told_by: ClassVar[str] = "clearance"

    clearance: ClearanceName

    def acting(self, law: Function, **more: Any) -> ClearanceFriction:
        """Friction against a bar that the clearance knows."""
        return ClearanceFriction(self.clearance, law, self.path, **more)
