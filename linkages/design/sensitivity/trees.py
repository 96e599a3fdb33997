"""Trees of measures along a motion: what changes with time, with its derivatives."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from linkages.design.sensitivity.moved import Moved
from linkages.design.sensitivity.nearby import NODES, Near
from linkages.design.sensitivity.varied import Varied, applied, filled
from linkages.spec.formulas import Call, Clock, Node, Sensed
from linkages.spec.measures import Measure, is_series

Floats = NDArray[np.float64]

_WIDEST = 16.0
"""Part of a motion, to either side of a place, that a polynomial is asked to follow first."""


class Tree(ABC):
    """A measure of a motion.

    Parameters
    ----------
    measure, moved
        What is asked, and of what.
    """

    def __init__(self, measure: Measure, moved: Moved) -> None:
        self.measure, self.moved = measure, moved
        self.last = len(moved.time) - 1

    @abstractmethod
    def number(self, node: Node) -> Varied:
        """What does not change with time."""

    def series(self, node: Node, places: Floats | None, slopes: bool) -> Varied:
        """What changes with time: at places, or at all samples without derivatives."""
        if not is_series(node):
            found = self.number(node)
            if found.slopes is None or not slopes:
                return Varied(found.value, None)
            return Varied(found.value, found.slopes[:, None])
        match node:
            case Clock():
                return Varied(self.time(places), None)
            case Sensed(name):
                (values,) = self.moved.values([name], places)
                if not slopes or places is None or not self.moved.count:
                    return Varied(values, None)
                return Varied(values, self.moved.slopes([name], places)[0])
            case Call(name, arguments):
                return applied(name, [self.series(a, places, slopes) for a in arguments])
            case _:
                raise AssertionError("constants are no series")

    def time(self, places: Floats | None) -> Floats:
        """Times of places, or of all samples, in seconds."""
        time = self.moved.time
        return time if places is None else np.interp(places, np.arange(len(time)), time)

    def at(self, node: Node, place: float) -> Varied:
        """What changes with time at one place: a number."""
        found = self.series(node, np.array([place]), slopes=True)
        return Varied(
            np.ravel(found.value)[0], filled(found, self.moved.count).reshape(-1, 1)[:, 0]
        )

    def step(self, place: float) -> float:
        """Seconds from the sample before a place to the one behind it."""
        before = min(int(place), self.last - 1)
        return float(self.moved.time[before + 1] - self.moved.time[before])

    def near(self, node: Node, place: float, half: float | None = None) -> Near:
        """A series near a place, or with half the width of the interval given its derivatives."""
        reach, (first, last) = max(1.0, self.last / _WIDEST), self.moved.stretch(place)
        place = float(np.clip(place, first, last))
        while True:
            low, high = max(first, place - reach), min(last, place + reach)
            wanted = 0.5 * (high - low) if half is None else half
            middle = float(np.clip(place, first + wanted, last - wanted))
            found = self.series(node, middle + wanted * NODES, half is not None)
            rows = found.value[None] if half is None else filled(found, self.moved.count)
            near = Near.through(middle, wanted, rows)
            if half is not None or near.exact or reach == 1.0:
                return near
            reach = max(1.0, reach / 2.0)
