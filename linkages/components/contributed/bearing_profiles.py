"""Bearings that are not round: where the centre of a journal may be.

A bearing is R + c + h wide at the angle θ of its own frame, with the radius R of its journal and
the radial clearance c, and h is much less than R. The journal, which is round, may then have its
centre where e·u(θ) ≤ p(θ) for all θ, with p = c + h and the unit vectors u: p is the support
function of that set if it is convex, p + p″ ≥ 0. This is the radius of curvature of its border.
Where it is negative, the journal would touch at two places before it reaches the ground between
them; where it is zero, at two places or along an arc at once.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import zip_longest

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict
from pydantic.dataclasses import dataclass as validated_dataclass

from linkages.components.contributed.terms import Parameter
from linkages.reading.paths import KeyPath
from linkages.spec.quantities import MOST_HARMONICS, Length

Floats = NDArray[np.float64]

FINE = 16
"""Angles for each harmonic at which a profile is looked at."""


@validated_dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="forbid"))
class BearingProfile:
    """Depth of a bearing beyond its circle, as harmonics over the angle in its own frame.

    Parameters
    ----------
    cos, sin
        Amplitudes of the harmonics in metres, from the first one on.
    """

    cos: tuple[Length, ...] = ()
    sin: tuple[Length, ...] = ()

    @property
    def harmonics(self) -> tuple[Floats, Floats]:
        """Amplitudes of cosines and sines, shape (K,) each."""
        count = max(len(self.cos), len(self.sin))
        cos, sin = np.zeros((2, count))
        cos[: len(self.cos)], sin[: len(self.sin)] = self.cos, self.sin
        return cos, sin

    def problems(self, size: float) -> Iterator[tuple[tuple[str, ...], str]]:
        """Keys at fault with sentences, in a bearing with a radial clearance in metres."""
        cos, sin = self.harmonics
        if len(cos) > MOST_HARMONICS:
            yield (), f"expected at most {MOST_HARMONICS} harmonics, found {len(cos)}"
            return
        if not len(cos):
            yield (), "expected amplitudes of harmonics as 'cos' or 'sin', found none"
            return
        angles = np.linspace(0.0, 2.0 * np.pi, FINE * (len(cos) + 1), endpoint=False)
        support, _, bent = support_of(size, cos, sin, angles)
        worst = int(np.argmin(support + bent))
        if support[worst] + bent[worst] <= 0.0:
            yield (
                (),
                f"the journal cannot touch the bearing at {np.degrees(angles[worst]):.0f} deg: it "
                "would touch two places beside it at once, for the clearance and its second "
                f"derivative add up to {support[worst] + bent[worst]:.3g} m; expected more than 0",
            )

    def parameters(self, path: KeyPath) -> tuple[tuple[Parameter, Parameter], ...]:
        """Amplitudes as arguments of the kernel, whatever their values."""
        pairs = enumerate(zip_longest(self.cos, self.sin, fillvalue=0.0))
        return tuple(
            (Parameter((*path, "cos", k), a), Parameter((*path, "sin", k), b))
            for k, (a, b) in pairs
        )


def support_of(size: float, cos: Floats, sin: Floats, angles: Floats) -> tuple[Floats, ...]:
    """The support p and its first two derivatives at some angles, in metres."""
    order = np.arange(1, len(cos) + 1)
    phase = np.multiply.outer(angles, order)
    c, s = np.cos(phase), np.sin(phase)
    return (
        size + c @ cos + s @ sin,
        c @ (order * sin) - s @ (order * cos),
        -(c @ (order**2 * cos) + s @ (order**2 * sin)),
    )
