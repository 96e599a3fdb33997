"""External forces and torques."""

from __future__ import annotations

from collections.abc import Iterable
from typing import ClassVar

from linkages.components.contributed.attachments import (
    Attached,
    BetweenJoints,
    OnBar,
    OnBars,
    OnSlider,
)
from linkages.components.contributed.component import ListedComponent, component
from linkages.components.contributed.load_measures import BodyAxis, Coordinate, Load, Measure
from linkages.components.laws import ForceLaw, Law, TorqueLaw, function_of
from linkages.spec.quantities import BodyName, MovingJointName


class _Given(Attached, ListedComponent):
    """A force or torque from outside."""

    section: ClassVar[str] = "loads"
    size: ClassVar[str]

    def terms(self) -> tuple[Load, ...]:
        """One force or torque, and its reaction."""
        law = function_of(getattr(self, self.size), (*self.path, self.size))
        return (self.acting(law, applied=True),)


class _JointLoad(ListedComponent):
    """A force at a joint, given by two components."""

    section: ClassVar[str] = "loads"

    def _along(self, force: tuple[Law, Law], measures: Iterable[Measure]) -> tuple[Load, ...]:
        laws = [function_of(law, (*self.path, "force", axis)) for axis, law in enumerate(force)]
        pairs = zip(measures, laws, strict=True)
        return tuple(Load(measure, law, self.path, applied=True) for measure, law in pairs)


@component
class SliderForce(_Given, OnSlider):
    """A force on a slider along its axis.

    Parameters
    ----------
    force
        Newtons, positive along the axis, or a law. What carries the axis gets the
        opposite force.
    """

    told_by: ClassVar[str] = ""
    size: ClassVar[str] = "force"

    force: ForceLaw


@component
class FollowerForce(_JointLoad):
    """A force at a joint whose components turn with a body.

    Parameters
    ----------
    joint
        A joint that moves, of this body or another one.
    on
        The bar, plate or slider whose frame the force is given in.
    force
        Two numbers in newtons, along the body's own axis and across it, or laws.
    """

    told_by: ClassVar[str] = "on"

    joint: MovingJointName
    on: BodyName
    force: tuple[ForceLaw, ForceLaw]

    def terms(self) -> tuple[Load, ...]:
        """One force along each axis of the body."""
        return self._along(self.force, (BodyAxis(self.joint, self.on, axis) for axis in (0, 1)))


@component
class ForceBetweenJoints(_Given, BetweenJoints):
    """A force between two joints, along the line through them.

    Parameters
    ----------
    force
        Newtons, positive where it pushes them apart, or a law.
    """

    size: ClassVar[str] = "force"

    force: ForceLaw


@component
class JointForce(_JointLoad):
    """A force at a joint with given components along x and y.

    Parameters
    ----------
    joint
        A joint that moves.
    force
        Two numbers in newtons, or laws.
    """

    told_by: ClassVar[str] = "joint"

    joint: MovingJointName
    force: tuple[ForceLaw, ForceLaw]

    def terms(self) -> tuple[Load, ...]:
        """One force along each axis."""
        return self._along(self.force, (Coordinate(self.joint, axis) for axis in (0, 1)))


@component
class BarTorque(_Given, OnBar):
    """A torque of the ground on a bar or plate.

    Parameters
    ----------
    torque
        Newton metres, counter-clockwise positive, or a law.
    """

    size: ClassVar[str] = "torque"

    torque: TorqueLaw


@component
class TorqueBetweenBars(_Given, OnBars):
    """A torque of one body on another.

    Parameters
    ----------
    bars
        Two bars or plates: the torque acts on the second, the opposite one on the first. The
        first may be ``ground``.
    torque
        Newton metres, counter-clockwise positive, or a law.
    """

    size: ClassVar[str] = "torque"

    torque: TorqueLaw
