"""Motions until a section has been crossed often enough."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from linkages.chaos.contact import Contact
from linkages.chaos.contact_log import ContactLog, check_interval
from linkages.chaos.stops import stop_text
from linkages.errors import ComputationError
from linkages.kernel.system import System
from linkages.solution.flows import Flows, watched
from linkages.solution.motion import Motion, Piece, Settings
from linkages.solution.surface import DIRECTIONS, Surface
from linkages.solvers.events import Event
from linkages.solvers.flow import Flow
from linkages.solvers.integrate import integrate
from linkages.solvers.outcome import Outcome
from linkages.solvers.trajectory import Trajectory


class NeverCrossedError(ComputationError):
    """A motion does not reach the section at which points were to be taken."""


@dataclass(frozen=True, eq=False)
class Met:
    """Crossings of a section, and the forces in clearances from the first to the last."""

    motion: Motion
    contacts: tuple[Contact, ...]
    interval: float


def crossed(
    system: System,
    settings: Settings,
    surface: Surface,
    points: int,
    skip: int,
    direction: str,
    end: float,
) -> Met:
    """Integrate until enough crossings are found."""
    flow, function = Flows(system).flow(), watched(system, surface.nodes)
    wanted = points + skip
    capacity = wanted
    interval = check_interval(system, end)
    log = None if interval is None else ContactLog(system, interval)
    looks = 1 if log is None else log.looks(end - system.time)
    times = np.linspace(system.time, end, looks + 1)[1:]
    while True:
        event = Event(
            function=function,
            direction=DIRECTIONS[direction],
            terminal=capacity,
            capacity=capacity,
        )
        trajectory = _integrated(system, flow, replace(settings, times=times), event)
        piece = _met(system, surface, trajectory)
        if len(piece.time) >= wanted or trajectory.outcome is not Outcome.EVENT:
            break
        capacity *= 2  # others used it up
    ended = trajectory.outcome in (Outcome.DONE, Outcome.EVENT)
    count = len(piece.time)
    piece = piece.part(slice(skip, wanted))
    if ended and not len(piece.time):
        raise NeverCrossedError(
            f"the section {surface.series.name} = {surface.level:g} is crossed "
            f"{count} times within {end:.6g} s"
            + (f", and {skip} are skipped" if count else "")
            + "; expected a value that the motion reaches",
            time=float(end),
        )
    motion = Motion(
        pieces=(piece,),
        failure=None if ended else stop_text(system, trajectory, trajectory.final_state),
        stop_time=trajectory.stop_time,
        interrupted=trajectory.outcome is Outcome.INTERRUPTED,
    )
    if log is None or not len(piece.time):
        return Met(motion, (), 0.0)
    log.restart(since=piece.time[0])
    log.note(trajectory.time, trajectory.state.T, trajectory.acceleration.T)
    return Met(motion, log.contacts, log.interval)


def _integrated(system: System, flow: Flow, settings: Settings, event: Event) -> Trajectory:
    """Integrate until a number of crossings are met, or to the last of the times."""
    return integrate(
        flow,
        system.state,
        settings.times,
        start=system.time,
        method=settings.method,
        rtol=settings.rtol,
        atol=settings.atol,
        step=settings.step,
        max_steps=settings.max_steps,
        events=[event],
        watch=settings.watch,
    )


def _met(system: System, surface: Surface, trajectory: Trajectory) -> Piece:
    """The crossings of a trajectory, without those of an angle half a turn away."""
    found = trajectory.crossings[0]
    piece = Piece(
        system=system,
        time=found.time,
        state=found.state.T,
        turns=found.turns.T.astype(float),
        acceleration=np.zeros(found.turns.T.shape),
    )
    return piece.part(surface.reached(system, piece.time, piece.state))
