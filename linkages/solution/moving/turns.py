"""Whole turns of dependent angles along a motion that is not integrated.

Between two samples a bar may turn any number of times. The way from one to the other is halved
until the speeds at both ends of every part leave no doubt how far it turns there. Where something
is integrated, the solvers count (`linkages.solvers.watched.counting`).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from linkages.solution.moving.limits import chunks
from linkages.solution.moving.motion import Piece
from linkages.solution.moving.work import integral_across

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
    """Count the turns of dependent angles at the times of all pieces.

    Parameters
    ----------
    pieces
        Of one motion, in their order.
    fastest
        Highest speed of a drive in rad/s (or in sizes of the mechanism per second).
    """
    names = pieces[0].system.topology.counted
    if not names:
        return pieces
    reached: tuple[float, Floats] | None = None
    result = []
    for piece in pieces:
        start = piece if piece.samples is None else piece.part(slice(0, 1))
        angles = _along(start, reached, fastest)
        if piece.samples is not None:
            angles = _across(piece, angles)
        if len(piece.time):
            reached = float(piece.time[-1]), angles[:, -1]
        result.append(replace(piece, counted=dict(zip(names, angles, strict=True))))
    return result


def _angles_and_speeds(piece: Piece, times: Floats) -> tuple[Floats, Floats]:
    """Dependent angles within one turn and their speeds, in the mode of a piece, (bars, times)."""
    model = piece.system.model
    names = piece.system.topology.counted
    nodes = [model.positions.angle(name) for name in names]
    nodes += [model.velocities.turning(name) for name in names]
    modes = {block: np.repeat(where[:1], len(times)) for block, where in piece.flipped.items()}
    values = piece.system.evaluate(nodes, times, flipped=modes)
    return values[: len(names)], values[len(names) :]


def _along(piece: Piece, reached: tuple[float, Floats] | None, fastest: float) -> Floats:
    """Angles at the times of a piece, from the time and the angles that were reached before it."""
    found = np.zeros((len(piece.system.topology.counted), len(piece.time)))
    begun, angles = (0.0, None) if reached is None else reached
    for places in chunks(piece.time, fastest, begun, _GRID_ANGLE) if len(piece.time) else ():
        values = _angles_and_speeds(piece, places)
        first = values[0][:, 0] if angles is None else angles
        change = _changes(piece, places, *values, fastest)
        along = first[:, None] + np.cumsum(np.insert(change, 0, 0.0, axis=1), axis=1)
        wanted, at = np.isin(piece.time, places), np.isin(places, piece.time)
        found[:, wanted] = along[:, at]
        angles = along[:, -1]
    return found


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
    """How far angles turn within short times, and where no whole turn can hide in that.

    Parameters
    ----------
    angles, speeds
        At both ends, shape (2, …, times); angles within one turn.
    spans
        How long, shape (times,).
    """
    expected = 0.5 * (speeds[0] + speeds[1]) * spans
    missed = angles[1] - angles[0] - expected
    missed -= 2 * np.pi * np.round(missed / (2 * np.pi))
    sure = np.abs(missed) <= _CLOSE
    sure &= np.abs(speeds).max(axis=0) * np.abs(spans) <= _MOST_TURNED
    return expected + missed, sure


def _across(piece: Piece, first: Floats) -> Floats:
    """Angles at the times of a passage through a change point, from those at its first one."""
    model = piece.system.model
    names = piece.system.topology.counted
    nodes = [model.positions.angle(name) for name in names]
    nodes += [model.velocities.turning(name) for name in names]
    values = piece.system.evaluate(nodes, piece.time, flipped=piece.flipped)
    expected = first + integral_across(piece, values[len(names) :])
    turns = np.round((expected - values[: len(names)]) / (2 * np.pi))
    return values[: len(names)] + 2 * np.pi * turns
