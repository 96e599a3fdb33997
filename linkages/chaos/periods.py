"""Periodicity of section points, and rotation of angles."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.chaos.tori import checked_points

Floats = NDArray[np.float64]

REPEATS = 3
"""How often a period must be seen."""


@dataclass(frozen=True, eq=False)
class Period:
    """The period of a sequence of section points."""

    # Section points until the motion repeats; None if it does not within what was seen
    count: int | None
    # Largest difference of points so far apart, in units of the tolerance; where there is no
    # period, the least that any number reaches
    deviation: float
    # The points of one period, in the order of the motion, shape (count, d); last of all
    cycle: Floats


def find_period(
    points: ArrayLike,
    *,
    angles: ArrayLike | None = None,
    tolerance: ArrayLike = 1e-4,
    longest: int | None = None,
) -> Period:
    """Smallest m for which every point is repeated m points later, and at the end.

    The last points count for all: where neighbours are alike, but drift (in laminar phases of
    intermittency), nothing repeats.

    `points`: section points after the transient, shape (n, d).
    `angles`: which entries are angles, shape (d,); they repeat modulo 2π.
    `tolerance`: largest difference that counts as a repetition, in the units of the entries: one
    number or shape (d,). Near a bifurcation two points of a cycle may be closer than this.
    """
    whole, mask = checked_points(points, angles)
    most = len(whole) // REPEATS if longest is None else longest
    if not 1 <= most <= len(whole) // REPEATS:
        raise ValueError(
            f"{len(whole)} points show periods from 1 to {len(whole) // REPEATS}, not {most}"
        )
    scale = np.broadcast_to(np.asarray(tolerance, dtype=float), whole.shape[1:])
    if not (scale > 0).all():
        raise ValueError("tolerance must be > 0")
    least = np.inf
    for count in range(1, most + 1):
        deviation = float(differences(whole[count:], whole[:-count], mask, scale).max())
        cycle = whole[-count:]
        if deviation <= 1.0:
            again = cycle[(np.arange(len(whole)) - len(whole)) % count]
            deviation = float(differences(whole, again, mask, scale).max())
        if deviation <= 1.0:
            return Period(count, deviation, cycle.copy())
        least = min(least, deviation)
    return Period(None, least, np.empty((0, whole.shape[1])))


def differences(
    points: Floats, others: Floats, angles: NDArray[np.bool_], tolerance: Floats
) -> Floats:
    """Largest difference of any entry of points, in tolerances, shape (n,); of angles modulo 2π."""
    # what overflows is further apart than any tolerance: infinite, or nan where that is, too
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        result = apart(points, others, angles)
        away = result != 0.0  # what is equal is within a tolerance of zero as well
        result = np.divide(np.abs(result), tolerance, out=np.zeros_like(result), where=away)
    return np.asarray(np.max(np.where(np.isnan(result), np.inf, result), axis=1))


def apart(points: Floats, others: Floats, angles: NDArray[np.bool_]) -> Floats:
    """Differences of the entries of points, shape (n, d); of angles from −π to π."""
    result = points - others
    result[:, angles] = np.remainder(result[:, angles] + np.pi, 2 * np.pi) - np.pi
    return result


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

    `kind`: resting; libration: its range is less than a turn; rotation: it turns in one sense all
    the time; mixed: it turns in both senses, or librates between turns.
    `rate`, `rate_error`: mean rate in rad/s, counter-clockwise positive, and the difference of the
    two halves.
    `forward`, `backward`: completed turns counter-clockwise and clockwise.
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

    `time`: increasing, in seconds, shape (n,).
    `angle`: in radians with whole turns included, shape (n,), sampled often enough that neighbours
    are less than half a turn apart.
    `resting`: range in radians up to which an angle rests.
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

    `time`, `angle`: shape (n,), n ≥ 2, as `classify_angle` takes them.
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
    result = [_FORMER.get(word, word) for word in words.ravel()]
    return np.array(result, dtype=object).reshape(words.shape)


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
