"""Times at which laws of time change from one branch to another, and how numbers move them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from linkages.errors import ComputationError
from linkages.kernel.graph.differentiation import derivative_along
from linkages.kernel.graph.scalars import Level, Scalar, reachable
from linkages.kernel.numbers.effects import Effects
from linkages.kernel.system import System
from linkages.solution.moving.march import March
from linkages.solution.moving.motion import Motion, Piece, Settings, compute_motion

Floats = NDArray[np.float64]

_LOOKS = 4001
"""At how many times it is looked for changes of sign."""

_APART = 8
"""How many roundings of a time lie between it and where laws are on one side for certain."""


@dataclass(frozen=True, eq=False)
class Break:
    """A change of branch at a time.

    Parameters
    ----------
    time, before, behind
        In seconds; just before it and just behind it laws are on one side each.
    moved
        Derivatives of the time by numbers, shape (P,).
    """

    time: float
    before: float
    behind: float
    moved: Floats


def breaks(system: System, nodes: Sequence[Scalar], effects: Effects, end: float) -> list[Break]:
    """All breaks up to `end` that move with numbers, in the order of time.

    Parameters
    ----------
    system
        Whose model the nodes belong to.
    nodes
        What depends on the laws; branches that depend on a state are modes, and left alone.
    effects
        What changes with the numbers.
    end
        Of the motion, in seconds.
    """
    found = {
        node.operands[0]
        for node in reachable(nodes)
        if node.operation == "select" and node.operands[0].level == Level.TIME
    }
    conditions = sorted(found, key=lambda node: node.index)
    if not conditions:
        return []
    model = system.model
    times = np.linspace(0.0, end, _LOOKS)
    values = system.evaluate(conditions, times)
    directions = [*model.inputs.fed(effects.fed), {model.inputs.time.index: model.graph.one}]
    rows = derivative_along(conditions, directions)
    passed: list[Break] = []
    apart = _APART * float(np.spacing(end))
    for condition, row, rates in zip(conditions, values, rows, strict=True):
        crossed = (row[:-1] < 0.0) != (row[1:] < 0.0)
        crossed[0] |= row[0] == 0.0  # the other side is before the start
        for k in np.flatnonzero(crossed):
            low, high = times[k : k + 2]
            starts = k == 0 and row[0] == 0.0
            time = 0.0 if starts else _located(system, condition, low, high)
            slopes = system.evaluate(rates, time, further={"slope": effects.slopes[:, None]})[:, 0]
            if slopes[:-1].any():
                with np.errstate(divide="ignore"):  # without bound where it is only touched
                    moved = -slopes[:-1] / slopes[-1]
                passed.append(Break(time, time - apart, time + apart, moved))
    return _each_once(sorted(passed, key=lambda each: each.time))


def _each_once(found: Sequence[Break]) -> list[Break]:
    """Breaks without those of other laws that come and move together with the one before."""
    kept: list[Break] = []
    for each in found:
        same = kept and each.before <= kept[-1].behind and np.allclose(each.moved, kept[-1].moved)
        if not same:
            kept.append(each)
    return kept


def _located(system: System, condition: Scalar, low: float, high: float) -> float:
    """The first time on the other side of a change of sign, by bisection to neighbouring floats."""
    side = system.evaluate([condition], low)[0, 0] < 0.0
    while low < (middle := 0.5 * (low + high)) < high:
        if (system.evaluate([condition], middle)[0, 0] < 0.0) == side:
            low = middle
        else:
            high = middle
    return float(high)


@dataclass(frozen=True, eq=False)
class Passed:
    """A break that a motion has gone through: its time, and a sample on either side."""

    time: float
    before: Piece
    behind: Piece


def driven_past(system: System, settings: Settings, found: Sequence[Break]) -> list[Passed]:
    """Both sides of breaks in a motion that drives alone determine."""
    if not found:
        return []
    sides = [side for each in found for side in (each.before, each.behind)]
    motion = compute_motion(system, replace(settings, times=np.array([0.0, *sides])))
    samples = [
        piece.part(slice(k, k + 1)) for piece in motion.pieces for k in range(len(piece.time))
    ]
    pairs = zip(found, samples[1::2], samples[2::2], strict=False)
    return [Passed(each.time, before, behind) for each, before, behind in pairs]


def led_past(march: March, times: Floats, found: Sequence[Break]) -> tuple[Motion, list[Passed]]:
    """A motion with derivatives, which jump at breaks, and both sides of these.

    Raises
    ------
    ComputationError
        If a break cannot be passed.
    """
    last = float(times[-1])
    pieces: list[Piece] = []
    passed: list[Passed] = []
    notes: list[str] = []
    sides: list[Piece] = []
    first = 0
    for each in [*found, None]:
        if each is not None and not march.time < each.before < each.behind < last:
            if each.before <= march.time:
                march.require_steady(each.before, each.behind)
            continue
        stop = len(times) if each is None else int(np.searchsorted(times, each.time))
        end = last if each is None else each.before
        # both ends are samples as well: the sides of breaks
        own = np.clip(times[first:stop], march.time, end)
        motion = march.advance(np.unique([march.time, *own, end]))
        notes += motion.notes
        if not found or motion.failure is not None:
            return replace(motion, pieces=(*pieces, *motion.pieces), notes=tuple(notes)), passed
        if any(piece.samples is not None for piece in motion.pieces):
            message = "a law of a drive jumps near a change point; no derivative is known"
            raise ComputationError(message, time=end)
        kept, ends = _kept(motion.pieces, times[first:stop], own)
        pieces += kept
        sides += ends
        if each is None:
            break
        march.step_over(each.behind, each.moved)
        passed.append(Passed(each.time, ends[1], ends[1]))
        first = stop
    passed = [replace(one, behind=sides[2 * k + 2]) for k, one in enumerate(passed)]
    return replace(motion, pieces=tuple(pieces), notes=tuple(notes)), passed


def _kept(
    pieces: Sequence[Piece], times: Floats, own: Floats
) -> tuple[list[Piece], tuple[Piece, Piece]]:
    """The pieces at `times`, which were integrated as `own`, and the first and the last sample."""
    filled = [piece for piece in pieces if len(piece.time)]
    ends = filled[0].part(slice(0, 1)), filled[-1].part(slice(-1, None))
    kept = []
    for piece in filled:
        inside = np.isin(piece.time, own)
        if inside.any():
            one = piece.part(inside)
            kept.append(replace(one, time=times[np.searchsorted(own, one.time)]))
    return kept, ends
