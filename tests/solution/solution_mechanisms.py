"""Mechanisms that several tests of solutions use, as text or built from components."""

import math

import numpy as np

import linkages
from linkages import Bar, FreeAngle, GroundJoint, Mechanism, UniformGravity

GRAVITY = 9.81

FOUR_BAR = """\
gravity: [0, -9.81]
joints: {O2: [0, 0], O4: [0.1, 0]}
bars:
  crank: {joints: [O2, A], length: 0.04, mass: 0.15, inertia: 3e-5, center: [0.01, 0.004]}
  coupler: {joints: [A, B], length: 0.12, mass: 0.45, inertia: 7e-4, center: [0.05, 0.02]}
  rocker: {joints: [O4, B], length: 0.08, mass: 0.3, inertia: 2e-4}
drives: {crank: {angle: 0.7, speed: 6}}
assembly: {B: left}
"""
SLIDER_CRANK = """\
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.04, mass: 0.8, center: 0.01, inertia: 6e-4}
  rod: {joints: [A, B], length: 0.14, mass: 0.5}
sliders: {piston: {joint: B, through: O, mass: 0.4}}
drives: {crank: {angle: 0.3, speed: 50}}
assembly: {B: [0.18, 0]}
loads: [{slider: piston, force: -200}]
"""
# its crank has turned by 60 degrees
FREE_CRANK = """\
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.04, mass: 0.8, center: 0.01, inertia: 6e-4}
  rod: {joints: [A, B], length: 0.14, mass: 0.5}
sliders: {piston: {joint: B, through: O, mass: 0.4}}
assembly: {A: [0.02, 0.034], B: [0.156, 0]}
"""
# free between two dead points of its rocker
DOUBLE_ROCKER = """\
joints: {O: [0, 0], D: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.8, mass: 1}
  coupler: {joints: [A, B], length: 0.3, mass: 1}
  rocker: {joints: [B, D], length: 0.3, mass: 1}
free: {rocker: {angle: 60 deg, speed: 0}}
assembly: {A: left}
"""


def mechanism(text, *more):
    """The mechanism that a definition describes, with further sections after it."""
    return linkages.loads("".join([text, *(f"{section}\n" for section in more)]))


def point_mass(name, joints, length, mass):
    """A massless rod with a point mass at its second joint."""
    return Bar(name=name, joints=joints, length=length, mass=mass, center=length, inertia=0.0)


def pendulum(angle, *, length=0.7, mass=1.3):
    """A point mass on a rod, released at rest `angle` from the vertical."""
    return Mechanism(
        components=(
            UniformGravity(acceleration=(0.0, -GRAVITY)),
            GroundJoint(name="O", position=(0.0, 0.0)),
            point_mass("rod", ("O", "P"), length, mass),
            FreeAngle(name="rod", angle=angle - math.pi / 2),
        )
    )


def double_pendulum(first, second):
    """Two point masses of 1 kg on rods of 1 m, released at rest."""
    return Mechanism(
        components=(
            UniformGravity(acceleration=(0.0, -GRAVITY)),
            GroundJoint(name="O", position=(0.0, 0.0)),
            point_mass("upper", ("O", "P"), 1.0, 1.0),
            point_mass("lower", ("P", "Q"), 1.0, 1.0),
            FreeAngle(name="upper", angle=first - math.pi / 2),
            FreeAngle(name="lower", angle=second - math.pi / 2),
        )
    )


# Central differences of order 8 (Fornberg 1988, Table 1).
FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
SECOND = np.array(
    [-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560]
)  # fmt: skip


def derivative(values, spacing, order=1):
    """Derivative along the first axis, without the four samples at either end."""
    weights = FIRST if order == 1 else SECOND
    parts = [weight * values[i : len(values) - 8 + i] for i, weight in enumerate(weights)]
    return sum(parts) / spacing**order
