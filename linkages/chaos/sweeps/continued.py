"""Diagrams whose every value goes on from where the motion at its neighbour ended."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Protocol

import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError

from linkages.chaos.sweeps.continuation import ContinuationEnd
from linkages.errors import ComputationError
from linkages.sweeps.answers import Answer, Arrays, Field, inserted, stacked
from linkages.sweeps.engine import Computed, Ledger, Watch
from linkages.sweeps.running import Executor, Threads
from linkages.sweeps.store import SweepStore

END = "end"
"""Field of what is stored at a value: where its motion ended, as text."""

Point = tuple[int, Mapping[str, object], ContinuationEnd | None]
"""Index of a value, overrides of an initial state, and where the motion goes on, if it does."""

Outcome = tuple[Answer, ContinuationEnd | None]
"""What is found at a value, and where its motion ended, if the next one is to go on there."""


class Continuing(Protocol):
    """What is asked at every value, for one initial state after the other."""

    @property
    def count(self) -> int:
        """Number of values, for all initial states."""
        ...

    @property
    def initial(self) -> Sequence[Mapping[str, object]]:
        """Initial states."""
        ...

    @property
    def fields(self) -> Mapping[str, Field]:
        """Variables of an answer."""
        ...

    def answer(self, point: Point) -> Outcome:
        """What is found at a value, and where its motion ended."""
        ...

    def nothing(self, count: int) -> Arrays:
        """Arrays of points that were not computed."""
        ...


def continued(
    question: Continuing,
    forward: bool,
    executor: Executor | None = None,
    store: SweepStore | None = None,
    watch: Watch | None = None,
) -> Computed:
    """Every value from the last state of its neighbour, all initial states side by side.

    Parameters
    ----------
    question
        What is asked.
    forward
        Whether values are taken in their order, or from the last one on.
    executor
        Where; the cores that this process may use if not given.
    store
        Where answers are kept as they come, in the order of computation: a chunk for each value,
        with the ends that the next one needs.
    watch
        Called after each value.
    """
    starts = len(question.initial)
    size = question.count // starts
    order = range(size) if forward else range(size - 1, -1, -1)
    spans = [(step * starts, (step + 1) * starts) for step in range(size)]
    whole, ledger = question.nothing(question.count), Ledger(question.count, watch)
    ends: list[ContinuationEnd | None] = [None] * starts
    fields = {**question.fields, END: Field("U")}

    def enter(part: Arrays, row: int, index: int, place: int) -> None:
        for name in whole:
            whole[name] = inserted(whole[name], row * size + index, part[name][place])
        ends[row] = _read(str(part[END][place])) or ends[row]

    done = 0
    for span, part in () if store is None else store.read(spans, fields):
        if span != spans[done]:
            break  # whatever is behind a gap is computed again
        try:
            for row in range(starts):
                enter(part, row, order[done], row)
        except ValidationError:
            raise store.damaged(span, "'end' is none of a motion") from None  # type: ignore[union-attr]
        ledger.add(span, part, new=False)
        done += 1
    try:
        for index, span in zip(order[done:], spans[done:], strict=True):
            points = [(index, *start) for start in zip(question.initial, ends, strict=True)]
            found: dict[int, Answer] = {}
            for outcome in (executor or Threads()).run(question.answer, points):
                if outcome.value is None:
                    raise ComputationError(str(outcome.reason), time=outcome.stop_time)
                answer, end = outcome.value
                answer = replace(answer, values={**answer.values, END: _written(end)})
                found[outcome.index] = answer
                enter(stacked(fields, [answer]), outcome.index, index, 0)
            part = stacked(fields, [found[row] for row in range(starts)])
            ledger.add(span, part)
            ledger.tell()
            if store is not None:
                store.write(span, part)
    except KeyboardInterrupt:
        return Computed(whole, True)
    return Computed(whole, False)


def _written(end: ContinuationEnd | None) -> str:
    """An end as text, from which it can be read again to the last bit."""
    if end is None:
        return ""
    places = {point: place.tolist() for point, place in end.places.items()}
    return json.dumps({**asdict(replace(end, places={})), "places": places})


def _read(text: str) -> ContinuationEnd | None:
    if not text:
        return None
    found = dict(_End.model_validate_json(text))
    found["places"] = {point: np.array(place) for point, place in found["places"].items()}
    return ContinuationEnd(**found)


class _End(BaseModel):
    """A `ContinuationEnd` as text."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    state: dict[str, tuple[float, float]]
    places: dict[str, tuple[float, float]]
    internal: dict[str, float]
    carried: dict[str, float]
    turns: dict[int, float]
    held: dict[str, float]
