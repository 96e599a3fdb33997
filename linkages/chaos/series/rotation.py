"""Whether an angle librates, rotates, or tumbles between the two."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

TURN = 2 * np.pi

STEADY = 3.0
"""Longest stay, in units of the mean time of a turn, up to which a motion is a rotation."""


class Kind(StrEnum):
    """What an angle does."""

    RESTING = "resting"
    LIBRATION = "libration"
    ROTATION = "rotation"
    MIXED = "mixed"


_FORMER = {"swing": Kind.LIBRATION.value}


@dataclass(frozen=True, eq=False)
class Rotation:
    """What an angle does over a time.

    Parameters
    ----------
    kind
        Resting; libration: its range is less than a turn; rotation: it turns in one sense all the
        time; mixed: it turns in both senses, or librates between turns.
    rate, rate_error
        Mean rate in rad/s, counter-clockwise positive, and the difference of the two halves.
    forward, backward
        Completed turns counter-clockwise and clockwise.
    """

    kind: Kind
    rate: float
    rate_error: float
    forward: int
    backward: int


def classify_angle(time: ArrayLike, angle: ArrayLike, *, resting: float = 1e-6) -> Rotation:
    """Classify an unwrapped angle.

    A turn is completed whenever the angle has moved by 2π from its extreme since the last turn.
    So no direction of zero is needed, and nodding to and fro across one counts no turns.

    Parameters
    ----------
    time
        Increasing, in seconds, shape (n,).
    angle
        In radians with whole turns included, shape (n,), sampled often enough that neighbours are
        less than half a turn apart.
    resting
        Range in radians up to which an angle rests.

    Raises
    ------
    ValueError
        If there are fewer than 8 samples, times do not increase, or neighbours are half a turn or
        more apart: then turns cannot be counted.
    """
    t, theta = np.asarray(time, dtype=float), np.asarray(angle, dtype=float)
    if t.ndim != 1 or t.shape != theta.shape or len(t) < 8:
        raise ValueError("time and angle must have one dimension and 8 or more samples alike")
    if not (np.isfinite(theta).all() and (np.diff(t) > 0).all()):
        raise ValueError("times must increase and angles be finite")
    jump = int(np.argmax(np.abs(np.diff(theta))))
    if abs(theta[jump + 1] - theta[jump]) >= np.pi:
        raise ValueError(
            f"the angle moves by half a turn or more after time {t[jump]:g}: give more samples, "
            "and angles that are not wrapped"
        )
    at, senses = _turns(t, theta)
    marks = np.concatenate([t[:1], at, t[-1:]])
    stay = float(np.diff(marks).max())
    half = len(t) // 2
    halves = _mean_rate(t[: half + 1], theta[: half + 1]), _mean_rate(t[half:], theta[half:])
    return Rotation(
        kind=_kind(t, theta, senses, stay, resting),
        rate=_mean_rate(t, theta),
        rate_error=abs(halves[1] - halves[0]),
        forward=int(np.sum(senses > 0)),
        backward=int(np.sum(senses < 0)),
    )


def refined(time: ArrayLike, angle: ArrayLike) -> tuple[Floats, Floats]:
    """Points in between where neighbouring samples are half a turn apart or more.

    Only for angles whose whole turns were counted on the way, as those of simulations: a link in a
    small clearance may rotate several times between two samples, and `classify_angle` must see
    turns one by one.

    Parameters
    ----------
    time, angle
        Shape (n,), n ≥ 2, as `classify_angle` takes them.
    """
    t, theta = np.asarray(time, dtype=float), np.asarray(angle, dtype=float)
    parts = int(np.abs(np.diff(theta)).max() / (0.5 * np.pi)) + 1
    if parts == 1:
        return t, theta
    known = np.arange(len(t))
    places = np.linspace(0, len(t) - 1, parts * (len(t) - 1) + 1)
    return np.interp(places, known, t), np.interp(places, known, theta)


def renamed(words: NDArray[np.object_]) -> NDArray[np.object_]:
    """Kinds in an array of any shape, with former words of stored files replaced."""
    found = [_FORMER.get(word, word) for word in words.ravel()]
    return np.array(found, dtype=object).reshape(words.shape)


def _kind(t: Floats, theta: Floats, senses: NDArray[np.int64], stay: float, resting: float) -> Kind:
    if np.ptp(theta) <= resting:
        return Kind.RESTING
    if not len(senses):
        return Kind.LIBRATION
    if abs(int(senses.sum())) < len(senses):
        return Kind.MIXED
    steps = np.diff(theta)
    monotonic = (steps >= 0).all() or (steps <= 0).all()
    mean = (t[-1] - t[0]) * TURN / abs(theta[-1] - theta[0])
    return Kind.ROTATION if monotonic or stay <= STEADY * mean else Kind.MIXED


def _turns(t: Floats, theta: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Times of completed turns and their senses."""
    at, senses = [], []
    low = high = float(theta[0])
    for time, angle in zip(t.tolist(), theta.tolist(), strict=True):
        low, high = min(low, angle), max(high, angle)
        if high - low >= TURN:
            sense = 1 if angle == high else -1
            at.append(time)
            senses.append(sense)
            mark = low + TURN if sense > 0 else high - TURN
            low, high = min(mark, angle), max(mark, angle)
    return np.array(at), np.array(senses, dtype=np.int64)


def _mean_rate(t: Floats, theta: Floats) -> float:
    """Mean rate with weights that vanish at both ends.

    For quasi-periodic motions it converges faster than any power of 1/T (S. Das, Y. Saiki,
    E. Sander, J. A. Yorke, Nonlinearity 30 (2017) 4111).
    """
    middle = 0.5 * (t[1:] + t[:-1])
    place = (middle - t[0]) / (t[-1] - t[0])
    weights = np.exp(-1 / (place * (1 - place)))
    return float(np.sum(weights * np.diff(theta)) / np.sum(weights * np.diff(t)))
