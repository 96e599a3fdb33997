"""The curve of a phase diagram: smooth between samples, its angle within one turn."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.plots.motion.curves import MANY

Array = NDArray[np.float64]

PARTS = 6  # of the interval between two samples
CELLS = 1600  # along each axis: finer than the pixels of a figure


def refined(
    time: Array, position: Array, speed: Array, acceleration: Array, turn: float = 2 * np.pi
) -> tuple[Array, Array]:
    """Position and speed with points between the samples, by cubic Hermite interpolation.

    A clearance swings within a few samples; straight lines between them would show corners.
    The curve passes through every sample with the slope that it has there.

    Parameters
    ----------
    time, position, speed, acceleration
        Shape (n,), SI units and radians.
    turn
        Jumps of the position by multiples of it are no motion; 0 if there are no such jumps.

    Returns
    -------
    position, speed
        The position without such jumps. Long runs stay as they are.
    """
    parts = min(PARTS, MANY // max(1, len(time)))
    if parts < 2 or len(time) < 2:
        return position, speed
    if turn:
        position = _continuous(time, position, speed, turn)
    return _hermite(time, position, speed, parts), _hermite(time, speed, acceleration, parts)


def _continuous(time: Array, position: Array, speed: Array, turn: float) -> Array:
    """The position without jumps of whole turns: each step is that nearest to speed × time."""
    steps = np.diff(position)
    expected = 0.5 * (speed[:-1] + speed[1:]) * np.diff(time)
    steps -= turn * np.round((steps - expected) / turn)
    return position[0] + np.append(0.0, np.cumsum(steps))


def _hermite(time: Array, values: Array, slopes: Array, parts: int) -> Array:
    """Values at `parts` points of each interval (from its start), and the last value."""
    u = np.arange(parts) / parts
    step = np.diff(time)[:, None]
    start, end = values[:-1, None], values[1:, None]
    inner = (
        start
        + (end - start) * u**2 * (3 - 2 * u)
        + step * (slopes[:-1, None] * u * (1 - u) ** 2 - slopes[1:, None] * u**2 * (1 - u))
    )
    return np.append(inner.ravel(), values[-1])


def wrapped(angle: Array, speed: Array) -> tuple[Array, Array]:
    """The curve with its angle within ±180°, broken where it passes from one end to the other.

    Parameters
    ----------
    angle, speed
        Shape (n,); the angle in radians, within a turn or not.

    Returns
    -------
    angle, speed
        The angle in degrees. At each passage stand the point on one end, a NaN, and the point
        on the other end, so that the curve reaches both ends and never crosses the picture.
    """
    degrees = np.degrees(angle)
    inside = (degrees + 180.0) % 360.0 - 180.0
    inside[inside >= 180.0] = -180.0  # the remainder of a tiny negative number rounds to 360
    passages = np.flatnonzero(np.abs(np.diff(inside)) > 180.0)
    before, after = inside[passages], inside[passages + 1]
    end = np.where(before > after, 180.0, -180.0)
    share = (end - before) / (after + 2.0 * end - before)
    between = speed[passages] + share * (speed[passages + 1] - speed[passages])
    gap = np.full_like(between, np.nan)
    at = np.repeat(passages + 1, 3)
    return (
        np.insert(inside, at, np.column_stack((end, gap, -end)).ravel()),
        np.insert(speed, at, np.column_stack((between, gap, between)).ravel()),
    )


def spread(x: Array, y: Array) -> tuple[Array, Array]:
    """One point of each cell of a fine grid: the same picture with fewer dots."""
    points = np.column_stack((x, y))
    points = points[np.isfinite(points).all(axis=1)]
    if not len(points):
        return points[:, 0], points[:, 1]
    low, size = points.min(axis=0), np.maximum(np.ptp(points, axis=0), 1e-300)
    cells = ((points - low) / size * (CELLS - 1)).astype(np.int64)
    _, first = np.unique(cells[:, 0] * CELLS + cells[:, 1], return_index=True)
    return points[first, 0], points[first, 1]
