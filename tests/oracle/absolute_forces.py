"""Masses, weights and loads in absolute coordinates."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from absolute_bodies import Layout, Point, State, pair
from absolute_covered import NotCoveredError
from absolute_measures import along_axis, angles, gap
from time_functions import jet

from linkages.components.contributed.functions import PRESSED, Measured
from linkages.components.contributed.load_measures import (
    Bearing,
    BodyAxis,
    Coordinate,
    Distance,
    Load,
    Measure,
    Slide,
    Turn,
)
from linkages.components.mechanisms.mechanism import Mechanism


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


def generalised(
    load: Load, state: State, pressing: Mapping[Bearing, float] = MappingProxyType({})
) -> np.ndarray:
    """Generalised force of one load; `pressing` has the forces that press frictions."""

    def sensed(found: Measured) -> float:
        if found == PRESSED:
            return pressing[load.bearing]
        if found.order > 1:
            raise NotCoveredError(load.path, f"a law of {found}")
        value, row = _along(load.measure if found.measure is None else found.measure, state)
        return float(row @ state.rates) if found.order else value

    try:
        size = jet(load.law, state.time, sensed)[0]
    except ValueError as error:
        raise NotCoveredError(load.path, str(error)) from error
    return size * _along(load.measure, state)[1]


def _along(measure: Measure, state: State) -> tuple[float, np.ndarray]:
    """What a load acts along, and its derivatives by all coordinates."""
    layout = state.layout
    match measure:
        case Slide(body):
            found = along_axis(layout, body)(state)
            return found.value[0], found.jacobian[0]
        case Coordinate(joint, axis):
            point = layout.carrier(joint)
            return state.place(point)[axis], state.jacobian(point)[axis]
        case Turn(body, reference):
            found = angles(layout, [(body, 1.0), (reference, -1.0)])(state)
            return found.value[0], found.jacobian[0]
        case Distance(first, second):
            vector, jacobian, _ = gap(layout.carrier(first), layout.carrier(second))(state)
            distance = np.hypot(*vector)
            return distance, vector / distance @ jacobian
        case BodyAxis(joint, body, axis):
            point, turned = layout.carrier(joint), angles(layout, [(body, 1.0)])(state).value[0]
            direction = np.array([np.cos(turned), np.sin(turned)])
            across = np.array([-direction[1], direction[0]])
            return np.nan, (across if axis else direction) @ state.jacobian(point)
    raise TypeError(f"no such measure: {measure}")


def loads(
    mechanism: Mechanism, state: State, pressing: Mapping[Bearing, float] = MappingProxyType({})
) -> np.ndarray:
    """Generalised force of all loads."""
    parts = [generalised(load, state, pressing) for load in mechanism.loads]
    return np.sum(parts, axis=0) if parts else np.zeros(state.layout.size)
