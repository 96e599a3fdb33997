"""Masses, weights and loads in absolute coordinates."""

import numpy as np
from absolute_bodies import Layout, Point, State, pair
from absolute_measures import along_axis, angles, gap
from time_functions import jet

from linkages.components.mechanism import Mechanism
from linkages.components.terms import (
    AxialDamper,
    AxialForce,
    Load,
    PointForce,
    Spring,
    Torque,
    TorsionSpring,
)


def heavy_points(mechanism: Mechanism, layout: Layout) -> list[tuple[Point, float]]:
    """Centres of mass of the bodies and masses at joints."""
    found = [
        (Point(name, pair(body.centre)), body.mass.value) for name, body in mechanism.bodies.items()
    ]
    found += [(layout.carrier(t.joint), t.mass.value) for t in mechanism.point_masses]
    return [(point, mass) for point, mass in found if mass > 0]


def inertia(mechanism: Mechanism, state: State) -> tuple[np.ndarray, np.ndarray]:
    """Mass matrix M, and h in M q̈ + h = forces."""
    layout = state.layout
    matrix, bias = np.zeros((layout.size, layout.size)), np.zeros(layout.size)
    for name, body in mechanism.bodies.items():
        matrix[layout.start[name] + 2, layout.start[name] + 2] += body.inertia.value
    for point, mass in heavy_points(mechanism, layout):
        jacobian = state.jacobian(point)
        matrix += mass * jacobian.T @ jacobian
        bias += mass * jacobian.T @ state.bias(point)
    return matrix, bias


def kinetic_energy(mechanism: Mechanism, state: State) -> float:
    """From the velocities of centres of mass, without the mass matrix."""
    spin = sum(b.inertia.value * state.speed(n) ** 2 for n, b in mechanism.bodies.items())
    points = heavy_points(mechanism, state.layout)
    return 0.5 * spin + 0.5 * sum(m * np.sum(state.velocity(p) ** 2) for p, m in points)


def weight(mechanism: Mechanism, state: State) -> np.ndarray:
    """Generalised force of gravity."""
    acceleration = pair((mechanism.gravity.x, mechanism.gravity.y))
    total = np.zeros(state.layout.size)
    for point, mass in heavy_points(mechanism, state.layout):
        total += mass * acceleration @ state.jacobian(point)
    return total


def generalised(load: Load, state: State) -> np.ndarray:
    """Generalised force of one load."""
    layout = state.layout
    match load:
        case AxialForce():
            return jet(load.force, state.time)[0] * along_axis(layout, load.body)(state).jacobian[0]
        case AxialDamper():
            row = along_axis(layout, load.body)(state).jacobian[0]
            return -load.damping.value * (row @ state.rates) * row
        case PointForce():
            force = np.array([jet(component, state.time)[0] for component in load.force])
            return force @ state.jacobian(layout.carrier(load.joint))
        case Torque():
            row = angles(layout, [(load.body, 1.0), (load.reference, -1.0)])(state).jacobian[0]
            return jet(load.torque, state.time)[0] * row
        case Spring():
            return _spring(load, state)
        case TorsionSpring():
            turn, jacobian, _ = angles(layout, [(load.body, 1.0), (load.reference, -1.0)])(state)
            row = jacobian[0]
            torque = -load.stiffness.value * (turn[0] - load.angle.value)
            return (torque - load.damping.value * (row @ state.rates)) * row
    raise TypeError(f"no such load: {load}")


def _spring(load: Spring, state: State) -> np.ndarray:
    ends = state.layout.carrier(load.first), state.layout.carrier(load.second)
    vector, jacobian, _ = gap(*ends)(state)
    distance = np.hypot(*vector)
    row = vector / distance @ jacobian
    pull = load.stiffness.value * (distance - load.length.value)
    return -(pull + load.damping.value * (row @ state.rates)) * row


def loads(mechanism: Mechanism, state: State) -> np.ndarray:
    """Generalised force of all loads."""
    parts = [generalised(load, state) for load in mechanism.loads]
    return np.sum(parts, axis=0) if parts else np.zeros(state.layout.size)
