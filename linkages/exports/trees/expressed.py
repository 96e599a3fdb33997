"""What MuJoCo can express of a mechanism; the rest is refused by name."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from linkages.components.contributed.measures import BodyAxis, Coordinate, Load
from linkages.components.contributed.terms import Path
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.exports.trees.linear import Line, line_of
from linkages.kernel.system import System

_TIMES = 7
_ROUND_OFF = 1e-12


def refuse(system: System) -> None:
    """Raise for all that MuJoCo cannot express.

    Raises
    ------
    InputError
        With everything at once.
    """
    found = [*_bodies(system.mechanism), *_laws(system)]
    if found:
        raise system.mechanism.error(found)


def _bodies(mechanism: Mechanism) -> Iterator[tuple[Path, str]]:
    links = {link.name for term in mechanism.displacements for link in term.links}
    for name, body in mechanism.bodies.items():
        if name not in links and body.mass.value == 0.0:
            yield body.path, f"{name} has no mass, and MuJoCo needs one; expected 'mass'"
    for contact in mechanism.contacts:
        yield contact.path, "clearances that open are not exported to MuJoCo"
    for end in mechanism.ends:
        yield end.path, "ends at which bodies bounce are not exported to MuJoCo"
    for play in mechanism.plays:
        yield play.path, "clearances of guides are not exported to MuJoCo"
    for relation in mechanism.relations:
        if relation.profile is not None:
            yield relation.path, "cams are not exported to MuJoCo"


def _laws(system: System) -> Iterator[tuple[Path, str]]:
    for name, prescribed in system.mechanism.prescribed.items():
        if polynomial(system, name) is None:
            yield prescribed.path, "MuJoCo follows drives of constant speed or acceleration only"
    for load in system.mechanism.loads:
        if not load.absent and line_in(load) is None:
            yield load.path, "only springs, dampers and forces of constant numbers go to MuJoCo"


def line_in(load: Load) -> Line | None:
    """The law of a load as MuJoCo has it: a spring and damper, or a constant; None if it cannot."""
    found = line_of(load)
    if found is None or load.states or load.bearing is not None or min(found[1:]) < 0.0:
        return None
    moving = found.stiffness or found.damping
    fixed = isinstance(load.measure, BodyAxis)
    return None if fixed or (moving and isinstance(load.measure, Coordinate)) else found


def polynomial(system: System, name: str) -> tuple[float, float] | None:
    """Speed and half the acceleration of a drive; None if the acceleration is not constant."""
    law, end = system.model.positions.laws[name], abs(system.mechanism.simulation.end)
    # at times that no period has in common
    times = np.append(0.0, np.random.default_rng(0).uniform(0.0, max(end, 1.0), _TIMES))
    state = np.repeat(system.state[:, None], len(times), axis=1)
    rates, accelerations = system.evaluate([law.rate, law.acceleration], times, state)
    if np.ptp(accelerations) > _ROUND_OFF * max(1.0, np.abs(accelerations).max()):
        return None
    return float(rates[0]), 0.5 * float(accelerations[0])
