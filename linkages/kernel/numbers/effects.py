"""What changes with numbers of a definition: parameters of a kernel, and the initial state."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.terms import Path

Floats = NDArray[np.float64]

Fed = tuple[tuple[Path, ...], ...]
"""For each number of a definition the paths of the parameters that it feeds."""


@dataclass(frozen=True, eq=False)
class Effects:
    """Derivatives by numbers of a definition.

    Parameters
    ----------
    fed
        What each of P numbers feeds.
    slopes
        Derivatives of those parameters, those of one number after those of the other, shape (s,).
    state
        Derivatives of the initial coordinates and their rates, shape (2m, P).
    knots
        Which slopes are knots of tables instead: those of a spline whose coefficients are the
        derivatives that follow; shape (s,).
    """

    fed: Fed
    slopes: Floats
    state: Floats
    knots: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.fed)

    def scaled(self, factors: Floats) -> Effects:
        """The same by numbers in other units, of which each is `factors` SI units, shape (P,)."""
        each = np.repeat(factors, [len(paths) for paths in self.fed])
        slopes = np.where(self.knots, self.slopes, self.slopes * each)
        return replace(self, slopes=slopes, state=self.state * factors)


def slots(fed: Sequence[Sequence[Path]]) -> Iterator[tuple[int, Path]]:
    """Number of a definition and path of a parameter, for each of the slopes."""
    return ((number, path) for number, paths in enumerate(fed) for path in paths)
