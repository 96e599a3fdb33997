"""Plane vectors of scalar nodes."""

from __future__ import annotations

from dataclasses import dataclass

from linkages.kernel.graph.scalars import Scalar


@dataclass(frozen=True)
class Vector:
    """A vector in the plane."""

    x: Scalar
    y: Scalar

    def __add__(self, other: Vector) -> Vector:
        return Vector(self.x + other.x, self.y + other.y)

    def __sub__(self, other: Vector) -> Vector:
        return Vector(self.x - other.x, self.y - other.y)

    def __neg__(self) -> Vector:
        return Vector(-self.x, -self.y)

    def __mul__(self, factor: Scalar | float) -> Vector:
        return Vector(self.x * factor, self.y * factor)

    def dot(self, other: Vector) -> Scalar:
        """Scalar product."""
        return self.x * other.x + self.y * other.y

    def cross(self, other: Vector) -> Scalar:
        """The third component of the vector product."""
        return self.x * other.y - self.y * other.x

    @property
    def turned(self) -> Vector:
        """The vector turned by +90°."""
        return Vector(-self.y, self.x)

    @property
    def square(self) -> Scalar:
        """Squared length."""
        return self.dot(self)

    def times(self, other: Vector) -> Vector:
        """Product as complex numbers: turned by the angle of `other`, stretched by its length."""
        return Vector(
            self.x * other.x - self.y * other.y,
            self.y * other.x + self.x * other.y,
        )

    def label(self, name: str) -> Vector:
        """Name both components in the printed kernel."""
        for node, suffix in ((self.x, "x"), (self.y, "y")):
            if node.label is None and node.operands:
                node.label = f"{name}{suffix}"
        return self
