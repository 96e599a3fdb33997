"""One engine under all sweeps: chunks of points, computed anywhere, put side by side."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from linkages.errors import Interrupted
from linkages.sweeps.answers import OWN, Arrays, Code, Question
from linkages.sweeps.running import Executor, Progress, Threads, finished

if TYPE_CHECKING:
    import xarray as xr

    from linkages.sweeps.store import SweepStore

Span = tuple[int, int]
"""The first point of a chunk, and that behind its last."""


PER_CORE = 4
"""Chunks for each core: few to lose time at, and enough for all cores to end at about one time."""

Watch = Callable[[Progress], None]


@dataclass(frozen=True)
class Computed:
    """What there is of a sweep.

    Parameters
    ----------
    arrays
        The fields of the question and `OWN`, all points in their order.
    interrupted
        Whether Ctrl-C ended it.
    """

    arrays: Arrays
    interrupted: bool

    @property
    def done(self) -> int:
        """Points that were computed, or have a reason why not."""
        return int((self.arrays["outcome"] != Code.MISSING).sum())


def computed(
    question: Question,
    *,
    executor: Executor | None = None,
    store: SweepStore | None = None,
    watch: Watch | None = None,
) -> Computed:
    """Answer a question at all of its points.

    The answer at a point depends on the question and the point alone: not on chunks, cores, order,
    or on what a store had before.

    Parameters
    ----------
    question
        What is asked.
    executor
        Where; the cores that this process may use if not given.
    store
        Where answers are kept as they come.
    watch
        Called after each chunk.
    """
    executor = executor or Threads()
    size = chunk_size(question, executor) if store is None else store.chunk
    spans = [(at, min(at + size, question.count)) for at in range(0, question.count, size)]
    parts: dict[Span, Arrays] = {} if store is None else dict(store.read(spans, question.fields))
    left = [span for span in spans if span not in parts]
    ledger = Ledger(question.count, watch)
    for span, part in parts.items():
        ledger.add(span, part, new=False)
    interrupted = False
    try:
        for span, part in _chunks(question, left, executor):
            parts[span] = part
            ledger.add(span, part)
            ledger.tell()  # who watches keeps signals from then on: before anything is on disk
            if store is not None:
                store.write(span, part)
    except KeyboardInterrupt:
        interrupted = True
    whole = [parts.get(span) or question.nothing(span[1] - span[0]) for span in spans]
    names = [*OWN, *question.fields]
    arrays, late = finished(
        lambda: {name: np.concatenate([part[name] for part in whole]) for name in names}
    )
    return Computed(arrays, interrupted or late)


def dataset_of(
    found: Computed, name: str, what: str, store: SweepStore | None, made: Callable[[], xr.Dataset]
) -> xr.Dataset:
    """The dataset of a sweep; its store gets it, too, if all is there.

    Parameters
    ----------
    found
        What was computed.
    name, what
        Of the analysis, and of what it computed, in messages.
    store
        Where answers are kept.
    made
        Makes the dataset.

    Raises
    ------
    Interrupted
        After Ctrl-C; keeps the dataset under the name of the analysis.
    """

    def finish() -> xr.Dataset:
        data = made()
        if store is not None and not found.interrupted:
            store.finish(data)
        return data

    data, late = finished(finish)
    if not (found.interrupted or late):
        return data
    data.attrs["interrupted"] = 1
    message = f"interrupted after {found.done} of {len(found.arrays['outcome'])} {what}"
    raise Interrupted(message, kept={name: data})


def chunk_size(question: Question, executor: Executor) -> int:
    """How many points are computed together, so that there are several chunks for each core."""
    fewest, most = question.together
    workers: int = getattr(executor, "workers", 1)
    return max(fewest, min(most, -(-question.count // (PER_CORE * workers))))


def _chunks(
    question: Question, spans: list[Span], executor: Executor
) -> Iterator[tuple[Span, Arrays]]:
    """Chunks as they come; one that could not be computed at all has its reason at every point."""
    parts = batches(spans, getattr(executor, "motions", 0))
    wholes = [(part[0][0], part[-1][1]) for part in parts]
    for outcome in executor.run(question.chunk, wholes):
        first, last = wholes[outcome.index]
        whole = outcome.value
        if outcome.reason is not None:
            whole = question.nothing(last - first)
            whole["outcome"][:] = Code.INVALID
            whole["reason"] = np.full(last - first, outcome.reason)
        for span in parts[outcome.index]:
            own = slice(span[0] - first, span[1] - first)
            yield span, {name: array[own] for name, array in whole.items()}


def batches(spans: Sequence[Span], most: int) -> list[list[Span]]:
    """Chunks that are computed together: neighbours, of so many points at most; one at least."""
    found: list[list[Span]] = []
    for span in spans:
        if found and found[-1][-1][1] == span[0] and span[1] - found[-1][0][0] <= most:
            found[-1].append(span)
        else:
            found.append([span])
    return found


class Ledger:
    """Counts what was done, and tells of it."""

    def __init__(self, total: int, watch: Watch | None) -> None:
        self._total, self._watch = total, watch
        self._begun = time.monotonic()
        self._failed: Counter[str] = Counter()
        self._done = self._new = 0

    def add(self, span: Span, part: Arrays, new: bool = True) -> None:
        """Count a chunk; `new` if it was computed in this run."""
        size = span[1] - span[0]
        self._done += size
        self._new += size * new
        codes, counts = np.unique(part["outcome"], return_counts=True)
        for code, count in zip(codes, counts, strict=True):
            if code != Code.COMPUTED:
                self._failed[Code(code).words] += int(count)

    def tell(self) -> None:
        """Call the watch."""
        if self._watch is None:
            return
        found = Progress.after(self._done, self._total, self._begun, self._new)
        self._watch(replace(found, failures=dict(self._failed)))
