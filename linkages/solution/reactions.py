"""Joint reactions from Newton's and Euler's equations of every body.

The accelerations are known, so the forces at all pins, the forces of the guides and the efforts
of the drives follow from one linear system per sample. It shares no formula with the reduced
equations of the kernel; the driving efforts come out again, as a check.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.components.revolute import GROUND
from linkages.components.terms import Body
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.solution.evaluation import evaluate_variables
from linkages.solution.motion import Motion
from linkages.topology.graph import pairs

_CHUNK = 1024


def joint_reactions(system: System, motion: Motion) -> NDArray[np.float64]:
    """Force that the first body at each joint exerts on the others, in newtons.

    Parameters
    ----------
    system, motion
        What moves, and how.

    Returns
    -------
    Shape (samples, joints, 2). The ground comes first at a ground joint, otherwise bodies in the
    order of the mechanism. At a free end the force is zero.
    """
    parts = [
        _Statics(system, _part(motion, slice(start, start + _CHUNK))).reactions()
        for start in range(0, len(motion.time), _CHUNK)
    ]
    joints = len(system.topology.joints)
    return np.concatenate(parts) if parts else np.zeros((0, joints, 2))


def _part(motion: Motion, part: slice) -> Motion:
    from dataclasses import replace

    return replace(
        motion,
        time=motion.time[part],
        state=motion.state[:, part],
        turns=motion.turns[:, part],
        acceleration=motion.acceleration[:, part],
    )


class _Statics:
    """The linear system of forces at some samples."""

    def __init__(self, system: System, motion: Motion) -> None:
        self._system = system
        self._topology = system.topology
        names = ["joint_position", "joint_acceleration", *_angular(system)]
        self._values = evaluate_variables(system, motion, names)
        self._samples = len(motion.time)
        self._pairs = pairs(system.mechanism)
        self._bodies = list(system.mechanism.bodies.values())
        self._joint = {joint: index for index, joint in enumerate(system.topology.joints)}
        self._row: dict[str, int] = {}
        rows = 0
        for body in self._bodies:
            self._row[body.name] = rows
            rows += 3 if body.rotates else 2
        self._rows = rows

    def reactions(self) -> NDArray[np.float64]:
        """Solve, and add the pairs of each joint."""
        columns = 2 * len(self._pairs)
        sliders = [body for body in self._bodies if not body.rotates]
        known = (*self._topology.driven, *self._topology.free)
        matrix = np.zeros((self._samples, self._rows, columns + len(sliders) + len(known)))
        for index, pair in enumerate(self._pairs):
            self._add_pair(matrix, 2 * index, pair.joint, pair.second, 1.0)
            if pair.first != GROUND:
                self._add_pair(matrix, 2 * index, pair.joint, pair.first, -1.0)
        for index, slider in enumerate(sliders):
            x, y = self._system.axes[slider.name]
            row = self._row[slider.name]
            matrix[:, row : row + 2, columns + index] = [-y, x]
        for index, name in enumerate(known):
            # free coordinates get an effort as well: it comes out as zero
            self._add_effort(matrix, columns + len(sliders) + index, name)
        forces = np.linalg.solve(matrix, self._inertia()[..., None])[..., 0]
        result = np.zeros((self._samples, len(self._joint), 2))
        for index, pair in enumerate(self._pairs):
            result[:, self._joint[pair.joint]] += forces[:, 2 * index : 2 * index + 2]
        return result

    def _add_pair(
        self, matrix: NDArray[np.float64], column: int, joint: str, body: str, sign: float
    ) -> None:
        row = self._row[body]
        matrix[:, row, column] += sign
        matrix[:, row + 1, column + 1] += sign
        if self._system.mechanism.bodies[body].rotates:
            arm = self._places(joint) - self._reference(body)
            matrix[:, row + 2, column] -= sign * arm[:, 1]
            matrix[:, row + 2, column + 1] += sign * arm[:, 0]

    def _add_effort(self, matrix: NDArray[np.float64], column: int, name: str) -> None:
        row = self._row[name]
        if self._system.mechanism.bodies[name].rotates:
            matrix[:, row + 2, column] = 1.0
        else:
            matrix[:, row : row + 2, column] = self._system.axes[name]

    def _places(self, joint: str) -> NDArray[np.float64]:
        return self._values["joint_position"][:, self._joint[joint]]

    def _accelerations(self, joint: str) -> NDArray[np.float64]:
        return self._values["joint_acceleration"][:, self._joint[joint]]

    def _reference(self, body: str) -> NDArray[np.float64]:
        """The point that moments of a body are taken about: its first one."""
        return self._places(next(iter(self._system.mechanism.bodies[body].points)))

    def _inertia(self) -> NDArray[np.float64]:
        """Mass times acceleration less weight and loads, and rates of angular momentum."""
        right = np.zeros((self._samples, self._rows))
        gravity = self._system.mechanism.gravity
        g = np.array([gravity.x.value, gravity.y.value])
        for body in self._bodies:
            row = self._row[body.name]
            first = next(iter(body.points))
            if body.rotates:
                arm, acceleration = self._centre(body, first)
                force = body.mass.value * (acceleration - g)
                spin = body.inertia.value * self._angular(body)
                right[:, row + 2] = arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0] + spin
            else:
                force = body.mass.value * (self._accelerations(first) - g)
            right[:, row : row + 2] = force
        for load in self._system.mechanism.forces:
            row = self._row[load.body]
            right[:, row : row + 2] -= load.force.value * self._system.axes[load.body]
        return right

    def _centre(self, body: Body, first: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Centre of mass relative to the first point, and its acceleration."""
        if len(body.points) == 1:
            zero = np.zeros((self._samples, 2))
            return zero, self._accelerations(first)
        second = list(body.points)[1]
        base = _plane(body.points[second]) - _plane(body.points[first])
        ratio = (_plane(body.centre) - _plane(body.points[first])) / base
        arm = _turned(self._places(second) - self._places(first), ratio)
        relative = _turned(self._accelerations(second) - self._accelerations(first), ratio)
        return arm, self._accelerations(first) + relative

    def _angular(self, body: Body) -> NDArray[np.float64]:
        if body.kind == "clearance":
            return np.zeros(self._samples)
        bars = [b.name for b in self._bodies if b.kind in ("bar", "plate")]
        return self._values["bar_acceleration"][:, bars.index(body.name)]


def _angular(system: System) -> list[str]:
    return ["bar_acceleration"] if VARIABLES["bar_acceleration"].nodes(system.model) else []


def _plane(pair: tuple) -> complex:
    return complex(pair[0].value, pair[1].value)


def _turned(vectors: NDArray[np.float64], ratio: complex) -> NDArray[np.float64]:
    """Vectors times a complex number, shape (samples, 2)."""
    product = (vectors[:, 0] + 1j * vectors[:, 1]) * ratio
    return np.stack([product.real, product.imag], axis=1)
