"""Driven motions: positions are solved directly at each time.

Between two samples a bar may turn any number of times. The interval is halved until the speeds at
the ends of every part determine how far it turns there.

Blocks are solved one after the other, from as many equations as they have unknowns. Where one of
them is singular, a redundant equation elsewhere may still determine the motion: then this is no
change point. A grid of at most one degree of every drive is searched for positions that cannot be
assembled, and for margins that approach zero from both ends of an interval.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.terms import GUIDED
from linkages.kernel.system import System
from linkages.solution.driven_limits import BOTH_SIDES, DrivenPassage, Limits, chunks
from linkages.solution.evaluation import evaluate_nodes
from linkages.solution.guards import driven_piece, passed_piece
from linkages.solution.motion import Motion, Piece, Settings, passes
from linkages.solution.stop_messages import (
    COULD_PASS,
    FOUND_NONE,
    block_failure,
    passed_text,
    undefined_load,
)
from linkages.topology.topology import distance_from_singular

_GRID_ANGLE = math.radians(10.0)
"""Most that a drive may turn between two places that are compared."""

_MOST_TURNED = 1.0
"""Most that a bar may turn between two such places, by its speed at either, in radians."""

_CLOSE = 0.3
"""How well the mean of both speeds must tell how far it turned, in radians: whole turns cannot hide
in that."""

_HALVINGS = 50
"""Where an angle jumps, as by a law of time that does, the last part is as short as round-off."""

Floats = NDArray[np.float64]


def with_turns(pieces: list[Piece], fastest: float) -> list[Piece]:
    """Count the turns of dependent angles; `fastest` is the highest speed of a drive in rad/s."""
    names = pieces[0].system.topology.counted
    if not names:
        return pieces
    reached: tuple[float, Floats] | None = None
    result = []
    for piece in pieces:
        start = piece if piece.samples is None else piece.part(slice(0, 1))
        angles = _along(start, reached, fastest)
        if piece.samples is not None:
            angles = _angles_across(piece, angles)
        if len(piece.time):
            reached = float(piece.time[-1]), angles[:, -1]
        result.append(replace(piece, counted=dict(zip(names, angles, strict=True))))
    return result


def _angles_and_speeds(
    piece: Piece, times: Floats, flipped: Mapping[int, NDArray[np.bool_]] | None = None
) -> tuple[Floats, Floats]:
    """Dependent angles within one turn and their speeds, in the mode of a piece, (bars, times)."""
    model = piece.system.model
    names = piece.system.topology.counted
    nodes = [model.positions.angle(name) for name in names]
    nodes += [model.velocities.turning(name) for name in names]
    if flipped is None:
        flipped = {
            block: np.repeat(where[:1], len(times)) for block, where in piece.flipped.items()
        }
    values = piece.system.evaluate(nodes, times, flipped=flipped)
    return values[: len(names)], values[len(names) :]


def _along(piece: Piece, reached: tuple[float, Floats] | None, fastest: float) -> Floats:
    """Angles at the times of a piece, from the time and the angles that were reached before it."""
    result = np.zeros((len(piece.system.topology.counted), len(piece.time)))
    begun, angles = (0.0, None) if reached is None else reached
    for places in chunks(piece.time, fastest, begun, _GRID_ANGLE) if len(piece.time) else ():
        values = _angles_and_speeds(piece, places)
        first = values[0][:, 0] if angles is None else angles
        change = _changes(piece, places, *values, fastest)
        along = first[:, None] + np.cumsum(np.insert(change, 0, 0.0, axis=1), axis=1)
        wanted, at = np.isin(piece.time, places), np.isin(places, piece.time)
        result[:, wanted] = along[:, at]
        angles = along[:, -1]
    return result


def _changes(piece: Piece, times: Floats, angles: Floats, speeds: Floats, fastest: float) -> Floats:
    """How far each angle turns from one time to the next, shape (bars, times − 1)."""
    total = np.zeros((len(times) - 1, len(angles)))
    owner = np.arange(len(total))
    ends = [np.stack([part[..., :-1], part[..., 1:]]) for part in (times, angles, speeds)]
    for halving in range(_HALVINGS + 1):
        when, where, speed = ends
        span = when[1] - when[0]
        change, each = turned_by(where, speed, span)
        sure = each.all(axis=0) & (fastest * np.abs(span) <= 1.01 * _GRID_ANGLE)
        sure |= halving == _HALVINGS
        np.add.at(total, owner[sure], change.T[sure])
        if sure.all():
            break
        owner = np.tile(owner[~sure], 2)
        middle = 0.5 * (when[0] + when[1])[~sure]
        halves = (middle, *_angles_and_speeds(piece, middle))
        ends = [
            np.stack(
                [
                    np.concatenate([pair[0][..., ~sure], half], axis=-1),
                    np.concatenate([half, pair[1][..., ~sure]], axis=-1),
                ]
            )
            for pair, half in zip(ends, halves, strict=True)
        ]
    return total.T


def turned_by(angles: Floats, speeds: Floats, spans: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """How far angles turn within short times, and where that excludes a hidden whole turn.

    `angles` and `speeds` are those of both ends, shape (2, …, times).
    """
    expected = 0.5 * (speeds[0] + speeds[1]) * spans
    missed = angles[1] - angles[0] - expected
    missed -= 2 * np.pi * np.round(missed / (2 * np.pi))
    sure = np.abs(missed) <= _CLOSE
    sure &= np.abs(speeds).max(axis=0) * np.abs(spans) <= _MOST_TURNED
    return expected + missed, sure


def _angles_across(piece: Piece, first: Floats) -> Floats:
    """Angles at the times of a passage through a change point, from those at its first one."""
    from linkages.solution.quadrature import integral_across

    angles, speeds = _angles_and_speeds(piece, piece.time, piece.flipped)
    expected = first + integral_across(piece, speeds)
    return angles + 2 * np.pi * np.round((expected - angles) / (2 * np.pi))


LEAST_DISTANCE = 1e-6
"""Smallest over largest singular value of the closure from which on it is regular.

Positions in a singular position are interpolated; of a true one they leave 1e-9 or less.
"""


def is_determined(piece: Piece) -> bool:
    """Whether the whole closure is regular in the middle of a piece that leads across."""
    system = piece.system
    if not system.topology.redundant:
        return False
    from linkages.solution.change_points import closure_nodes, closure_of

    rows = evaluate_nodes(piece, closure_nodes(system))
    middle = replace(piece, samples=np.array([piece.crossing])).interpolated(rows)
    _, jacobian = closure_of(system, middle)
    distance = distance_from_singular(system.topology, jacobian, system.topology.free)
    return distance >= LEAST_DISTANCE


_LAW_PLACES = 20001


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
            pieces.append(Piece.driven(system, times[reached & (abs(times) < early)], flipped))
            inside = times[(abs(times) >= early) & (abs(times) < abs(begun))]
            pieces.append(_across(system, passage, flipped, inside))
            span = before, math.copysign(early, times[-1])
            for event in settings.events:
                result = driven_piece(event, pieces[-2], *span, highest)
                crossed[event.name] += [result, passed_piece(event, pieces[-1])]
            if not determined:
                notes.append(passed_text(system.model, passage.crossing, passage.blocks))
            flipped = tuple(sorted(set(flipped) ^ set(passage.blocks)))
            if abs(begun) > abs(times[-1]):
                stop = None
                break
            continue
        if stop is not None:
            reached &= np.abs(times) < abs(stop.time)
        pieces.append(Piece.driven(system, times[reached], flipped))
        last = float(times[-1]) if stop is None else stop.time
        for event in settings.events:
            result = driven_piece(event, pieces[-1], begun, last, highest)
            crossed[event.name].append(result)
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
        from linkages.solution.quadrature import with_work

        pieces = with_work(pieces, highest, settings.run.most_steps)
    return Motion(
        pieces=tuple(pieces),
        failure=failure,
        stop_time=end if stop is None else stop.time,
        notes=tuple(notes),
        crossings={name: Motion(pieces=tuple(item)) for name, item in crossed.items()},
    )


def _undefined(system: System, times: Floats) -> _Undefined | None:
    """Where the law of a drive first has no finite value or derivative, or a load no value."""
    result = []
    for name, law in system.model.positions.laws.items():
        values = system.evaluate([law.value, law.rate, law.acceleration], times)
        finite = np.isfinite(values).all(axis=0)
        if not finite.all():
            first = int(np.argmin(finite))
            text = f"at t = {times[first]:.9g} s: the law of drive {name} has no finite value or "
            result.append((first, f"{text}derivative. End before, or change the law."))
    load = undefined_load(system, times)
    if load is not None:
        result.append(load)
    return _Undefined(*min(result)) if result else None


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
        Piece.driven(system, times, ()),
        flipped={**modes, **kept},
        samples=samples,
        crossing=passage.crossing,
    )


def fastest(system: System, end: float) -> float:
    """Highest speed of a drive on the way to `end`; a slider's in lengths of the mechanism."""
    if not system.topology.driven:
        return 0.0
    bodies = system.mechanism.bodies
    aside = {body.axis for body in bodies.values() if body.kind == GUIDED}  # they begin anywhere
    places = np.array([place for name, place in system.places().items() if name not in aside])
    size = float(np.ptp(places, axis=0).max()) or 1.0
    rates = [system.model.known_rates[name] for name in system.topology.driven]
    values = np.abs(system.evaluate(rates, np.linspace(0.0, end, _LAW_PLACES))).max(axis=1)
    return max(
        float(value) if bodies[name].rotates else float(value) / size
        for name, value in zip(system.topology.driven, values, strict=True)
    )


def slack_times(motion: Motion) -> list[float]:
    """Times of a motion at which actuators cannot hold what drives prescribe.

    There the output `dexterity` changes its sign. Driven motions are searched in steps of at most a
    degree of a drive, others between their samples.
    """
    result: list[float] = []
    for piece in motion.pieces:
        system, times = piece.system, piece.time
        if not system.model.actuators or len(times) < 2 or piece.samples is not None:
            continue
        driven = not system.topology.coordinates
        if driven:
            grid = chunks(times, fastest(system, float(times[-1])), float(times[0]))
            times = np.unique(np.concatenate([*grid]))
            values = _dexterity(piece, times)
        else:
            values = evaluate_nodes(piece, [system.model.actuated.dexterity])[0]
        for k in np.flatnonzero(values[:-1] * values[1:] < 0.0):
            low, high = float(times[k]), float(times[k + 1])
            if driven:
                from scipy.optimize import brentq

                at = partial(_dexterity, piece)
                result.append(float(brentq(lambda t, at=at: at(np.array([t]))[0], low, high)))
            else:
                result.append(low + float(values[k] / (values[k] - values[k + 1])) * (high - low))
    return result


def _dexterity(piece: Piece, times: Floats) -> Floats:
    """At other times of a driven piece."""
    flags = {block: np.repeat(where[:1], len(times)) for block, where in piece.flipped.items()}
    made = replace(Piece.driven(piece.system, times, ()), flipped=flags)
    return evaluate_nodes(made, [piece.system.model.actuated.dexterity])[0]


MOST_NAMED = 5
"""Times that a note lists."""


def slack_notes(motion: Motion) -> list[str]:
    """That efforts of actuators grow without bound, and when."""
    times = slack_times(motion)
    if not times:
        return []
    named = ", ".join(f"{time:.9g}" for time in times[:MOST_NAMED])
    more = f" and {len(times) - MOST_NAMED} times more" if len(times) > MOST_NAMED else ""
    return [
        f"at t = {named} s{more} the actuators cannot hold what the drives prescribe (a singular "
        "position, 'dexterity' is zero): their efforts grow without bound towards it, so that "
        "largest values around it mean nothing"
    ]
