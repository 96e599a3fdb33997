"""Times at which modes of a free motion change, and how numbers move them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.design.sensitivity.breaks import ALIKE, Break, with_sides
from linkages.design.sensitivity.derived import Derivatives
from linkages.errors import ComputationError
from linkages.kernel.numbers.effects import Effects
from linkages.solution.measuring.followed import APART, between_sides
from linkages.solution.moving.motion import Motion, Piece

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class ModeChange:
    """Modes that change at a time, in a row.

    Parameters
    ----------
    time, before, behind
        As `Break` has them.
    names
        Of the switches, the first to change first.
    """

    time: float
    before: float
    behind: float
    names: tuple[str, ...]


def changing_modes(motion: Motion, end: float) -> list[ModeChange]:
    """All changes of modes within a motion, in the order of time.

    Raises
    ------
    ComputationError
        If there were more than a motion keeps.
    """
    met = []
    for name, changes in motion.changes.items():
        times = changes.time if changes.pieces else np.zeros(0)
        if changes.count > len(times):
            message = f"'{name}' changes {changes.count} times, and {len(times)} of them are known"
            raise ComputationError(f"{message}; expected a shorter motion", time=None)
        met += [(float(time), name) for time in times]
    apart = APART * float(np.spacing(end))
    found: list[ModeChange] = []
    for time, name in sorted(met, key=lambda each: each[0]):
        if found and time - apart <= found[-1].behind:
            last = found.pop()
            names = tuple(dict.fromkeys((*last.names, name)))
            found.append(ModeChange(last.time, last.before, time + apart, names))
        else:
            found.append(ModeChange(time, time - apart, time + apart, (name,)))
    inside = motion.time[0], motion.time[-1]
    return [one for one in found if inside[0] < one.before and one.behind < inside[1]]


def followed_closely(times: Floats, met: Sequence[ModeChange]) -> Floats:
    """Sample times with both sides of changes, and enough between one change and the next."""
    more = between_sides(times, np.array([[one.before, one.behind] for one in met]))
    return with_sides(np.unique(np.concatenate([times, more])), met)


def as_breaks(
    met: Sequence[ModeChange], motion: Motion, effects: Effects, derivatives: Derivatives
) -> list[Break]:
    """The same with how numbers move their times.

    Parameters
    ----------
    met
        Changes of modes.
    motion
        With derivatives, and samples on both sides of the changes.
    effects, derivatives
        What changes with the numbers, and how.

    Raises
    ------
    ComputationError
        If several modes change at one time that numbers move apart.
    """
    if not len(effects):
        return [Break(one.time, one.before, one.behind, np.zeros(0)) for one in met]
    found = []
    for one in met:
        piece = _sample(motion, one.before)
        each = derivatives.crossings(piece, one.names, effects)
        size = np.abs(each[0]).max()
        for name, moved in zip(one.names[1:], each[1:], strict=True):
            if not np.abs(moved - each[0]).max() <= ALIKE * size:
                message = f"'{one.names[0]}' and '{name}' change at one time, which numbers part"
                raise ComputationError(f"{message}; there is no derivative", time=one.time)
        found.append(Break(one.time, one.before, one.behind, each[0]))
    return found


def _sample(motion: Motion, time: float) -> Piece:
    """The sample at a time."""
    for piece in motion.pieces:
        at = np.flatnonzero(piece.time == time)
        if piece.samples is None and len(at):
            return piece.part(at[:1])
    message = "a mode changes within a passage through a change point; no derivative is known"
    raise ComputationError(message, time=time)
