"""When tangents are brought back to length one in a run, and which coordinates they are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


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
    """

    size: int
    columns: int
    placed: int
    every: int = 1
    offset: int = 0
    orthogonal: bool = True

    def count(self, samples: int) -> int:
        """How often tangents are renormalised within so many samples."""
        return (samples + self.offset) // self.every

    def undone(self, samples: Floats, seen: int = 0) -> tuple[Floats, Floats, Floats]:
        """What renormalisation gives for samples between which nobody did it.

        Parameters
        ----------
        samples
            Tangents at the next samples, shape (samples, size + placed, columns).
        seen
            How many samples came before them.

        Returns
        -------
        Logarithms of lengths, shape (times, columns), tangents behind, shape (times, size + placed,
        columns), and what later tangents are to be multiplied by, shape (columns, columns).
        """
        lengths, found, factor = [], [], np.eye(self.columns)
        for number, tangents in enumerate(samples, start=seen + self.offset + 1):
            if number % self.every:
                continue
            here = tangents @ factor
            upper = np.linalg.qr(here)[1]
            grown = upper if self.orthogonal else np.diag(np.linalg.norm(here, axis=0))
            lengths.append(np.log(np.abs(np.diag(grown))))
            factor = factor @ np.linalg.inv(grown)
            found.append(tangents @ factor)
        shape = (len(found), *samples.shape[1:])
        return np.reshape(lengths, (-1, self.columns)), np.reshape(found, shape), factor
