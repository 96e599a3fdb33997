"""Guards: functions of a motion whose zeros are found, whatever coordinates it is integrated in."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.model import Model
from linkages.kernel.scalars import Scalar
from linkages.kernel.system import System
from linkages.solution.evaluation import evaluate_nodes
from linkages.solution.motion import Motion, Piece
from linkages.solution.plan import Plan
from linkages.solvers.events import Event

Floats = NDArray[np.float64]

AT_ONCE = 10_000
"""Crossings for which there is room at first, where no number is wanted."""

WITHIN = 129
"""Places of a step through a change point at which signs are compared."""


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
    """

    nodes: Callable[[Model], tuple[Scalar, Scalar]]
    direction: int = 0
    wanted: int = 0
    counts: Callable[[Piece], NDArray[np.bool_]] | None = None
    key: Hashable = None


class Watched:
    """Crossings of a guard, as they come in.

    Parameters
    ----------
    guard
        What is watched.
    """

    def __init__(self, guard: Guard) -> None:
        self._guard = guard
        self._pieces: list[Piece] = []
        self._wider = 1

    @property
    def _count(self) -> int:
        return sum(len(piece.time) for piece in self._pieces)

    @property
    def done(self) -> bool:
        """Whether it was crossed as often as it wants."""
        return 0 < self._guard.wanted <= self._count

    @property
    def motion(self) -> Motion:
        """The states at the crossings."""
        return Motion(pieces=tuple(self._pieces)).part(last=self._guard.wanted or None)

    def event(self, plan: Plan, system: System, flipped: tuple[int, ...]) -> Event:
        """What the next integration of a system is to watch."""
        wanted = self._guard.wanted
        room = self._wider * (wanted - self._count if wanted else AT_ONCE)
        return Event(
            function=plan.watch(system, self._guard.nodes, self._guard.key, flipped),
            direction=self._guard.direction,
            terminal=room,
            capacity=room,
        )

    def widen(self) -> None:
        """Make room for twice as many crossings."""
        self._wider *= 2

    def enough(self, piece: Piece) -> bool:
        """Whether it is done with the crossings of another piece."""
        wanted = self._guard.wanted
        return 0 < wanted <= self._count + len(self._counting(piece).time)

    def _counting(self, piece: Piece) -> Piece:
        """The crossings that count."""
        if self._guard.counts is None or not len(piece.time):
            return piece
        return piece.part(self._guard.counts(piece))

    def add(self, piece: Piece) -> None:
        """Take the crossings that an integration met."""
        self._pieces.append(self._counting(piece))

    def add_within(self, piece: Piece) -> None:
        """Take those of a step through a change point, from what is interpolated there."""
        from scipy.interpolate import BarycentricInterpolator
        from scipy.optimize import brentq

        values = evaluate_nodes(piece, [self._guard.nodes(piece.system.model)[0]])[0]
        polynomial = BarycentricInterpolator(piece.time, values)
        places = np.linspace(piece.time[0], piece.time[-1], WITHIN)
        signs = np.sign(polynomial(places))
        changes = np.flatnonzero(signs[1:] * signs[:-1] < 0)
        changes = changes[signs[changes + 1] * self._guard.direction >= 0]
        found = [brentq(polynomial, places[k], places[k + 1], xtol=1e-15) for k in changes]
        if found:
            self.add(replace(piece, samples=np.array(found)).direct())
