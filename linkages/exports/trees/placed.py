"""Where frames of bodies are at the start, and how they turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.exports.trees.tree import WORLD
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.system import System

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Frame:
    """The frame of a body at the start.

    Parameters
    ----------
    origin
        In the ground's frame, shape (2,).
    angle
        Of its first axis.
    speed
        At which it turns.
    """

    origin: Floats
    angle: float
    speed: float

    @property
    def axes(self) -> Floats:
        """Its axes as columns, shape (2, 2)."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        return np.array([[c, -s], [s, c]])

    def local(self, place: Floats) -> Floats:
        """A place of the ground's frame in this one, shape (2,)."""
        return np.asarray(self.axes.T @ (place - self.origin))


GROUND = Frame(np.zeros(2), 0.0, 0.0)


def frames_of(system: System) -> dict[str, Frame]:
    """Body, the ground among them → its frame."""
    model, mechanism = system.model, system.mechanism
    names = list(mechanism.bodies)
    turning = [name for name in names if mechanism.bodies[name].rotates]
    angles = _values(system, {name: model.positions.angle(name) for name in turning})
    angles |= {name: float(np.arctan2(y, x)) for name, (x, y) in system.axes.items()}
    speeds = _values(system, {name: model.velocities.turning(name) for name in names})
    places = system.places()
    found = {WORLD: GROUND}
    for name, body in mechanism.bodies.items():
        joint, point = next(iter(body.points.items()))
        own = Frame(np.zeros(2), angles[name], speeds[name])
        local = np.array([number.value for number in point])
        found[name] = Frame(places[joint] - own.axes @ local, own.angle, own.speed)
    return found


def slides_of(system: System) -> dict[str, float]:
    """Slider → rate of its displacement at the start."""
    bodies = system.mechanism.bodies
    sliders = [name for name, body in bodies.items() if not body.rotates]
    return _values(system, {name: system.model.velocities.moving(name) for name in sliders})


def _values(system: System, nodes: dict[str, Scalar]) -> dict[str, float]:
    """Values at the start."""
    values = system.evaluate([*nodes.values()])[:, 0]
    return dict(zip(nodes, map(float, values), strict=True))
