"""Where frames of bodies are at the start, and how they turn."""

from __future__ import annotations

from collections.abc import Mapping
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
    angles = dict(zip(turning, _values(system, [model.positions.angle(n) for n in turning])))
    angles |= {name: float(np.arctan2(y, x)) for name, (x, y) in system.axes.items()}
    speeds = dict(zip(names, _values(system, [model.velocities.turning(n) for n in names])))
    places = system.places()
    found = {WORLD: GROUND}
    for name, body in mechanism.bodies.items():
        joint, point = next(iter(body.points.items()))
        own = Frame(np.zeros(2), float(angles[name]), float(speeds[name]))
        local = np.array([number.value for number in point])
        found[name] = Frame(places[joint] - own.axes @ local, own.angle, own.speed)
    return found


def slides_of(system: System) -> Mapping[str, float]:
    """Slider → rate of its displacement at the start."""
    bodies = system.mechanism.bodies
    names = [name for name, body in bodies.items() if not body.rotates]
    rates = [system.model.velocities.moving(name) for name in names]
    return dict(zip(names, map(float, _values(system, rates)), strict=True))


def _values(system: System, nodes: list[Scalar]) -> Floats:
    return system.evaluate(nodes)[:, 0] if nodes else np.zeros(0)
