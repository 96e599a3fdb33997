"""What every load contributes to a model: generalised force, power, potential energy, outputs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Protocol

from linkages.components.contributed.functions import Function
from linkages.components.contributed.measures import Load
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.graph.vectors import Vector
from linkages.kernel.numbers.laws import value_of
from linkages.reading.paths import dotted

if TYPE_CHECKING:
    from linkages.kernel.model import Model

Forces = list[tuple[str | None, str, Vector]]
"""Bodies (None: the ground), their joints, and the forces on them there."""

Torques = list[tuple[str | None, Scalar]]
"""Bodies (None: the ground) and the torques on them."""


class Velocities(Protocol):
    """Velocities, actual or partial."""

    bodies: dict[str, Scalar]
    joints: dict[str, Vector]

    def turning(self, name: str) -> Scalar:
        """Angular speed of a body."""
        ...


class LoadNodes(ABC):
    """A load: what its measure is and does, for whatever law.

    Parameters
    ----------
    model
        Whose nodes these are.
    index
        Place of the load among those of the mechanism: some measures have a number for each.
    """

    sign = 1.0
    """With which the force is an output."""
    undefined = "it has no finite value"
    """Why it may have no value, as the end of a sentence."""

    def __init__(self, model: Model, index: int) -> None:
        self.model = model
        self.graph = model.graph
        self.load: Load = model.mechanism.loads[index]
        self.index = index

    @property
    @abstractmethod
    def displacement(self) -> Scalar:
        """What it is measured by, x."""

    @abstractmethod
    def rate(self, velocities: Velocities) -> Scalar:
        """The rate of x, at velocities that may be partial ones."""

    def forces(self) -> Forces:
        """The load as forces on bodies, as far as it consists of them."""
        return []

    def torques(self) -> Torques:
        """The load as torques on bodies, as far as it consists of them."""
        return []

    def value(self, law: Function) -> Scalar:
        """What a law gives, such as the force or the energy."""
        return value_of(law, self.model.inputs, self.measured)

    def measured(self, order: int) -> Scalar:
        """The displacement, or its actual rate."""
        return self.rate(self.model.velocities) if order else self.displacement

    def _power(self, law: Function, velocities: Velocities) -> Scalar:
        return self.value(law) * self.rate(velocities)

    def _components(self, law: Function) -> list[Scalar]:
        return [self.value(law)]

    @property
    def dimension(self) -> str:
        """Dimension of the output that it belongs to: of given loads, or of springs and dampers."""
        if self.load.given:
            return "torque" if self.load.twists else "force"
        return "torsional_spring" if self.load.twists else "spring"

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
        return self._power(self.load.working, self.model.velocities)
