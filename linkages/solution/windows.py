"""Parts of motions as sources of measures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]


class Source(Protocol):
    """Motions with the same sample times."""

    @property
    def count(self) -> int:
        """Number of motions."""
        ...

    @property
    def time(self) -> Floats:
        """Sample times, shape (samples,)."""
        ...

    def sampled(self, series: str) -> Floats:
        """A series at the samples, shape (motions, samples)."""
        ...

    def between(self, series: Sequence[str], which: Whole, places: Floats) -> list[Floats]:
        """Series anywhere in some of the motions, shape (places,) each."""
        ...

    @property
    def intervals(self) -> tuple[Whole, Floats, Floats] | None:
        """Intervals between known jumps: motion, begin and end in s, shape (intervals,) each.

        None where no more is known than the samples.
        """
        ...

    def during(self, series: Sequence[str], which: Whole, times: Floats) -> list[Floats]:
        """Series at times in some of the motions, shape (times,) each."""
        ...

    def number(self, path: str) -> Floats:
        """A number of the definition, in SI, shape (motions,)."""
        ...


@dataclass(frozen=True, eq=False)
class Window:
    """A part of each motion of a source, with as many samples as the whole has.

    `begin`, `end`: times in s, shape (motions,).
    """

    source: Source
    begin: Floats
    end: Floats
    _known: dict[str, Floats] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """Number of motions."""
        return self.source.count

    @cached_property
    def times(self) -> Floats:
        """Sample times, shape (motions, samples)."""
        part = np.linspace(0.0, 1.0, len(self.source.time))
        result = self.begin[:, None] + part * (self.end - self.begin)[:, None]
        result[:, -1] = self.end
        return np.asarray(result)

    def at(self, which: Whole, places: Floats) -> Floats:
        """Times of places, in samples from the first one of the window."""
        last = max(len(self.source.time) - 1, 1)
        part = places / last
        return np.asarray((1.0 - part) * self.begin[which] + part * self.end[which])

    def sampled(self, series: str) -> Floats:
        """A series at the samples, shape (motions, samples)."""
        if series not in self._known:
            which = np.repeat(np.arange(self.count), self.times.shape[1])
            (values,) = self.source.during([series], which, self.times.ravel())
            self._known[series] = values.reshape(self.times.shape)
        return self._known[series]

    def between(self, series: Sequence[str], which: Whole, places: Floats) -> list[Floats]:
        """Series anywhere in some of the windows, shape (places,) each."""
        return self.source.during(series, which, self.at(which, places))

    @cached_property
    def intervals(self) -> tuple[Whole, Floats, Floats] | None:
        """Those of the source within the windows."""
        result = self.source.intervals
        if result is None:
            return None
        which, begin, end = result
        low, high = np.minimum(self.begin, self.end)[which], np.maximum(self.begin, self.end)[which]
        begin, end = np.clip(begin, low, high), np.clip(end, low, high)
        kept = begin != end
        return which[kept], begin[kept], end[kept]

    def during(self, series: Sequence[str], which: Whole, times: Floats) -> list[Floats]:
        """Series at times in some of the motions, shape (times,) each."""
        return self.source.during(series, which, times)

    @property
    def time(self) -> Floats:
        """Sample times of the source, of which the window has as many."""
        return self.source.time

    def number(self, path: str) -> Floats:
        """A number of the definition, in SI, shape (motions,)."""
        return self.source.number(path)
