"""When tangents are brought back to length one in a run, and which coordinates they are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

MOST_DOUBT = 1e-3
"""Part of the shortest tangent that the error of a step may amount to."""

LONGEST = 1e50
"""Length to which a tangent may grow: numbers end at 1e150, which long intervals would reach."""


@dataclass(frozen=True, kw_only=True)
class Renormalisation:
    """Which coordinates of a flow are tangents, and at which samples they are renormalised.

    Parameters
    ----------
    size, columns
        The last ``columns·size`` coordinates are those of tangents, one after the other.
    placed
        Of those of a tangent the first ones are lengths themselves; only the rates of the others
        are.
    every
        They are renormalised at every sample whose number is a multiple of this.
    offset
        How many samples are taken to be before the first one.
    orthogonal
        Whether tangents are made orthonormal, or only of length one each.
    grown : (columns,)
        Logarithms of the lengths by which they have grown since the last time.
    """

    size: int
    columns: int
    placed: int
    grown: Floats
    every: int = 1
    offset: int = 0
    orthogonal: bool = True

    def count(self, samples: int) -> int:
        """How often tangents are renormalised within so many samples."""
        return (samples + self.offset) // self.every

    def stretched(self, tangents: Floats, rtol: float, atol: float) -> bool:
        """Whether errors of the next steps would show in the shortest tangent, or one is too long.

        `tangents` has shape (2·size, columns); the tolerances are those of its entries.
        """
        lengths = np.exp(self.factors(tangents)[0])
        lengths = lengths[lengths > 0.0]  # a contact that closed may have taken others away
        if not len(lengths):
            return False
        doubt = max(rtol * lengths.max(), atol)
        return bool(doubt > MOST_DOUBT * lengths.min() or lengths.max() > LONGEST)

    def factors(self, tangents: Floats) -> tuple[Floats, Floats]:
        """Logarithms of lengths, shape (columns,), and what makes tangents renormalised.

        Parameters
        ----------
        tangents
            Shape (2·size, columns); they are multiplied by the result, shape (columns, columns).
        """
        upper = np.linalg.qr(tangents)[1]
        grown = upper if self.orthogonal else np.diag(np.linalg.norm(tangents, axis=0))
        taken = np.diag(grown) == 0.0
        grown = grown + np.diag(taken)
        lengths = np.where(taken, -np.inf, np.log(np.abs(np.diag(grown))))
        return lengths, np.linalg.inv(grown)

    def undone(
        self, samples: Floats, grown: Floats, seen: int = 0
    ) -> tuple[Floats, Floats, Floats]:
        """What renormalisation gives for samples between which nobody did it.

        Parameters
        ----------
        samples
            Tangents at the next samples, shape (samples, size + placed, columns).

        Returns
        -------
        Logarithms of lengths, shape (times, columns), tangents behind, shape (times, size + placed,
        columns), and what later tangents are to be multiplied by, shape (columns, columns).
        """
        lengths, found, factor = [], [], np.eye(self.columns)
        for number, tangents in enumerate(samples, start=seen + self.offset + 1):
            if number % self.every:
                continue
            further, then = self.factors(tangents @ factor)
            lengths.append(grown + further)
            grown[:] = 0.0
            factor = factor @ then
            found.append(tangents @ factor)
        shape = (len(found), *samples.shape[1:])
        return np.reshape(lengths, (-1, self.columns)), np.reshape(found, shape), factor
