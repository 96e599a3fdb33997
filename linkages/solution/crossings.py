"""Events of a simulation: where and when quantities cross their values."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.solution.evaluation import evaluate_nodes, evaluate_variables
from linkages.solution.flows import watched
from linkages.solution.motion import Motion, Piece
from linkages.solution.reactions import joint_reactions
from linkages.solution.requests import REACTION
from linkages.solution.solution import labelled
from linkages.solution.surface import Watched
from linkages.solvers.events import Crossings, Event

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

MOST = 10**6
"""Crossings of an event that are recorded within a piece of a motion."""

PLACES = 65
"""Where an event is looked for within a passage through a change point, which is short."""

GRID = math.radians(1.0)
"""Most that a drive turns between two places of a driven motion at which an event is looked for."""

HALVINGS = 60
"""Of the interval between two places: more than a number has digits."""


def solver_events(
    system: System, events: Sequence[Watched], more: int, flipped: Collection[int]
) -> list[Event]:
    """Events as a solver looks for them in the flow of a system.

    Parameters
    ----------
    system
        What moves.
    events
        What is looked for.
    more
        Number of further coordinates that are integrated.
    flipped
        Blocks in another mode than at the start.
    """
    return [
        Event(
            function=watched(system, event.surface.nodes, more, flipped),
            direction=event.sign,
            capacity=MOST,
        )
        for event in events
    ]


def crossed_piece(event: Watched, crossings: Crossings, like: Piece, turns: Floats) -> Piece:
    """Crossings that a solver met, as a piece of the motion.

    Parameters
    ----------
    event, crossings
        What was looked for, and what was met.
    like
        A piece of the same motion in the same assembly mode.
    turns
        Whole turns of the coordinates before the solver started, shape (n,).
    """
    n, total = len(turns), crossings.state.shape[1] // 2
    rows = crossings.state.T
    m = len(crossings.time)
    piece = replace(
        like,
        time=crossings.time,
        state=np.concatenate([rows[:n], rows[total : total + n]]),
        turns=crossings.turns.T[:n] + turns[:, None],
        acceleration=np.zeros((n, m)),
        work=None,
        counted={},
        flipped={block: np.ones(m, dtype=bool) for block in like.flipped},
        samples=None,
    )
    return piece.part(_on_surface(event, piece))


def passed_piece(event: Watched, piece: Piece) -> Piece:
    """Crossings within a passage through a change point, where values are interpolated."""
    grid = np.linspace(piece.time[0], piece.time[-1], PLACES)
    node, _ = event.surface.nodes(piece.system.model)
    values = evaluate_nodes(piece, [node])

    def function(times: Floats) -> Floats:
        return np.asarray(replace(piece, samples=times).interpolated(values)[0])

    found = replace(piece, samples=located(function, grid, event.sign))
    there = _on_surface(event, found.direct())
    return replace(found, samples=found.wanted[there])


def driven_piece(event: Watched, like: Piece, first: float, last: float, fastest: float) -> Piece:
    """Crossings of a motion that follows from time alone, between two times.

    Parameters
    ----------
    event
        What is looked for.
    like
        A piece of the motion in the same assembly mode.
    first, last
        In seconds.
    fastest
        Highest speed of a drive in rad/s.
    """
    system = like.system
    node, _ = event.surface.nodes(system.model)

    def at(times: Floats) -> Piece:
        nothing = np.zeros((0, len(times)))
        flipped = {block: np.ones(len(times), dtype=bool) for block in like.flipped}
        made = replace(like, time=times, state=nothing, turns=nothing, acceleration=nothing)
        return replace(made, work=None, counted={}, flipped=flipped)

    def function(times: Floats) -> Floats:
        return np.asarray(evaluate_nodes(at(times), [node])[0])

    count = 2 + math.ceil(abs(last - first) * fastest / GRID)
    found = at(located(function, np.linspace(first, last, count), event.sign))
    return found.part(_on_surface(event, found))


def located(function: Callable[[Floats], Floats], grid: Floats, sign: int) -> Floats:
    """Where a function crosses zero, between two places of a grid at least, by bisection.

    Parameters
    ----------
    function
        Of an array of times.
    grid
        Times in the order of the motion. A zero at the first one is no crossing.
    sign
        1 where it grows along the grid, -1 where it falls, 0 for both.
    """
    values = function(grid)
    before, after = values[:-1], values[1:]
    up, down = (before < 0) & (after >= 0), (before > 0) & (after <= 0)
    chosen = {1: up, -1: down, 0: up | down}[sign]
    near, far, way = grid[:-1][chosen], grid[1:][chosen], np.where(up, 1.0, -1.0)[chosen]
    for _ in range(HALVINGS if len(near) else 0):
        middle = 0.5 * (near + far)
        beyond = function(middle) * way >= 0
        near, far = np.where(beyond, near, middle), np.where(beyond, middle, far)
    return np.asarray(far)


def _on_surface(event: Watched, piece: Piece) -> NDArray[np.bool_]:
    return event.surface.reached(piece.system, piece.time, piece.state, piece.flipped)


def labelled_events(
    crossed: Mapping[str, Sequence[Piece]], names: Sequence[str]
) -> dict[str, xr.Dataset]:
    """Event → outputs at its crossings, as a solution has them at its samples.

    Parameters
    ----------
    crossed
        Event → its crossings, piece by piece.
    names
        Outputs; those that compare a motion with its past, or with another one, are left out.
    """
    plain = [name for name in names if not VARIABLES[name].whole]
    found = {}
    for event, pieces in crossed.items():
        motion = Motion(pieces=tuple(_accelerated(piece) for piece in pieces))
        values = evaluate_variables(motion, plain)
        if REACTION in names:
            values[REACTION] = joint_reactions(motion)
        system = motion.pieces[0].system
        kept = {name: values[name] for name in names if name in values}
        found[event] = labelled(system, motion, kept).assign_attrs(event=event)
    return found


def _accelerated(piece: Piece) -> Piece:
    """A piece with the accelerations that follow from its states."""
    if piece.samples is not None or not len(piece.acceleration):
        return piece
    model = piece.system.model
    nodes = model.integrated_accelerations(model.free_accelerations)
    values = piece.system.evaluate(nodes, piece.time, piece.state, flipped=piece.flipped)
    return replace(piece, acceleration=values)
