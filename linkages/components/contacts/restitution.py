"""Rigid bodies: impacts reverse part of the rate (Newton), resting contact is a constraint."""

from linkages.components.contributed.contacts import RigidContact
from linkages.components.contributed.normal_laws import ContactLaw

LAW = ContactLaw(
    "restitution",
    ("restitution",),
    lambda numbers: RigidContact(numbers["restitution"], numbers["least_rate"]),
    ("least_rate",),
    rigid=True,
)
