"""Bodies with three free coordinates each: where their points are and how they move.

A vector of coordinates holds x, y (origin of the frame) and θ of every body in turn.
"""

from dataclasses import dataclass

import numpy as np

from linkages.components.mechanisms.mechanism import Mechanism

GROUND = "ground"


@dataclass(frozen=True)
class Point:
    """A material point of a body, or of the ground (body None)."""

    body: str | None
    local: np.ndarray


def pair(place) -> np.ndarray:
    """Two parameters as an array."""
    return np.array([place[0].value, place[1].value])


def turned(angle: float, vector: np.ndarray) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])


class Layout:
    """Names → places in the vector of coordinates, and points by joint."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.bodies = mechanism.bodies
        self.start = {name: 3 * index for index, name in enumerate(self.bodies)}
        self.size = 3 * len(self.bodies)
        self.points: dict[str, list[Point]] = {
            joint: [Point(None, pair(place))] for joint, place in mechanism.ground.items()
        }
        for name, body in self.bodies.items():
            for joint, place in body.points.items():
                self.points.setdefault(joint, []).append(Point(name, pair(place)))

    def carrier(self, joint: str) -> Point:
        """The point that loads and masses at a joint belong to: the ground's, or the first body's.

        It matters to the reaction there, and to nothing else.
        """
        return self.points[joint][0]


class State:
    """Coordinates and their rates at a time."""

    def __init__(self, layout: Layout, time: float, places: np.ndarray, rates: np.ndarray) -> None:
        self.layout, self.time, self.places, self.rates = layout, time, places, rates

    def angle(self, body: str | None) -> float:
        return 0.0 if body is None else self.places[self.layout.start[body] + 2]

    def speed(self, body: str | None) -> float:
        return 0.0 if body is None else self.rates[self.layout.start[body] + 2]

    def arm(self, point: Point) -> np.ndarray:
        """From the origin of the body's frame to the point."""
        return turned(self.angle(point.body), point.local)

    def place(self, point: Point) -> np.ndarray:
        if point.body is None:
            return point.local
        start = self.layout.start[point.body]
        return self.places[start : start + 2] + self.arm(point)

    def jacobian(self, point: Point) -> np.ndarray:
        """∂place/∂coordinates, shape (2, coordinates)."""
        result = np.zeros((2, self.layout.size))
        if point.body is not None:
            start = self.layout.start[point.body]
            x, y = self.arm(point)
            result[:, start : start + 3] = [[1, 0, -y], [0, 1, x]]
        return result

    def velocity(self, point: Point) -> np.ndarray:
        return self.jacobian(point) @ self.rates

    def bias(self, point: Point) -> np.ndarray:
        """Acceleration where those of all coordinates are zero: towards the frame's origin."""
        return -(self.speed(point.body) ** 2) * self.arm(point)
