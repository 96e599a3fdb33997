"""Event functions of a motion, and its states as one array."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.model import Model
from linkages.kernel.outputs import VARIABLES, coordinate_of, labels
from linkages.kernel.scalars import Scalar
from linkages.kernel.system import System
from linkages.solution.evaluation import evaluate_nodes, evaluate_variables
from linkages.solution.motion import Motion, Piece
from linkages.solution.plan import Plan
from linkages.solvers.trajectory import Event

Floats = NDArray[np.float64]

AT_ONCE = 10_000
"""Crossings for which there is room at first, where no number is wanted."""

PLACES = 65
"""Where a guard is looked at within a passage through a change point, which is short."""

GRID = math.radians(1.0)
"""Most that a drive turns between two places of a driven motion at which a guard is looked at."""

HALVINGS = 60
"""Of the interval between two places: more than a number has digits."""


@dataclass(frozen=True, kw_only=True)
class Guard:
    """A function of position and velocity that is watched for crossings of zero.

    Parameters
    ----------
    nodes
        The model → the function and its rate, which may depend on accelerations.
    direction
        1: where it grows with time; −1: where it falls; 0: both. Backward in time it is seen along
        the integration.
    wanted
        Number of crossings at which the motion ends; 0: it does not.
    counts
        Which crossings count, of those of a piece; all if None.
    key
        Equal for guards with the same nodes, which are printed once for a structure.
    name
        Under which the motion has the crossings.
    """

    nodes: Callable[[Model], tuple[Scalar, Scalar]]
    direction: int = 0
    wanted: int = 0
    counts: Callable[[Piece], NDArray[np.bool_]] | None = None
    key: Hashable = None
    name: str = ""

    def counting(self, piece: Piece) -> NDArray[np.bool_]:
        """Which crossings of a piece count, shape (m,)."""
        if self.counts is None or not len(piece.time):
            return np.ones(len(piece.time), dtype=bool)
        return self.counts(piece)


class Watched:
    """Crossings of a guard, as they come in.

    Parameters
    ----------
    guard
        What is watched.
    """

    def __init__(self, guard: Guard) -> None:
        self.guard = guard
        self._pieces: list[Piece] = []
        self._wider = 1

    @property
    def _count(self) -> int:
        return sum(len(piece.wanted) for piece in self._pieces)

    @property
    def done(self) -> bool:
        """Whether it was crossed as often as it wants."""
        return 0 < self.guard.wanted <= self._count

    @property
    def motion(self) -> Motion:
        """The states at the crossings."""
        return Motion(pieces=tuple(self._pieces)).part(last=self.guard.wanted or None)

    def event(self, plan: Plan, system: System, flipped: tuple[int, ...]) -> Event:
        """What the next integration of a system is to watch."""
        wanted = self.guard.wanted
        room = self._wider * (wanted - self._count if wanted else AT_ONCE)
        return Event(
            function=plan.watch(system, self.guard.nodes, self.guard.key, flipped),
            direction=self.guard.direction,
            terminal=room,
            capacity=room,
        )

    def widen(self) -> None:
        """Make room for twice as many crossings."""
        self._wider *= 2

    def enough(self, piece: Piece) -> bool:
        """Whether it is done with the crossings of another piece."""
        wanted = self.guard.wanted
        return 0 < wanted <= self._count + int(self.guard.counting(piece).sum())

    def add(self, piece: Piece) -> None:
        """Take the crossings that an integration met."""
        self._pieces.append(piece.part(self.guard.counting(piece)))

    def add_within(self, piece: Piece) -> None:
        """Take those of a step through a change point, from what is interpolated there."""
        self._pieces.append(passed_piece(self.guard, piece))


def passed_piece(guard: Guard, piece: Piece) -> Piece:
    """Crossings within a passage through a change point, where values are interpolated."""
    grid = np.linspace(piece.time[0], piece.time[-1], PLACES)
    node, _ = guard.nodes(piece.system.model)
    values = evaluate_nodes(piece, [node])

    def function(times: Floats) -> Floats:
        return np.asarray(replace(piece, samples=times).interpolated(values)[0])

    found = replace(piece, samples=located(function, grid, guard.direction))
    there = guard.counting(found.direct())
    return replace(found, samples=found.wanted[there])


def driven_piece(guard: Guard, like: Piece, first: float, last: float, fastest: float) -> Piece:
    """Crossings of a motion that follows from time alone, between two times.

    Parameters
    ----------
    first, last
        In seconds.
    fastest
        Highest speed of a drive in rad/s.
    """
    node, _ = guard.nodes(like.system.model)

    def at(times: Floats) -> Piece:
        nothing = np.zeros((0, len(times)))
        flipped = {block: np.ones(len(times), dtype=bool) for block in like.flipped}
        made = replace(like, time=times, state=nothing, turns=nothing, acceleration=nothing)
        return replace(made, work=None, losses=None, counted={}, flipped=flipped)

    def function(times: Floats) -> Floats:
        return np.asarray(evaluate_nodes(at(times), [node])[0])

    count = 2 + math.ceil(abs(last - first) * fastest / GRID)
    found = at(located(function, np.linspace(first, last, count), guard.direction))
    return found.part(guard.counting(found))


def located(function: Callable[[Floats], Floats], grid: Floats, sign: int) -> Floats:
    """Where a function crosses zero, between two places of a grid at least, by bisection."""
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


def free_vectors(
    system: System,
    motion: Motion,
    *,
    names: tuple[str, ...] | None = None,
    turns: bool = True,
) -> Floats:
    """Free coordinates, rates and internal states, whatever coordinates it was integrated in.

    Returns
    -------
    Shape (samples, 2n + s).
    """
    names = system.topology.free if names is None else names
    found = [_of_piece(system, piece, names, turns) for piece in motion.pieces]
    return np.concatenate(found, axis=1).T


def _of_piece(system: System, piece: Piece, names: tuple[str, ...], turns: bool) -> Floats:
    """Shape (2n + s, samples)."""
    layout = piece.system.layout
    if layout.bodies[: len(names)] != names or piece.samples is not None:
        return np.concatenate([_evaluated(system, piece, names), _internal(piece)])
    places = [layout.coordinates.index(name) for name in names]
    found = np.concatenate([piece.state[places], piece.state[len(piece.turns) :][places]])
    if turns:
        found[: len(names)] += 2 * np.pi * piece.turns[places]
    return np.concatenate([found, _internal(piece)])


def _internal(piece: Piece) -> Floats:
    """Internal states, shape (s, samples)."""
    return piece.interpolated(piece.state[piece.system.layout.internal_rows])


def _evaluated(system: System, piece: Piece, names: tuple[str, ...]) -> Floats:
    """The same from outputs."""
    bodies = system.mechanism.bodies
    coordinates = {name: coordinate_of(bodies[name].kind) for name in names}
    rates = {name: VARIABLES[output].rate for name, output in coordinates.items()}
    wanted = list(dict.fromkeys([*coordinates.values(), *rates.values()]))
    values = evaluate_variables(Motion(pieces=(piece,)), wanted)
    rows = []
    for outputs in (coordinates, rates):
        for name, output in outputs.items():
            index = labels(system.model, VARIABLES[output].dims[0]).index(name)
            rows.append(values[output][:, index])
    return np.array(rows)
