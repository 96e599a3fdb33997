"""What motions differ from measurements by, with exact derivatives."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.design.fitting.measured import Measured
from linkages.design.sensitivity.differentiated import Differentiated
from linkages.design.sensitivity.reductions import followed, inner
from linkages.design.varied.ranges import Ranges
from linkages.errors import ComputationError, InputError
from linkages.spec.measures import read_measure

Floats = NDArray[np.float64]

_STEEP = 1e3


class Residuals:
    """Computed less measured, each as a part of its standard deviation, over places in the box.

    Parameters
    ----------
    mechanism, ranges
        What is varied.
    measured
        What it is compared with.
    given
        Options of the simulation.
    watch
        Called after each motion with how many there were, and the least sum of squares so far.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        ranges: Ranges,
        measured: Measured,
        given: dict[str, object],
        watch: Callable[[int, float], None] | None,
    ) -> None:
        self._ranges, self._watch = ranges, watch
        self._time = measured.time
        self._there = np.array([np.isfinite(column.values) for column in measured.columns])
        self._values = np.array([column.values for column in measured.columns])[self._there]
        self.sigma = np.array([column.sigma for column in measured.columns])[self._there]
        self._measures = [read_measure(f"final({column.series})") for column in measured.columns]
        texts = [each.text for each in self._measures]
        self._own = Differentiated(mechanism, texts, ranges.paths, run=given)
        self._known: dict[bytes, tuple[Floats, Floats] | None] = {}
        self.squares: list[float] = []
        self.reasons: list[str] = []
        self.best: Floats | None = None

    @property
    def start(self) -> Floats:
        """Numbers of the definition in SI."""
        return np.array(self._own.values)

    def at(self, places: Floats) -> tuple[Floats, Floats] | None:
        """Residuals, shape (m,), and derivatives by places, (m, paths); None if there are none."""
        key = places.tobytes()
        if key not in self._known:
            self._known[key] = self._computed(places)
        return self._known[key]

    def _computed(self, places: Floats) -> tuple[Floats, Floats] | None:
        try:
            moved = self._own.moved(self._ranges.numbers(places), self._own.series)
        except (ComputationError, InputError) as error:
            self.reasons.append(str(error))
            self.squares.append(np.nan)
            return None
        at = moved.places(self._time)
        found = [followed(inner(each), moved, at) for each in self._measures]
        values = np.array([each.value for each in found])[self._there]
        values = (values - self._values) / self.sigma
        squares = float(values @ values)
        if self.best is None or squares < np.nanmin(self.squares):
            self.best = places.copy()
        self.squares.append(squares)
        if self._watch is not None:
            self._watch(len(self.squares), float(np.nanmin(self.squares)))
        slopes = np.array([each.slopes for each in found]).transpose(0, 2, 1)[self._there]
        return values, slopes * self._ranges.width / self._own.scales / self.sigma[:, None]

    def values(self, places: Floats) -> Floats:
        """Residuals; larger than all others where there are none, so that steps become shorter."""
        found = self.at(places)
        if found is None:
            largest = np.nanmax(self.squares)
            return np.full(len(self._values), _STEEP * np.sqrt(largest / len(self._values) + 1.0))
        return found[0]

    def slopes(self, places: Floats) -> Floats:
        """Derivatives by places; only asked for where there are residuals."""
        found = self.at(places)
        assert found is not None
        return found[1]
