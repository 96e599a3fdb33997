"""Sweep engine: chunks of points, their values and failures."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from enum import IntEnum
from itertools import chain
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from linkages.errors import InputError, Interrupted, LinkagesError
from linkages.kernel.system import System
from linkages.kernel.varying import Along, Varying
from linkages.solution.solution import IncompleteError
from linkages.sweeps.axes import first_possible
from linkages.sweeps.points import Points
from linkages.sweeps.running import (
    INTERRUPTED,
    Executor,
    Progress,
    Threads,
    finished,
    reason_of,
    stopping,
)

if TYPE_CHECKING:
    import xarray as xr

    from linkages.sweeps.store import SweepStore

Made = TypeVar("Made")

Arrays = dict[str, NDArray[Any]]
"""Name → values, the first axis counts points."""


class Code(IntEnum):
    """What became of a point."""

    COMPUTED = 0
    INVALID = 1
    NOT_ASSEMBLED = 2
    STOPPED = 3
    OVER_BUDGET = 4
    OVER_TIME = 5
    UNDEFINED = 6
    MISSING = 7

    @property
    def words(self) -> str:
        """As files and reports have it."""
        return self.name.lower()


CODES = {
    "flag_values": np.array([*Code], dtype=np.int8),
    "flag_meanings": " ".join(code.words for code in Code),
}
"""What codes mean, as attributes of a dataset."""


class OverTimeError(Exception):
    """A point took longer than it may."""


@dataclass(frozen=True)
class Field:
    """A variable of the answers."""

    dtype: str = "f8"  # ``"f8"``, ``"i8"``, ``"i1"`` or ``"U"``
    shape: tuple[int, ...] = ()  # at each point

    def nothing(self, count: int) -> NDArray[Any]:
        """Values where there are none: nan, 0, or an empty text."""
        fill: Any = {"f": np.nan, "i": 0, "U": ""}[self.dtype[0]]
        return np.full((count, *self.shape), fill, dtype=self.dtype)

    def stacked(self, values: Sequence[Any]) -> NDArray[Any]:
        """Values of points side by side."""
        return np.array(values, dtype=self.dtype).reshape(len(values), *self.shape)


OWN = {
    "outcome": Field("i1"), "reason": Field("U"), "stop_time": Field(), "evaluations": Field("i8"),
}  # fmt: skip
"""What is known of every point, whatever is asked."""


@dataclass(frozen=True)
class Answer:
    """What was found at a point: values of fields, and what became of it."""

    values: Mapping[str, Any] = field(default_factory=dict)
    code: Code = Code.COMPUTED
    reason: str = ""
    stop_time: float | None = None
    evaluations: int = 0

    @classmethod
    def of(cls, error: Exception, code: Code, evaluations: int = 0) -> Answer:
        """Why there is none."""
        return cls({}, code, reason_of(error), getattr(error, "time", None), evaluations)


class Question(ABC):
    """What is asked at every point of a sweep; can be sent to other processes."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Without what was computed from its fields."""
        own: Any = self
        return type(self), tuple(getattr(self, each.name) for each in fields(own))

    @property
    def together(self) -> tuple[int, int]:
        """How many points are best computed together: at least, and at most."""
        return 1, 1

    @property
    def cpu_only(self) -> str:
        """What of it is computed on the CPU only; empty if its motions may go elsewhere."""
        return "this question"

    @property
    def room(self) -> int:
        """Bytes that a point takes while it is computed with others, about."""
        return 1 << 16

    @property
    @abstractmethod
    def count(self) -> int:
        """Number of points."""

    @property
    @abstractmethod
    def fields(self) -> Mapping[str, Field]:
        """Variables of an answer beside `OWN`."""

    @property
    @abstractmethod
    def described(self) -> dict[str, Any]:
        """What tells this question from others, in terms of JSON; numbers of points are apart."""

    @abstractmethod
    def numbers(self) -> NDArray[np.float64]:
        """Numbers of all points, shape (points, paths)."""

    @abstractmethod
    def answers(self, first: int, last: int) -> list[Answer]:
        """What is found at some points: a function of this question and of each point alone."""

    def chunk(self, span: tuple[int, int]) -> Arrays:
        """The answers at some points as arrays."""
        return stacked(self.fields, self.answers(*span))

    def nothing(self, count: int) -> Arrays:
        """Arrays of points that were not computed."""
        result = {name: each.nothing(count) for name, each in (OWN | dict(self.fields)).items()}
        result["outcome"][:] = Code.MISSING
        return result


MOST_RESULTS = 10**6
"""Results that follow from each other for which a store has room."""


@dataclass(frozen=True)
class Successive(Question):
    """Results that follow from each other: a store keeps them one by one, in their order."""

    kind: str
    about: Mapping[str, Any]

    @property
    def count(self) -> int:
        """Room for so many."""
        return MOST_RESULTS

    @property
    def fields(self) -> Mapping[str, Field]:
        """Those that all have."""
        return OWN

    @property
    def described(self) -> dict[str, Any]:
        """What tells them from others."""
        return {"kind": self.kind, **self.about}

    def numbers(self) -> NDArray[np.float64]:
        """None."""
        return np.zeros((0, 1))

    def answers(self, _first: int, _last: int) -> list[Answer]:
        """None of them is computed alone."""
        raise TypeError("results that follow from each other are not computed alone")


def stacked(fields: Mapping[str, Field], answers: Sequence[Answer]) -> Arrays:
    """Answers side by side."""
    result: Arrays = {
        "outcome": OWN["outcome"].stacked([answer.code for answer in answers]),
        "reason": OWN["reason"].stacked([answer.reason for answer in answers]),
        "stop_time": OWN["stop_time"].stacked(
            [np.nan if answer.stop_time is None else answer.stop_time for answer in answers]
        ),
        "evaluations": OWN["evaluations"].stacked([answer.evaluations for answer in answers]),
    }
    for name, each in fields.items():
        nothing = each.nothing(1)[0]
        result[name] = each.stacked([answer.values.get(name, nothing) for answer in answers])
    return result


def reasons(found: Arrays) -> NDArray[Any]:
    """Why there are no values, as datasets have it; empty where there are some."""
    texts = found["reason"].astype(object)
    texts[found["outcome"] == Code.MISSING] = INTERRUPTED
    return texts


def marks(found: Arrays, dims: tuple[str, ...], shape: tuple[int, ...]) -> dict[str, Any]:
    """What became of each point, as variables of a dataset over dimensions of a shape."""
    stopped = {"units": "s", "long_name": "time at which the motion stopped"}
    return {
        "outcome": (dims, found["outcome"].reshape(shape), CODES),
        "reason": (dims, reasons(found).reshape(shape)),
        "stop_time": (dims, found["stop_time"].reshape(shape), stopped),
    }


def inserted(array: NDArray[Any], place: int, value: Any) -> NDArray[Any]:
    """An array with another entry; texts become as long as they need."""
    if array.dtype.kind == "U" and np.asarray(value).dtype.itemsize > array.dtype.itemsize:
        array = array.astype(np.asarray(value).dtype)
    array[place] = value
    return array


Span = tuple[int, int]
"""The first point of a chunk, and that behind its last."""


PER_CORE = 4
"""Chunks for each core: few to lose time at, and enough for all cores to end at about one time."""

Watch = Callable[[Progress], None]


@dataclass(frozen=True)
class Computed:
    """What there is of a sweep."""

    arrays: Arrays  # the fields of the question and `OWN`, all points in their order
    interrupted: bool  # whether Ctrl-C ended it

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
    """Answer a question at all of its points; chunks, cores and the store change no answer."""
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
    """The dataset of a sweep, saved in its store if complete; raises Interrupted after Ctrl-C."""

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
    result: list[list[Span]] = []
    for span in spans:
        if result and result[-1][-1][1] == span[0] and span[1] - result[-1][0][0] <= most:
            result[-1].append(span)
        else:
            result.append([span])
    return result


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
        elapsed = time.monotonic() - self._begun
        remaining = elapsed / self._new * (self._total - self._done)
        counts = self._done, self._total, elapsed, remaining, self._new
        self._watch(Progress(*counts, failures=dict(self._failed)))


BUDGET = "max_steps"
"""Stands in what is said of a motion that used up its steps."""

SIDE_BY_SIDE = 8, 128
"""Fewest and most motions that are integrated together."""

_BLOCK = 64


def answered(along: Along, place: int, of: Callable[[System], Answer]) -> Answer:
    """The answer at one of some points."""
    if stopping():
        raise KeyboardInterrupt
    try:
        system = along.system(place)
    except InputError as error:
        return Answer.of(error, refusal_code(along.varying, along.points[place]))
    return attempted(lambda: of(system))


def begun(
    along: Along, make: Callable[[int, System], Made]
) -> tuple[dict[int, Made], dict[int, Answer]]:
    """What is made of the system at each of some points, and answers where there is none."""
    made: dict[int, Made] = {}
    missing: dict[int, Answer] = {}
    for place in range(len(along)):

        def keep(system: System, place: int = place) -> Answer:
            made[place] = make(place, system)
            return Answer()

        answer = answered(along, place, keep)
        if place not in made:
            missing[place] = answer
    return made, missing


def attempted(task: Callable[[], Answer]) -> Answer:
    """An answer, or why there is none."""
    try:
        return task()
    except OverTimeError as error:
        return Answer({}, Code.OVER_TIME, str(error))
    except InputError as error:
        return Answer.of(error, Code.INVALID)
    except IncompleteError as error:
        return Answer.of(error, stop_code(error), evaluations(error.solution.motion))
    except (LinkagesError, ValueError) as error:
        return Answer.of(error, stop_code(error))


def end_when_stopping(_fraction: float) -> None:
    """Watch a computation: ends it when the sweep has ended that it is for."""
    if stopping():
        raise KeyboardInterrupt


def refusal_code(varying: Varying, overrides: Any) -> Code:
    """Whether values cannot be used, or the mechanism that they make cannot be assembled."""
    try:
        varying.mechanism_at(overrides)
    except InputError:
        return Code.INVALID
    return Code.NOT_ASSEMBLED


def stop_code(error: Exception) -> Code:
    """What became of a motion that stopped."""
    return Code.OVER_BUDGET if BUDGET in str(error) else Code.STOPPED


def evaluations(motion: Any) -> int:
    """What a motion cost."""
    return int(motion.cost.get("evaluations", 0))


def first_system(varying: Varying, points: Points) -> System:
    """The first system along the points that can be built."""
    starts = range(0, points.count, _BLOCK)
    blocks = (points.overrides(first, min(first + _BLOCK, points.count)) for first in starts)
    return first_possible(varying.at, chain.from_iterable(blocks))
