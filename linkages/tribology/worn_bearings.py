"""Bearings that wear out of round: what a round journal takes off, and the harmonics of the rest.

Where a journal may have its centre is a convex set with the support function p(θ), the radial
clearance over the angle of the bearing. Under a load it takes off the bearing what stands in its
way: from the place x(θ) at which it touches it gets a little farther, to x + d u(θ), and the set
becomes the convex hull of itself and all such places. That is at least as deep as the layer d, and
is as much deeper as a narrow layer makes the journal take its surroundings off as well. The layer
is scaled so that the volume is that of Archard's law.

Motions take the harmonics of p after Jackson's kernel [1]_. It is positive, so that the radius of
curvature p + p″ stays so, and has the mean 1, so that the mean of p stays as it is.

References
----------
.. [1] D. Jackson, The Theory of Approximation, Amer. Math. Soc. 1930, chapter 1.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from linkages.components.contributed.bearing_profiles import BearingProfile, support_of

Floats = NDArray[np.float64]

BINS = 360
"""Angles of a profile, in the middle of as many parts of a turn."""

ANGLES = (np.arange(BINS) + 0.5) * 2.0 * np.pi / BINS
"""Of a profile in radians."""


def depth_of(profile: BearingProfile | None, size: float) -> Floats:
    """Radial clearance in metres at `ANGLES`, shape (`BINS`,)."""
    if profile is None:
        return np.full(BINS, size)
    return support_of(size, *profile.harmonics, ANGLES)[0]


def hull(support: Floats, layer: Floats) -> Floats:
    """The support function of a set and of places that are a layer beyond its border.

    `support`, `layer`: in metres at `ANGLES`, shape (`BINS`,) each.
    """
    ends = np.roll(support, -1) - np.roll(support, 1)
    across = ends / (2.0 * np.sin(2.0 * np.pi / BINS))  # the middle of each edge of the polygon
    cos, sin = _turns()
    worn = layer > 0.0
    places = (support + layer)[worn] * cos[:, worn] + across[worn] * sin[:, worn]
    return np.asarray(np.maximum(support, places.max(axis=1, initial=-np.inf)))


@cache
def _turns() -> tuple[Floats, Floats]:
    apart = ANGLES[:, None] - ANGLES
    return np.cos(apart), np.sin(apart)


def volume_of(depth: Floats, before: Floats, radius: float, width: float) -> float:
    """Volume in m³ between two depths of a bearing, at `ANGLES`, of a radius and width in m."""
    more = depth - before
    return float((more * (radius + 0.5 * (depth + before))).mean() * 2.0 * np.pi * width)


def worn_depth(
    depth: Floats, layer: Floats, thinner: float, before: Floats, volume: float, radius: float,
    width: float,
) -> Floats:  # fmt: skip
    """Radial clearance of a bearing behind a layer of wear, without what the journal lost.

    Parameters
    ----------
    depth, before
        Radial clearance of the round journal in the bearing now and at first, at `ANGLES` (m).
    layer
        Where wear arises, in proportion.
    thinner
        By how much the radius of the journal is less now (m).
    volume
        That is worn off the bearing in all (m³).
    radius, width
        Of the bearing where its clearance is zero, and of bearing and journal (m).
    """
    wanted = volume - volume_of(depth, before, radius, width)
    if wanted <= 0.0 or not (layer > 0.0).any():
        return depth
    unit = layer / layer.max()

    def at(part: float) -> Floats:
        return np.maximum(hull(depth + thinner, part * unit) - thinner, depth)

    def missing(part: float) -> float:
        return volume_of(at(part), depth, radius, width) - wanted

    high = wanted / (2.0 * np.pi * width * radius * float(unit.mean()))
    while missing(high) < 0.0:
        high *= 2.0
    low_part = brentq(missing, 0.0, high, xtol=1e-14 * high, rtol=1e-15)
    return at(float(low_part))


def harmonics(support: Floats, count: int) -> tuple[float, Floats, Floats]:
    """Mean, and amplitudes of cosines and sines of a radial clearance that is smoothed.

    `support`: in metres at `ANGLES`. Shapes of the amplitudes: (count,).
    """
    order = np.arange(count + 1)
    found = np.fft.rfft(support)[: count + 1] * np.exp(-0.5j * order * 2.0 * np.pi / BINS) / BINS
    found *= jackson(count)
    return float(found[0].real), 2.0 * found[1:].real, -2.0 * found[1:].imag


@cache
def jackson(count: int) -> Floats:
    """Factors of harmonics up to a count of Jackson's kernel, shape (count + 1,).

    It is the fourth power of a sum of cosines: positive, with a width of about π/count.
    """
    half = count // 2
    fejer = np.concatenate([np.arange(1, half + 2), np.arange(half, 0, -1)]).astype(float)
    both = np.convolve(fejer, fejer)
    own = both[len(both) // 2 :]
    return np.asarray(np.append(own, np.zeros(count))[: count + 1] / own[0])
