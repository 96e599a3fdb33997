"""Arrows of forces, whose scale stays the same over a film."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.plots.prefixes import largest_magnitude, nice_below, scale_for

Array = NDArray[np.float64]

NARROW = 0.2
"""Arrows show the root of forces if a tenth of these are less than this much of the largest."""

NOTHING = 1e-9
"""Of the largest force: no force."""

SHORTEST = 0.2
"""Of the longest arrow: as long is that of any force, so that it is seen."""

ROOT = "arrows ∝ √F"
"""What is written where lengths are no multiples of forces."""


@dataclass(frozen=True)
class ArrowScale:
    """How long arrows are, over the longest one.

    Parameters
    ----------
    full
        What the longest stands for, in SI units; 0 if there is nothing to show.
    units
        Of forces or torques.
    root
        Whether lengths go with the root of a force, else with the force.
    """

    full: float
    units: str = "N"
    root: bool = False

    @classmethod
    def of(cls, values: Iterable[ArrayLike], units: str = "N") -> ArrowScale:
        """A scale for all values of a film: to the largest, by the root if their range is great."""
        flat = [np.ravel(np.asarray(own, dtype=float)) for own in values]
        sizes = np.abs(np.concatenate([np.empty(0), *flat]))
        full = largest_magnitude(sizes)
        acting = sizes[np.isfinite(sizes) & (sizes > NOTHING * full)]
        root = bool(len(acting)) and bool(np.quantile(acting, 0.1) < NARROW * full)
        return cls(full, units, root)

    @property
    def key(self) -> float:
        """A round value whose arrow explains the scale."""
        return nice_below(self.full)

    def length(self, value: float) -> float:
        """Of the arrow of a value, with its sign; 0 for none."""
        size = abs(value) / self.full if self.full and np.isfinite(value) else 0.0
        if size <= NOTHING:
            return 0.0
        return float(np.sign(value)) * max(SHORTEST, min(1.0, size**0.5 if self.root else size))

    def text(self, value: float) -> str:
        """A value in words."""
        scale = scale_for(abs(value), self.units)
        return f"{value * scale.factor:.3g} {scale.units}".replace("-", "−")


def arrow(along: Array, length: float, head: float, width: float) -> Array:
    """Corners of an arrow from the origin, shape (7, 2); it points back if its length is < 0.

    Parameters
    ----------
    along
        Its direction, of length 1.
    length
        From its foot to its tip.
    head, width
        Length of the head, and half the width of the shaft, of an arrow that is long enough.
    """
    tip = float(np.sign(length)) * min(head, 0.6 * abs(length))
    wide = 0.42 * abs(tip)
    shaft = min(width, 0.4 * wide)
    across = np.array([-along[1], along[0]])
    neck = length - tip
    corners = [(0.0, shaft), (neck, shaft), (neck, wide), (length, 0.0)]
    corners += [(reach, -aside) for reach, aside in reversed(corners[:3])]
    return np.array([reach * along + aside * across for reach, aside in corners])


def ring(radius: float, span: float, head: float, width: float) -> Array:
    """Corners of an arrow along a circle about the origin, shape (n, 2).

    Parameters
    ----------
    radius
        Of its middle line.
    span
        Angle from its foot to its tip in radians, counter-clockwise if > 0; its middle is on top.
    head, width
        Length of the head, and half the width of the shaft, of an arrow that is long enough.
    """
    tip = float(np.sign(span)) * min(head / radius, 0.6 * abs(span))
    wide = 0.42 * abs(tip) * radius
    shaft = min(width, 0.4 * wide)
    foot = 0.5 * (np.pi - span)
    turn = np.linspace(foot, foot + span - tip, 25)
    edges = [
        (radius + side * shaft) * np.column_stack((np.cos(turn), np.sin(turn)))[::side]
        for side in (1, -1)
    ]
    at, end = turn[-1], foot + span
    ways = [(radius + wide, at), (radius, end), (radius - wide, at)]
    corners = np.array([(reach * np.cos(a), reach * np.sin(a)) for reach, a in ways])
    return np.vstack([edges[0], corners, edges[1]])
