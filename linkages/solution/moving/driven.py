"""Motions without free coordinates: positions follow from time, nothing is integrated.

Only whether the mechanism can get from one sample to the next has to be found out. A grid that is
at least as fine as one degree of every drive is searched for positions that cannot be assembled,
and for margins that head for zero on one side of an interval and come from zero on the other.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.system import System
from linkages.solution.moving.determined import is_determined
from linkages.solution.moving.guards import driven_piece, passed_piece
from linkages.solution.moving.limits import BOTH_SIDES, DrivenPassage, Limits
from linkages.solution.moving.motion import Motion, Piece, Settings
from linkages.solution.moving.switching import passes
from linkages.solution.moving.turns import with_turns
from linkages.solution.moving.work import with_work
from linkages.solution.remarks.stops import COULD_PASS, FOUND_NONE, block_failure, passed_text
from linkages.solution.remarks.undefined import undefined_load

_LAW_PLACES = 20001

Floats = NDArray[np.float64]


class _Undefined(NamedTuple):
    """The first sample that cannot be computed, and why not."""

    sample: int
    text: str


def driven_motion(system: System, settings: Settings) -> Motion:
    """Follow a fully driven system from t = 0 along the sample times as far as it can go."""
    if settings.times[0] == 0.0:
        return _followed(system, settings)
    # turns and work count from t = 0 on, whenever the first sample is taken
    motion = _followed(system, replace(settings, times=np.append(0.0, settings.times)))
    first = motion.pieces[0]
    if first.samples is None:
        first = first.part(slice(1, None))
    else:
        first = replace(first, samples=first.samples[1:])
    return replace(motion, pieces=(first, *motion.pieces[1:]))


def _followed(system: System, settings: Settings) -> Motion:
    undefined = _undefined(system, settings.times)
    end = float(settings.times[-1])
    if undefined is not None:
        end = float(settings.times[undefined.sample])
        settings = replace(settings, times=settings.times[: undefined.sample])
    times = settings.times
    highest = fastest(system, float(times[-1]))
    pieces: list[Piece] = []
    crossed: dict[str, list[Piece]] = {event.name: [] for event in settings.events}
    notes: list[str] = []
    flipped: tuple[int, ...] = ()
    begun = 0.0
    passing = passes(system, settings.run)
    looking = passing or system.topology.redundant
    while True:
        limits = Limits(system, flipped, highest)
        stop = limits.first_stop(settings, begun)
        passage = limits.passage(stop) if stop and stop.singular and looking else None
        across = None if passage is None else _across(system, passage, flipped, times[:0])
        determined = across is not None and is_determined(across)
        if not (passing or determined):
            passage = None
        reached = abs(times) >= abs(begun) if begun else np.ones(len(times), dtype=bool)
        if passage is not None:
            before = begun
            begun = passage.crossing + math.copysign(passage.beside, times[-1])
            early = abs(passage.crossing) - passage.beside
            pieces.append(_piece(system, times[reached & (abs(times) < early)], flipped))
            inside = times[(abs(times) >= early) & (abs(times) < abs(begun))]
            pieces.append(_across(system, passage, flipped, inside))
            span = before, math.copysign(early, times[-1])
            for event in settings.events:
                found = driven_piece(event, pieces[-2], *span, highest)
                crossed[event.name] += [found, passed_piece(event, pieces[-1])]
            if not determined:
                notes.append(passed_text(system.model, passage.crossing, passage.blocks))
            flipped = tuple(sorted(set(flipped) ^ set(passage.blocks)))
            if abs(begun) > abs(times[-1]):
                stop = None
                break
            continue
        if stop is not None:
            reached &= np.abs(times) < abs(stop.time)
        pieces.append(_piece(system, times[reached], flipped))
        last = float(times[-1]) if stop is None else stop.time
        for event in settings.events:
            found = driven_piece(event, pieces[-1], begun, last, highest)
            crossed[event.name].append(found)
        break
    failure = None
    if stop is not None:
        where = stop.block, stop.time, stop.singular
        failure = block_failure(system.model, *where, FOUND_NONE if passing else COULD_PASS)
    elif undefined is not None:
        failure = undefined.text
    if settings.counting:
        pieces = with_turns(pieces, highest)
    if settings.work:
        pieces = with_work(pieces, highest, settings.run.most_steps)
    return Motion(
        pieces=tuple(pieces),
        failure=failure,
        stop_time=end if stop is None else stop.time,
        notes=tuple(notes),
        crossings={name: Motion(pieces=tuple(found)) for name, found in crossed.items()},
    )


def _undefined(system: System, times: Floats) -> _Undefined | None:
    """Where the law of a drive first has no finite value or derivative, or a load no value."""
    found = []
    for name, law in system.model.positions.laws.items():
        values = system.evaluate([law.value, law.rate, law.acceleration], times)
        finite = np.isfinite(values).all(axis=0)
        if not finite.all():
            first = int(np.argmin(finite))
            text = f"at t = {times[first]:.9g} s: the law of drive {name} has no finite value or "
            found.append((first, f"{text}derivative. End before, or change the law."))
    load = undefined_load(system, times)
    if load is not None:
        found.append(load)
    return _Undefined(*min(found)) if found else None


def _piece(system: System, times: Floats, flipped: tuple[int, ...]) -> Piece:
    nothing = np.zeros((0, len(times)))
    return Piece(
        system=system,
        time=times,
        state=nothing,
        turns=nothing,
        acceleration=nothing,
        flipped={block: np.ones(len(times), dtype=bool) for block in flipped},
    )


def _across(
    system: System, passage: DrivenPassage, flipped: tuple[int, ...], samples: Floats
) -> Piece:
    """Samples within a passage, to be interpolated from times on both sides of it."""
    times = passage.crossing + passage.beside * BOTH_SIDES * math.copysign(1.0, passage.crossing)
    beyond = BOTH_SIDES > 0
    modes = {
        block: beyond != (block in flipped) for block in {*flipped, *passage.blocks}
        if block in passage.blocks
    }  # fmt: skip
    kept = {b: np.ones(len(times), dtype=bool) for b in flipped if b not in passage.blocks}
    return replace(
        _piece(system, times, ()),
        flipped={**modes, **kept},
        samples=samples,
        crossing=passage.crossing,
    )


def fastest(system: System, end: float) -> float:
    """Highest speed of a drive on the way to `end`; a slider's in lengths of the mechanism."""
    if not system.topology.driven:
        return 0.0
    places = np.array(list(system.places().values()))
    size = float(np.ptp(places, axis=0).max()) or 1.0
    rates = [system.model.known_rates[name] for name in system.topology.driven]
    values = np.abs(system.evaluate(rates, np.linspace(0.0, end, _LAW_PLACES))).max(axis=1)
    bodies = system.mechanism.bodies
    return max(
        float(value) if bodies[name].rotates else float(value) / size
        for name, value in zip(system.topology.driven, values, strict=True)
    )
