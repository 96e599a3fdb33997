"""What becomes of the points of a sweep: values, and codes and reasons where there are none."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.sweeps.running import INTERRUPTED, reason_of

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
    """A variable of the answers.

    Parameters
    ----------
    dtype
        ``"f8"``, ``"i8"``, ``"i1"`` or ``"U"``.
    shape
        At each point.
    """

    dtype: str = "f8"
    shape: tuple[int, ...] = ()

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
        found = {name: each.nothing(count) for name, each in (OWN | dict(self.fields)).items()}
        found["outcome"][:] = Code.MISSING
        return found


def stacked(fields: Mapping[str, Field], answers: Sequence[Answer]) -> Arrays:
    """Answers side by side."""
    found: Arrays = {
        "outcome": OWN["outcome"].stacked([answer.code for answer in answers]),
        "reason": OWN["reason"].stacked([answer.reason for answer in answers]),
        "stop_time": OWN["stop_time"].stacked(
            [np.nan if answer.stop_time is None else answer.stop_time for answer in answers]
        ),
        "evaluations": OWN["evaluations"].stacked([answer.evaluations for answer in answers]),
    }
    for name, each in fields.items():
        nothing = each.nothing(1)[0]
        found[name] = each.stacked([answer.values.get(name, nothing) for answer in answers])
    return found


def reasons(found: Arrays) -> NDArray[Any]:
    """Why there are no values, as datasets have it; empty where there are some."""
    texts = found["reason"].astype(object)
    texts[found["outcome"] == Code.MISSING] = INTERRUPTED
    return texts


def inserted(array: NDArray[Any], place: int, value: Any) -> NDArray[Any]:
    """An array with another entry; texts become as long as they need."""
    if array.dtype.kind == "U" and np.asarray(value).dtype.itemsize > array.dtype.itemsize:
        array = array.astype(np.asarray(value).dtype)
    array[place] = value
    return array
