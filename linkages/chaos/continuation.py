"""Motions that go on from where others ended, while a parameter changes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.common_period import NoPeriodError, common_period
from linkages.chaos.free_states import PAIRS, free_names, free_values
from linkages.chaos.section import poincare
from linkages.components.assembly import AssemblyHint
from linkages.components.mechanism import Mechanism
from linkages.errors import ComputationError, Interrupted
from linkages.kernel.system import System
from linkages.solution.motion import Motion, Settings, compute_motion
from linkages.solution.simulate import passes

Floats = NDArray[np.float64]

WHOLE = 1e-9
"""Part of a period by which round-off moves a time from a whole number of periods."""


@dataclass(frozen=True, eq=False)
class End:
    """Where a motion ended: what the next one starts from.

    Parameters
    ----------
    state
        Free coordinate → value and rate; with whole turns where they count.
    places
        Point → where it was, shape (2,): which assembly mode the mechanism is in.
    carried
        Coordinates carried along by the integration, with whole turns where they count.
    turns
        Of the torsional springs, as `Assembly` has them.
    """

    state: Mapping[str, tuple[float, float]]
    places: Mapping[str, Floats]
    carried: Mapping[str, float]
    turns: Mapping[int, float]

    def mechanism(self, other: Mechanism) -> Mechanism:
        """Another mechanism in this state; places given by its definition are those of here."""
        found = other.with_state(self.state)
        return replace(found, components=tuple(self._moved(c) for c in found.components))

    def _moved(self, component: Any) -> Any:
        if not isinstance(component, AssemblyHint) or isinstance(component.where, str):
            return component
        place = self.places[component.name]
        return replace(component, where=(float(place[0]), float(place[1])))

    def system(self, other: Mechanism) -> System:
        """Another mechanism in this state and assembly mode, with the same whole turns."""
        system = System(other.with_state(self.state), near=self.places)
        topology = system.topology
        for index, name in enumerate(topology.coordinates):
            if name in self.carried and topology.unwrapped(name):
                apart = self.carried[name] - system.state[index]
                system.state[index] += 2 * np.pi * np.round(apart / (2 * np.pi))
        system.assembly = replace(system.assembly, turns=dict(self.turns))
        return system


def end_of(system: System, motion: Motion) -> End:
    """Where a motion of a system ended, at its last sample."""
    last = next(piece for piece in reversed(motion.pieces) if len(piece.wanted))
    piece = last.direct().part(slice(-1, None))
    positions = piece.system.model.positions
    nodes = [node for place in positions.joints.values() for node in (place.x, place.y)]
    carried = system.topology.carried
    coordinates = [positions.coordinate(name) for name in carried]
    found = piece.system.evaluate(
        [*nodes, *coordinates], piece.time, piece.state, flipped=piece.flipped
    )[:, 0]
    return End(
        state=_free_state(system, motion),
        places=dict(zip(positions.joints, found[: len(nodes)].reshape(-1, 2), strict=True)),
        carried=dict(zip(carried, found[len(nodes) :].tolist(), strict=True)),
        turns=piece.system.assembly.turns,
    )


def _free_state(system: System, motion: Motion) -> dict[str, tuple[float, float]]:
    """Free coordinates and rates at the last sample; angles within one turn unless turns count."""
    whole, within = (free_values(system, motion, wrap) for wrap in (False, True))
    state = {}
    for dim, names in free_names(system).items():
        value, rate = PAIRS[dim]
        for column, name in enumerate(names):
            chosen = whole if system.topology.unwrapped(name) else within
            state[name] = (float(chosen[value][-1, column]), float(whole[rate][-1, column]))
    return state


def stroboscopic_points(
    system: System, settings: Settings, *, periods: int, skip: int, phase: float
) -> tuple[dict[str, Floats], End | None]:
    """Points of a stroboscopic section, and where the motion is at the next whole period.

    Returns
    -------
    What `poincare` returns of the free coordinates; and the end, None if the motion stops before.

    Raises
    ------
    ComputationError
        If the motion cannot go on until the last point.
    """
    period = common_period(system.mechanism)
    times = period * (phase + skip + np.arange(periods, dtype=np.float64))
    if phase:
        times = np.append(times, period * (skip + periods))
    motion = _motion(system, settings, times, passing=passes(system))
    if len(motion.time) < periods:
        raise ComputationError(str(motion.failure), time=motion.stop_time)
    values = {name: array[:periods] for name, array in free_values(system, motion).items()}
    return values, end_of(system, motion) if len(motion.time) == len(times) else None


def crossing_points(
    mechanism: Mechanism, before: End | None, settings: Settings, section: Mapping[str, Any]
) -> tuple[dict[str, Floats], End | None]:
    """Crossings of a section, and where the motion is at the next whole period of the drives.

    Without a common period nothing distinguishes one time from another, and the end is the last
    crossing itself. Arguments and results as of `stroboscopic_points`.
    """
    data = poincare(mechanism if before is None else before.mechanism(mechanism), **section)
    system = System(mechanism) if before is None else before.system(mechanism)
    time = _whole(mechanism, float(data["time"][-1]))
    motion = _motion(system, settings, np.array([time]), passing=False)
    values = {str(name): np.asarray(array) for name, array in data.data_vars.items()}
    return values, None if motion.failure else end_of(system, motion)


def _whole(mechanism: Mechanism, time: float) -> float:
    """The next time at which drives are where they were at the start."""
    try:
        period = common_period(mechanism)
    except NoPeriodError:
        return time
    return period * math.ceil(time / period - WHOLE)


def _motion(system: System, settings: Settings, times: Floats, passing: bool) -> Motion:
    motion = compute_motion(system, replace(settings, times=times, passing=passing))
    if motion.interrupted:
        raise Interrupted(str(motion.failure), time=motion.stop_time)
    return motion
