"""What every load contributes to a model: generalised force, power, potential energy, outputs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar, Protocol

from linkages.components.terms import Load, Torque, TorsionSpring
from linkages.kernel.scalars import Scalar
from linkages.kernel.vectors import Vector
from linkages.reading.paths import dotted

if TYPE_CHECKING:
    from linkages.kernel.model import Model


class Velocities(Protocol):
    """Velocities, actual or partial."""

    bodies: dict[str, Scalar]
    joints: dict[str, Vector]

    def turning(self, name: str) -> Scalar:
        """Angular speed of a body."""
        ...


class LoadNodes(ABC):
    """What a load contributes to the equations of a model."""

    load: Load
    dimension: ClassVar[str]
    """Dimension of the output that it belongs to."""

    @property
    def labels(self) -> tuple[str, ...]:
        """What its forces are called in outputs: the place of the load in the file."""
        return (dotted(self.load.path),)

    @property
    @abstractmethod
    def acting(self) -> list[Scalar]:
        """Force or torque as it acts, one for each label."""

    @property
    @abstractmethod
    def given(self) -> list[Scalar]:
        """What of it follows from time and positions: not finite where the load has no value."""

    @property
    def undefined(self) -> str:
        """Why it may have no value, as the end of a sentence."""
        return "it has no finite value"

    @abstractmethod
    def power(self, velocities: Velocities) -> Scalar:
        """Power of the load at some velocities: its generalised force if they are partial ones."""

    def potential(self) -> Scalar | None:
        """Energy that it stores; None for a load that stores none."""
        return None

    def dissipated(self) -> Scalar | None:
        """Power of what it does not store, at the actual velocities; None if it stores all."""
        return None


class Conjugate(LoadNodes):
    """A scalar force that works on one rate."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.graph = model.graph

    @property
    @abstractmethod
    def force(self) -> Scalar:
        """The force, positive in the direction of the rate."""

    @property
    def acting(self) -> list[Scalar]:
        """The force."""
        return [self.force]

    @abstractmethod
    def rate(self, velocities: Velocities) -> Scalar:
        """What it works on."""

    def power(self, velocities: Velocities) -> Scalar:
        """Force times rate."""
        return self.force * self.rate(velocities)

    def dissipated(self) -> Scalar | None:
        """All of its power."""
        return self.power(self.model.velocities)


class Pull(LoadNodes):
    """A force in the plane."""

    @property
    @abstractmethod
    def vector(self) -> Vector:
        """The force, on the joint or on the second of two."""


class Turning(Conjugate):
    """A torque that turns one body against another."""

    load: Torque | TorsionSpring

    def __init__(self, model: Model, load: Torque | TorsionSpring) -> None:
        super().__init__(model)
        self.load = load

    def rate(self, velocities: Velocities) -> Scalar:
        """Angular speed of the body against the other one."""
        rate = velocities.turning(self.load.body)
        if self.load.reference is None:
            return rate
        return rate - velocities.turning(self.load.reference)
