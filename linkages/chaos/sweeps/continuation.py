"""Motions that go on from where others ended, while a parameter changes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.sections.common_period import NoPeriodError, common_period
from linkages.chaos.sections.contact_log import contact_values
from linkages.chaos.sections.crossed import crossing
from linkages.chaos.sections.free_states import PAIRS, free_names, free_values
from linkages.chaos.sections.section import last_time, met_points, require_section
from linkages.chaos.sections.strobe import Strobing, strobing
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError, UnfinishedError
from linkages.kernel.outputs import links
from linkages.kernel.system import System
from linkages.options.sections import SectionOptions
from linkages.solution.moving.many import Going
from linkages.solution.moving.march import March
from linkages.solution.moving.motion import Motion, Piece

Floats = NDArray[np.float64]

WHOLE = 1e-9
"""Part of a period by which round-off moves a time from a whole number of periods."""


@dataclass(frozen=True, eq=False)
class ContinuationEnd:
    """Where a motion ended: what the next one starts from.

    Parameters
    ----------
    state
        Free coordinate → value and rate; with whole turns where they count.
    places
        Point → where it was, shape (2,): which assembly mode the mechanism is in.
    internal
        Internal states by name.
    carried
        Coordinates carried along by the integration, with whole turns where they count.
    turns
        Of the torsional springs, as `Assembly` has them.
    held
        Modes and what the motion remembers, by their names.
    """

    state: Mapping[str, tuple[float, float]]
    places: Mapping[str, Floats]
    internal: Mapping[str, float]
    carried: Mapping[str, float]
    turns: Mapping[int, float]
    held: Mapping[str, float]

    def system(self, other: Mechanism) -> System:
        """Another mechanism in this state, assembly mode and modes, with the same whole turns."""
        system = System(other.with_state(self.state), near=self.places)
        system = system.with_internal(self.internal)
        topology, state = system.topology, system.state.copy()
        for index, name in enumerate(topology.coordinates):
            if name in self.carried and topology.unwrapped(name):
                apart = self.carried[name] - state[index]
                state[index] += 2 * np.pi * np.round(apart / (2 * np.pi))
        return system.turned(state, self.turns).holding(self.held)


def end_of(system: System, motion: Motion, sample: int = -1) -> ContinuationEnd:
    """Where a motion of a system was at one of its samples, the last one if it is not said."""
    piece, place = _piece_at(motion, range(len(motion.time))[sample])
    piece = piece.direct().part(slice(place, place + 1))
    positions = piece.system.model.positions
    nodes = [node for place in positions.joints.values() for node in (place.x, place.y)]
    carried = system.topology.carried
    coordinates = [positions.coordinate(name) for name in carried]
    coordinates += piece.system.model.internal
    found = piece.system.evaluate(
        [*nodes, *coordinates], piece.time, piece.state, flipped=piece.flipped
    )[:, 0]
    held = np.zeros(0) if piece.held is None else piece.held[:, 0]
    first = len(nodes) + len(carried)
    return ContinuationEnd(
        state=_free_state(system, motion, sample),
        places=dict(zip(positions.joints, found[: len(nodes)].reshape(-1, 2), strict=True)),
        internal=dict(zip(system.topology.internal, found[first:].tolist(), strict=True)),
        carried=dict(zip(carried, found[len(nodes) : first].tolist(), strict=True)),
        turns=piece.system.assembly.turns,
        held=dict(zip(piece.system.model.switches.names, held.tolist(), strict=True)),
    )


def _piece_at(motion: Motion, sample: int) -> tuple[Piece, int]:
    """The piece that a sample belongs to, and its place there."""
    for piece in motion.pieces:
        if sample < len(piece.wanted):
            return piece, sample
        sample -= len(piece.wanted)
    raise IndexError(sample)


def _free_state(system: System, motion: Motion, sample: int) -> dict[str, tuple[float, float]]:
    """Free coordinates and rates at a sample; angles within one turn unless turns count."""
    whole, within = (free_values(system, motion, wrap) for wrap in (False, True))
    state = {}
    for dim, names in free_names(system).items():
        value, rate = PAIRS[dim]
        for column, name in enumerate(names):
            chosen = whole if system.topology.unwrapped(name) else within
            state[name] = (float(chosen[value][sample, column]), float(whole[rate][sample, column]))
    return state


@dataclass(frozen=True, eq=False)
class Visited:
    """Points of a section, and where the motion was when it came to the first and left the last.

    Parameters
    ----------
    values
        What `poincare` returns of the free coordinates and of contact.
    first, last
        At a whole period of the drives: not behind the first point of a stroboscopic section and
        not before the first crossing; not before the last point. None if it was not asked for, or
        the motion did not come so far.
    refusal
        What is missing, if the motion stopped.
    warning
        What `poincare` says of the points.
    interval
        Time in seconds between two looks at the forces in clearances.
    """

    values: dict[str, Floats]
    first: ContinuationEnd | None
    last: ContinuationEnd | None
    refusal: ComputationError | None
    warning: str = ""
    interval: float = 0.0


def stroboscopic_points(
    system: System,
    options: SectionOptions,
    ends: tuple[bool, bool] = (True, True),
) -> Going[Visited]:
    """Points of a stroboscopic section, and the first and the last end if wanted, from one motion.

    Raises
    ------
    ComputationError
    """
    plan = stroboscope(system, options, ends)
    motion = yield from March(system, options).advancing(plan.times)
    return strobed(plan, motion, ends)


def stroboscope(system: System, options: SectionOptions, ends: tuple[bool, bool]) -> Strobing:
    """When a motion is wanted for points of a section and its ends."""
    asked = zip(_ends_of(system, options), ends, strict=True)
    return strobing(system, options, tuple(time for time, wanted in asked if wanted))


def _ends_of(system: System, options: SectionOptions) -> tuple[float, float]:
    """Times of whole periods beside the first and the last point."""
    period = common_period(system.mechanism)
    skip, periods, phase = options.skip, options.periods, options.phase
    # without a phase the last point is at a whole period itself
    return period * skip, period * (skip + periods - (not phase))


def strobed(plan: Strobing, motion: Motion, ends: tuple[bool, bool]) -> Visited:
    """What a motion visited that was sampled as `stroboscope` says."""
    system, found = plan.system, plan.taken(motion)
    places = [found.place(time) for time in _ends_of(system, plan.options)]
    first, last = (
        end_of(system, motion, place) if asked and place is not None else None
        for place, asked in zip(places, ends, strict=True)
    )
    names = links(system.model)
    return Visited(
        values=found.values(plan.options.wrap)
        | (contact_values(found.contacts, names) if names else {}),
        first=first,
        last=last,
        refusal=_refusal(found.failure, motion.stop_time),
        interval=found.interval,
    )


def crossing_points(
    mechanism: Mechanism,
    before: ContinuationEnd | None,
    options: SectionOptions,
    ends: bool = True,
) -> Going[Visited]:
    """Crossings of a section, and where the motion was at whole periods of the drives.

    Without a common period nothing distinguishes one time from another, and ends are the crossings
    themselves. With `ends` the motion is followed once more to find them.

    Raises
    ------
    ComputationError
        If the motion never crosses the section.
    """
    refusal: ComputationError | None = None
    try:
        start = System(mechanism) if before is None else before.system(mechanism)
        require_section(start, options)
        plan = crossing(start, options, last_time(start, options))
        met = plan.met((yield from plan.march.advancing(plan.times, guards=[plan.guard])))
        data = met_points(start, options, met)
    except UnfinishedError as error:
        if not error.kept["poincare"].sizes["crossing"]:
            raise
        data, refusal = error.kept["poincare"], _refusal(str(error), error.time)
    first = last = None
    if ends and data.sizes["crossing"]:
        times = [_whole(mechanism, float(data["time"][place])) for place in (0, -1)]
        motion = yield from March(start, options).advancing(np.unique(times))
        places = [int(np.searchsorted(motion.time, time)) for time in times]
        first, last = (
            end_of(start, motion, at) if at < len(motion.time) else None for at in places
        )
        refusal = refusal or (None if first else _refusal(motion.failure, motion.stop_time))
    return Visited(
        values={str(name): np.asarray(array) for name, array in data.data_vars.items()},
        first=first,
        last=last,
        refusal=refusal,
        warning=data.attrs["warning"],
        interval=data["contact_lost"].attrs["interval"] if "contact_lost" in data else 0.0,
    )


def _refusal(failure: str | None, time: float | None) -> ComputationError | None:
    return None if failure is None else ComputationError(failure, time=time)


def _whole(mechanism: Mechanism, time: float) -> float:
    """The next time at which drives are where they were at the start."""
    try:
        period = common_period(mechanism)
    except NoPeriodError:
        return time
    return period * math.ceil(time / period - WHOLE)
