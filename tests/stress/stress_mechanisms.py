"""Mechanisms and settings that several stress tests use."""

import math

import numpy as np

import linkages
from linkages import Bar, FreeAngle, GroundJoint, Mechanism, UniformGravity
from linkages.components.mechanisms.definition import from_document
from linkages.reading.document import parse

CLOSURE = 1e-13
"""The project's promise for the closure equations, in metres."""

HELD = {"drives.crank1.speed": 0.0, "drives.crank4.speed": 0.0}
"""Assignments that stop the drives of the nine-bar: its clearance swings, nothing adds energy."""


def defined(text):
    """The mechanism that a definition describes."""
    return from_document(parse(text, "m.yaml"))


def double_pendulum(first=0.5, second=-0.3, *, masses=(1.0, 1.0), lengths=(1.0, 1.0)):
    """Two point masses on massless rods, released at rest at angles from the vertical."""

    def rod(name, joints, length, mass):
        return Bar(name=name, joints=joints, length=length, mass=mass, center=length, inertia=0.0)

    return Mechanism(
        components=(
            UniformGravity(acceleration=(0.0, -9.81)),
            GroundJoint(name="O", position=(0.0, 0.0)),
            rod("upper", ("O", "P"), lengths[0], masses[0]),
            rod("lower", ("P", "Q"), lengths[1], masses[1]),
            FreeAngle(name="upper", angle=first - math.pi / 2),
            FreeAngle(name="lower", angle=second - math.pi / 2),
        )
    )


def energy_of(data):
    """Kinetic and potential energy together, less what there was at t = 0."""
    energy = (data.kinetic_energy + data.potential_energy).to_numpy()
    return energy - energy[0]


def moved_energy(data):
    """Energy that a motion passes to and fro: what residuals are compared with."""
    return float(data.kinetic_energy.max()) + float(np.ptp(data.potential_energy.to_numpy()))


def nine_bar(**assignments):
    """The shipped press; ``__`` in a name stands for the dots of a path."""
    return linkages.load(
        "ninebar", set={key.replace("__", "."): value for key, value in assignments.items()}
    )
