"""What every load contributes to a model: generalised force, power, potential energy, outputs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Protocol

from linkages.components.contributed.functions import (
    PRESSED,
    Function,
    Internal,
    Measured,
)
from linkages.components.contributed.measures import Load
from linkages.components.contributed.sensing import written
from linkages.components.contributed.state_laws import everywhere, internal, measured_in, rated
from linkages.kernel.graph.differentiation import derivative_along
from linkages.kernel.graph.scalars import Level, Scalar
from linkages.kernel.graph.vectors import Vector
from linkages.kernel.numbers.laws import value_of
from linkages.reading.paths import dotted

if TYPE_CHECKING:
    from linkages.kernel.model import Model

Forces = list[tuple[str | None, str, Vector]]
"""Bodies (None: the ground), their joints, and the forces on them there."""

Torques = list[tuple[str | None, Scalar]]
"""Bodies (None: the ground) and the torques on them."""


JAMMED = (
    "it jams: the force that presses grows with the friction by as much, so that none or two go "
    "with the motion (self-locking, Painlevé's paradox); expected a smaller coefficient or radius"
)


class Velocities(Protocol):
    """Velocities, actual or partial."""

    joints: dict[str, Vector]

    def turning(self, name: str) -> Scalar:
        """Angular speed of a body."""
        ...

    def moving(self, name: str) -> Scalar:
        """Rate of a body's own coordinate."""
        ...


class Acting(ABC):
    """What acts on a mechanism, whatever it is: its power, its forces, what it stores."""

    @abstractmethod
    def power(self, velocities: Velocities) -> Scalar:
        """Power at some velocities: its generalised force if they are partial ones."""

    @property
    @abstractmethod
    def potential(self) -> Scalar:
        """Energy that it stores."""

    @property
    @abstractmethod
    def working(self) -> Scalar:
        """Power of what it does not store, at the actual velocities."""

    @abstractmethod
    def forces(self) -> Forces:
        """It as forces on bodies, as far as it consists of them."""

    @abstractmethod
    def torques(self) -> Torques:
        """It as torques on bodies, as far as it consists of them."""


class LoadNodes(Acting):
    """A load: what its measure is and does, for whatever law.

    Parameters
    ----------
    model
        Whose nodes these are.
    load
        What acts; nothing along a measure that other loads sense.
    index
        Its place, as `linkages.kernel.numbers.parameters.wound_angles` counts.
    """

    undefined = "it has no finite value"
    """Why it may have no value, as the end of a sentence."""

    def __init__(self, model: Model, load: Load, index: int) -> None:
        self.model = model
        if load.bearing is not None:
            self.undefined = JAMMED
        self.graph = model.graph
        self.load = load
        self.index = index
        self.given_force: Scalar | None = None

    @property
    @abstractmethod
    def displacement(self) -> Scalar:
        """What it is measured by, x."""

    @abstractmethod
    def rate(self, velocities: Velocities) -> Scalar:
        """The rate of x, at velocities that may be partial ones."""

    @property
    def pushed(self) -> Scalar:
        """The force along the measure: that of the law, unless another one is given."""
        return self.value(self.load.force) if self.given_force is None else self.given_force

    def forces(self) -> Forces:
        """The load as forces on bodies, as far as it consists of them."""
        return []

    def torques(self) -> Torques:
        """The load as torques on bodies, as far as it consists of them."""
        return []

    def value(self, law: Function) -> Scalar:
        """What a law gives, such as the force or the energy."""
        return value_of(law, self.model.inputs, self.sensed, self.mode)

    def mode(self, part: Function, node: Scalar) -> Scalar:
        """On which side of zero the motion is of what makes a part of the law jump or turn."""
        name = f"{dotted(self.load.path)}: {written(part, self.load.measure)}"
        return self.model.switches.side(name, node)

    def sensed(self, found: Measured | Internal) -> Scalar:
        """The value or rate of a measure, its own or another one, or an internal state."""
        if isinstance(found, Measured) and found.measure is None:
            return self.measured(found.order)
        return self.model.sense(found)

    def measured(self, order: int) -> Scalar:
        """The displacement, its actual rate, or the force that presses surfaces together (3)."""
        if order == PRESSED.order:
            return self.model.pressing[self.index]
        return self.rate(self.model.velocities) if order else self.displacement

    def _power(self, law: Function, velocities: Velocities) -> Scalar:
        return self.value(law) * self.rate(velocities)

    def _components(self, law: Function) -> list[Scalar]:
        return [self.value(law)]

    @property
    def internal_rates(self) -> list[Scalar]:
        """Rates of its internal states."""
        return [self.value(state.rate) for state in self.load.states]

    @property
    def changing(self) -> bool:
        """Whether its displacement depends on more than time."""
        return self.displacement.level is Level.STATE

    @property
    def dimension(self) -> str:
        """Dimension of the output that it belongs to: of given loads, or of springs and dampers."""
        if self.load.passive:
            return "torsional_spring" if self.load.twists else "spring"
        return "torque" if self.load.twists else "force"

    @property
    def sign(self) -> float:
        """With which the force is an output."""
        return 1.0

    @property
    def label(self) -> str:
        """What it is called in outputs: its place in the file."""
        return dotted(self.load.path)

    @property
    def acting(self) -> Scalar:
        """Force or torque as outputs show it."""
        return self.sign * self.value(self.load.force)

    @property
    def given(self) -> list[Scalar]:
        """What of it follows from time and positions: not finite where the load has no value."""
        return self._components(self.load.still)

    @property
    def doubtful(self) -> list[Scalar]:
        """Its force, then what it depends on, if it may have no value where all of that has one."""
        force = self.load.force
        if (everywhere(force) and self.load.bearing is None) or not rated(force):
            return []
        known = dict.fromkeys(leaf for leaf in measured_in(force) if leaf != PRESSED)
        return [self.value(force), *map(self.sensed, known)]

    def power(self, velocities: Velocities) -> Scalar:
        """Power of the load at some velocities: its generalised force if they are partial ones."""
        return self._power(self.load.force, velocities)

    @property
    def potential(self) -> Scalar:
        """Energy that it stores."""
        return self.value(self.load.energy)

    @property
    def working(self) -> Scalar:
        """Power of what it does not store, at the actual velocities."""
        power = self._power(self.load.working, self.model.velocities)
        if not internal(self.load.energy):
            return power
        rates = self.model.changes[len(self.model.topology.free) :]
        pairs = zip(self.model.internal, rates, strict=True)
        direction = {value.index: rate for value, rate in pairs}
        ((storing,),) = derivative_along([self.potential], [direction])
        return power + storing
