"""Rigid bodies: impacts reverse part of the rate (Newton), resting contact is a constraint."""

from linkages.components.contributed.contacts import ContactLaw, RigidContact

LAW = ContactLaw(
    "restitution",
    ("restitution",),
    lambda numbers: RigidContact(numbers["restitution"], numbers["least_rate"]),
    ("least_rate",),
)
