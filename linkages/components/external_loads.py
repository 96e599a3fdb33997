"""External forces and torques."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import (
    TURNING,
    ListedComponent,
    References,
    component,
    reference,
    turning,
    two_bodies,
)
from linkages.components.contributed.load_measures import (
    BodyAxis,
    Coordinate,
    Distance,
    Load,
    Slide,
    Turn,
)
from linkages.components.laws import ForceLaw, TorqueLaw, function_of
from linkages.components.springs import ends, two_joints
from linkages.reading.paths import KeyPath
from linkages.spec.quantities import Name


@component
class SliderForce(ListedComponent):
    """A force on a slider along its axis.

    Parameters
    ----------
    index
        Place in the list of loads.
    slider
        Slider name.
    force
        Newtons, positive along the axis, or a law. What carries the axis gets the
        opposite force.
    """

    section: ClassVar[str] = "loads"

    index: int
    slider: Name
    force: ForceLaw

    def references(self) -> References:
        """The slider."""
        return References(bodies=(((*self.path, "slider"), self.slider, ("slider",)),))

    def terms(self) -> tuple[Load, ...]:
        """One force."""
        force = function_of(self.force, (*self.path, "force"))
        return (Load(Slide(self.slider), force, self.path, applied=True),)


@component
class FollowerForce(ListedComponent):
    """A force at a joint whose components turn with a body.

    Parameters
    ----------
    index
        Place in the list of loads.
    joint
        A joint that moves, of this body or another one.
    on
        The bar, plate or slider whose frame the force is given in.
    force
        Two numbers in newtons, along the body's own axis and across it, or laws.
    """

    section: ClassVar[str] = "loads"
    told_by: ClassVar[str] = "on"

    index: int
    joint: Name
    on: Name
    force: tuple[ForceLaw, ForceLaw]

    def references(self) -> References:
        """The joint and the body."""
        return References(
            moving=(((*self.path, "joint"), self.joint),),
            bodies=(((*self.path, "on"), self.on, ("bar", "plate", "slider")),),
        )

    def terms(self) -> tuple[Load, ...]:
        """One force along each axis of the body."""
        return tuple(
            Load(
                BodyAxis(self.joint, self.on, axis),
                function_of(law, (*self.path, "force", axis)),
                self.path,
                applied=True,
            )
            for axis, law in enumerate(self.force)
        )


@component
class ForceBetweenJoints(ListedComponent):
    """A force between two joints, along the line through them.

    Parameters
    ----------
    index
        Place in the list of loads.
    between
        Two joints; one may be fixed to the ground.
    force
        Newtons, positive where it pushes them apart, or a law.
    """

    section: ClassVar[str] = "loads"
    told_by: ClassVar[str] = "between"

    index: int
    between: tuple[Name, Name]
    force: ForceLaw

    def problems(self) -> tuple[tuple[KeyPath, str], ...]:
        """Two different joints."""
        return two_joints((*self.path, "between"), self.between)

    def references(self) -> References:
        """The joints."""
        return References(joints=ends((*self.path, "between"), self.between))

    def terms(self) -> tuple[Load, ...]:
        """One force."""
        force = function_of(self.force, (*self.path, "force"))
        return (Load(Distance(*self.between), force, self.path, applied=True),)


@component
class JointForce(ListedComponent):
    """A force at a joint with given components along x and y.

    Parameters
    ----------
    index
        Place in the list of loads.
    joint
        A joint that moves.
    force
        Two numbers in newtons, or laws.
    """

    section: ClassVar[str] = "loads"
    told_by: ClassVar[str] = "joint"

    index: int
    joint: Name
    force: tuple[ForceLaw, ForceLaw]

    def references(self) -> References:
        """The joint."""
        return References(moving=(((*self.path, "joint"), self.joint),))

    def terms(self) -> tuple[Load, ...]:
        """One force along each axis."""
        return tuple(
            Load(
                Coordinate(self.joint, axis),
                function_of(law, (*self.path, "force", axis)),
                self.path,
                applied=True,
            )
            for axis, law in enumerate(self.force)
        )


@component
class BarTorque(ListedComponent):
    """A torque of the ground on a bar or plate.

    Parameters
    ----------
    index
        Place in the list of loads.
    bar
        The bar or plate.
    torque
        Newton metres, counter-clockwise positive, or a law.
    """

    section: ClassVar[str] = "loads"
    told_by: ClassVar[str] = "bar"

    index: int
    bar: Name
    torque: TorqueLaw

    def references(self) -> References:
        """The bar."""
        return References(bodies=(((*self.path, "bar"), self.bar, TURNING),))

    def terms(self) -> tuple[Load, ...]:
        """One torque."""
        torque = function_of(self.torque, (*self.path, "torque"))
        return (Load(Turn(self.bar, None), torque, self.path, applied=True),)


@component
class TorqueBetweenBars(ListedComponent):
    """A torque of one body on another.

    Parameters
    ----------
    index
        Place in the list of loads.
    bars
        Two bars or plates: the torque acts on the second, the opposite one on the first. The
        first may be ``ground``.
    torque
        Newton metres, counter-clockwise positive, or a law.
    """

    section: ClassVar[str] = "loads"
    told_by: ClassVar[str] = "bars"

    index: int
    bars: tuple[Name, Name]
    torque: TorqueLaw

    def problems(self) -> tuple[tuple[KeyPath, str], ...]:
        """Two different bodies."""
        return two_bodies((*self.path, "bars"), self.bars)

    def references(self) -> References:
        """The bodies."""
        return References(bodies=turning((*self.path, "bars"), self.bars))

    def terms(self) -> tuple[Load, ...]:
        """One torque and its reaction."""
        torque = function_of(self.torque, (*self.path, "torque"))
        return (Load(Turn(self.bars[1], reference(self.bars)), torque, self.path, applied=True),)
