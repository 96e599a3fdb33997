"""Free coordinates that a definition does not name."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, islice

import numpy as np

from linkages.components.contributed.revolute import GROUND
from linkages.components.contributed.terms import Body
from linkages.components.free import FreeAngle
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.topology.graph import gruebler_mobility, topology_graph, unreachable_bodies

MOST_CHOICES = 200
"""How many sets of free coordinates are tried where the file names none."""


def possible_choices(mechanism: Mechanism) -> Iterator[Mechanism]:
    """A mechanism with the free coordinates that it lacks, in all ways, at most `MOST_CHOICES`.

    Clearances are always free. Beyond them, ground-connected bars are taken whose position at
    t = 0 follows from the `assembly` section.
    """
    known = len(mechanism.prescribed) + len(mechanism.initial)
    needed = gruebler_mobility(mechanism) - known
    if needed <= 0 or unreachable_bodies(topology_graph(mechanism)):
        return
    candidates = [c for body in mechanism.bodies.values() if (c := _candidate(mechanism, body))]
    for choice in islice(combinations(candidates, needed), MOST_CHOICES):
        completed = mechanism
        for component in choice:
            completed = completed.with_component(component)
        yield completed


def _candidate(mechanism: Mechanism, body: Body) -> FreeAngle | None:
    """The angle of a bar on the ground, if the place of another of its joints is known.

    A point that a clearance displaces is as good as at its joint.
    """
    followers = (relation.body for relation in mechanism.relations)
    taken = body.name in {*mechanism.prescribed, *mechanism.initial, *followers}
    pins = [joint for joint in body.points if joint in mechanism.ground]
    beside = {term.renamed: term.joint for term in mechanism.displacements}
    hints = [(j, mechanism.hints.get(beside.get(j, j))) for j in body.points if j not in pins]
    places = [(j, hint.position) for j, hint in hints if hint is not None and hint.position]
    if taken or not body.rotates or not pins or not places or body.name == GROUND:
        return None
    joint, place = places[0]
    origin = [value.value for value in mechanism.ground[pins[0]]]
    pin, point = ([value.value for value in body.points[j]] for j in (pins[0], joint))
    direction = np.arctan2(place[1] - origin[1], place[0] - origin[0])
    own = np.arctan2(point[1] - pin[1], point[0] - pin[0])
    return FreeAngle(name=body.name, angle=float(direction - own))
