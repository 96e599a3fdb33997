"""Times at which laws and modes change, and their derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from linkages.design.derived import Derivatives, moved_by
from linkages.errors import ComputationError
from linkages.kernel.differentiation import derivative_along
from linkages.kernel.inputs import Effects
from linkages.kernel.scalars import Level, Scalar
from linkages.kernel.system import System
from linkages.solution.evaluation import evaluate_nodes
from linkages.solution.guards import bisected
from linkages.solution.interpolated import APART, times_between_changes
from linkages.solution.interpolation import between, conditions_of, times_near_dips, unchanged
from linkages.solution.march import March
from linkages.solution.motion import Changed, Motion, Piece

Floats = NDArray[np.float64]

_LOOKS = 4001
"""At how many times it is looked for changes of sign."""

ALIKE = 1e-6
"""Part by which movements of times may differ that belong to one event."""


@dataclass(frozen=True, eq=False)
class Break:
    """A time in s at which laws change branches or modes, with times just before and after it."""

    time: float
    before: float
    behind: float
    moved: Floats  # derivatives of the time by numbers, shape (P,)
    names: tuple[str, ...] = ()  # of the switches whose modes change, the first to change first


def breaks(system: System, nodes: Sequence[Scalar], effects: Effects, end: float) -> list[Break]:
    """All breaks of laws up to the time `end`, ordered."""
    conditions = conditions_of(nodes, Level.TIME)
    if not conditions:
        return []
    model = system.model
    directions = [*model.inputs.fed(effects.fed), {model.inputs.time.index: model.graph.one}]
    rows = derivative_along(conditions, directions)

    def look(times: Floats) -> tuple[Floats, Floats]:
        both = system.evaluate([*conditions, *(row[-1] for row in rows)], times)
        return both[: len(conditions)], both[len(conditions) :]

    times = np.linspace(0.0, end, _LOOKS)
    times = np.union1d(times, times_near_dips(times, *look(times)))
    values, _ = look(times)
    passed: list[Break] = []
    apart = APART * float(np.spacing(end))
    for condition, row, rates in zip(conditions, values, rows, strict=True):
        crossed = (row[:-1] < 0.0) != (row[1:] < 0.0)
        crossed[0] |= row[0] == 0.0  # the other side is before the start
        for k in np.flatnonzero(crossed):
            low, high = times[k : k + 2]
            starts = k == 0 and row[0] == 0.0
            time = 0.0 if starts else _located(system, condition, low, high)
            slopes = system.evaluate(rates, time, further={"slope": effects.slopes[:, None]})[:, 0]
            if slopes.any():  # else it jumps where another one does, on which it depends
                passed.append(Break(time, time - apart, time + apart, moved_by(slopes)))
    return _each_once(sorted(passed, key=lambda each: each.time))


def _each_once(found: Sequence[Break]) -> list[Break]:
    """Breaks without those of other laws that come and move together with the one before."""
    kept: list[Break] = []
    for each in found:
        same = kept and each.before <= kept[-1].behind and np.allclose(each.moved, kept[-1].moved)
        if not same:
            kept.append(each)
    return kept


def merged_breaks(found: Sequence[Break]) -> list[Break]:
    """Breaks in the order of time; those at one time are one, whose movement may not be known."""
    kept: list[Break] = []
    for each in sorted(found, key=lambda one: one.time):
        if not kept or kept[-1].behind < each.before:
            kept.append(each)
            continue
        last = kept.pop()
        alike = np.isclose(each.moved, last.moved, rtol=ALIKE, atol=0.0)
        moved = np.where(alike, last.moved, np.nan)
        kept.append(replace(last, behind=max(last.behind, each.behind), moved=moved))
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


def with_sides(times: Floats, found: Sequence[Break]) -> Floats:
    """Sample times with both sides of breaks, and without what lies between the two."""
    if not found:
        return times
    sides = np.array([[each.before, each.behind] for each in found])
    kept = sides[(sides[:, 0] > times[0]) & (sides[:, 1] < times[-1])]
    after = np.searchsorted(kept[:, 0], times, side="left")
    within = (after > 0) & (times < kept[after - 1, 1]) if len(kept) else np.zeros(len(times), bool)
    return np.unique(np.concatenate([times[~within], kept.ravel()]))


def advance_past_breaks(march: March, times: Floats, found: Sequence[Break]) -> Motion:
    """A motion with derivatives, which jump where laws of drives do."""
    last = float(times[-1])
    pieces: list[Piece] = []
    notes: list[str] = []
    changes: dict[str, Changed] = {}
    for each in [*found, None]:
        if each is not None and not march.time < each.before < each.behind < last:
            if each.before <= march.time:
                march.require_steady(each.before, each.behind)
            continue
        end = last if each is None else each.before
        motion = march.advance(times[(times >= march.time) & (times <= end)])
        notes += motion.notes
        pieces += motion.pieces
        for name, changed in motion.changes.items():
            changes[name] = changes.get(name, Changed.none()).joined(changed)
        if each is None or motion.failure is not None:
            break
        if any(piece.samples is not None for piece in motion.pieces):
            message = "a law of a drive jumps near a change point; no derivative is known"
            raise ComputationError(message, time=end)
        march.step_over(each.behind, each.moved)
    filled = tuple(piece for piece in pieces if len(piece.wanted)) or tuple(pieces[:1])
    return replace(motion, pieces=filled, notes=tuple(notes), changes=changes)


def changing_modes(motion: Motion, end: float) -> list[Break]:
    """All changes of modes within a motion, in the order of time; none moves with numbers yet."""
    met = []
    for name, changes in motion.changes.items():
        times = changes.time if changes.pieces else np.zeros(0)
        if changes.count > len(times):
            message = f"'{name}' changes {changes.count} times, and {len(times)} of them are known"
            raise ComputationError(f"{message}; expected a shorter motion", time=None)
        met += [(float(time), name) for time in times]
    apart = APART * float(np.spacing(end))
    result: list[Break] = []
    for time, name in sorted(met, key=lambda each: each[0]):
        if result and time - apart <= result[-1].behind:
            last = result.pop()
            names = tuple(dict.fromkeys((*last.names, name)))
            result.append(replace(last, behind=time + apart, names=names))
        else:
            result.append(Break(time, time - apart, time + apart, np.zeros(0), (name,)))
    inside = motion.time[0], motion.time[-1]
    return [one for one in result if inside[0] < one.before and one.behind < inside[1]]


def times_around_changes(times: Floats, met: Sequence[Break]) -> Floats:
    """Sample times with both sides of changes, and enough between one change and the next."""
    more = times_between_changes(times, np.array([[one.before, one.behind] for one in met]))
    return with_sides(np.unique(np.concatenate([times, more])), met)


def breaks_of_modes(
    met: Sequence[Break], motion: Motion, effects: Effects, derivatives: Derivatives
) -> list[Break]:
    """The same with how numbers move their times."""
    if not len(effects):
        return [*met]
    result = []
    for one in met:
        piece = _sample(motion, one.before)
        each = derivatives.crossings(piece, one.names, effects)
        size = np.abs(each[0]).max()
        for name, moved in zip(one.names[1:], each[1:], strict=True):
            if not np.abs(moved - each[0]).max() <= ALIKE * size:
                message = f"'{one.names[0]}' and '{name}' change at one time, which numbers part"
                raise ComputationError(f"{message}; there is no derivative", time=one.time)
        result.append(replace(one, moved=each[0]))
    return result


def _sample(motion: Motion, time: float) -> Piece:
    """The sample at a time."""
    for piece in motion.pieces:
        at = np.flatnonzero(piece.time == time)
        if piece.samples is None and len(at):
            return piece.part(at[:1])
    message = "a mode changes within a passage through a change point; no derivative is known"
    raise ComputationError(message, time=time)


def breaks_of_branches(
    nodes: Sequence[Scalar], motion: Motion, effects: Effects, derivatives: Derivatives
) -> list[Break]:
    """All changes of branch between the samples of a motion that nothing is integrated of."""
    conditions = conditions_of(nodes, Level.STATE)
    if not conditions:
        return []
    apart = APART * float(np.spacing(motion.time[-1]))
    result = []
    for piece in motion.pieces:
        if piece.samples is None and len(piece.time) > 1:
            result += [
                Break(time, time - apart, time + apart, moved)
                for condition in conditions
                for time, moved in _of_piece(condition, piece, effects, derivatives)
            ]
    return sorted(result, key=lambda one: one.time)


def _of_piece(
    condition: Scalar, piece: Piece, effects: Effects, derivatives: Derivatives
) -> list[tuple[float, Floats]]:
    """Times in a piece at which a condition changes, and how numbers move them."""
    model = piece.system.model
    clock = {model.inputs.time.index: model.graph.one}
    ((rate,),) = derivative_along([condition], [clock])
    kept = unchanged(piece)
    values, rates = evaluate_nodes(piece, [condition, rate])
    further = times_near_dips(piece.time, values[None], rates[None])
    places = np.union1d(
        np.arange(len(piece.time)) + 0.0, np.interp(further, piece.time, np.arange(len(piece.time)))
    )

    def at(places: Floats) -> Piece:
        interval = np.minimum(places.astype(int), len(kept) - 1)
        return between(piece, interval, places - interval)

    looked = evaluate_nodes(at(places), [condition])[0] if len(further) else values
    side = looked < 0.0
    changes = (side[:-1] != side[1:]) & kept[np.minimum(places[:-1].astype(int), len(kept) - 1)]
    low, high, before = places[:-1][changes], places[1:][changes], side[:-1][changes]
    if not len(low):
        return []
    _, high = bisected(
        low, high, lambda places: (evaluate_nodes(at(places), [condition])[0] < 0.0) == before
    )
    there = at(high)
    _, slopes = derivatives.of_nodes(there, [condition], effects)
    (pace,) = evaluate_nodes(there, [rate])
    by = np.column_stack([slopes[0].T, pace])
    # without any it jumps where another one does, on which it depends
    return [
        (float(time), moved_by(row)) for time, row in zip(there.time, by, strict=True) if row.any()
    ]
