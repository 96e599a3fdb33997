"""Motions that continue from the end of others while a parameter changes."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, TypeAdapter, ValidationError

from linkages.chaos.common_period import NoPeriodError, common_period
from linkages.chaos.free_states import PAIRS, free_names, free_values
from linkages.chaos.sections import (
    SectionPoints,
    crossing,
    last_time,
    require_section,
    strobing,
)
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError
from linkages.kernel.outputs import links
from linkages.kernel.system import System
from linkages.options.analysis_options import SectionOptions
from linkages.solution.many import Going
from linkages.solution.march import March
from linkages.solution.motion import Motion, Piece
from linkages.sweeps.engine import Answer, Arrays, Computed, Field, Ledger, Watch, inserted, stacked
from linkages.sweeps.running import Executor, Threads
from linkages.sweeps.store import SweepStore

Floats = NDArray[np.float64]

WHOLE = 1e-9
"""Part of a period by which round-off moves a time from a whole number of periods."""


@dataclass(frozen=True, eq=False)
class ContinuationEnd:
    """Where a motion ended: what the next one starts from."""

    __pydantic_config__: ClassVar[Any] = ConfigDict(extra="forbid", allow_inf_nan=False)

    # Free coordinate → value and rate; with whole turns where they count
    state: Mapping[str, tuple[float, float]]
    # Point → where it was: which assembly branch the mechanism is in
    places: Mapping[str, tuple[float, float]]
    internal: Mapping[str, float]  # internal states by name
    # Coordinates carried along by the integration, with whole turns where they count
    carried: Mapping[str, float]
    turns: Mapping[int, float]  # of the torsional springs, as `Assembly` has them
    held: Mapping[str, float]  # modes and what the motion remembers, by their names

    def system(self, other: Mechanism) -> System:
        """Another mechanism in this state, assembly branch and modes, with the same whole turns."""
        near = {point: np.array(place) for point, place in self.places.items()}
        system = System(other.with_state(self.state), near=near)
        system = system.with_internal(self.internal)
        topology, state = system.topology, system.state.copy()
        for index, name in enumerate(topology.coordinates):
            if name in self.carried and topology.unwrapped(name):
                apart = self.carried[name] - state[index]
                state[index] += 2 * np.pi * np.round(apart / (2 * np.pi))
        return system.turned(state, self.turns).holding(self.held)


def end_of(system: System, motion: Motion, sample: int = -1) -> ContinuationEnd:
    """Where a motion of a system was at one of its samples, the last one if it is not said."""
    piece, place = _piece_at(motion, range(len(motion.time))[sample])
    piece = piece.direct().part(slice(place, place + 1))
    positions = piece.system.model.positions
    nodes = [node for place in positions.joints.values() for node in (place.x, place.y)]
    carried = system.topology.carried
    coordinates = [positions.coordinate(name) for name in carried]
    coordinates += piece.system.model.internal
    result = piece.system.evaluate(
        [*nodes, *coordinates], piece.time, piece.state, flipped=piece.flipped
    )[:, 0]
    held = np.zeros(0) if piece.held is None else piece.held[:, 0]
    first = len(nodes) + len(carried)
    places = zip(*(result[axis : len(nodes) : 2].tolist() for axis in (0, 1)), strict=True)
    return ContinuationEnd(
        state=_free_state(system, motion, sample),
        places=dict(zip(positions.joints, places, strict=True)),
        internal=dict(zip(system.topology.internal, result[first:].tolist(), strict=True)),
        carried=dict(zip(carried, result[len(nodes) : first].tolist(), strict=True)),
        turns=piece.system.assembly.turns,
        held=dict(zip(piece.system.model.switches.names, held.tolist(), strict=True)),
    )


def _piece_at(motion: Motion, sample: int) -> tuple[Piece, int]:
    """The piece that a sample belongs to, and its place there."""
    for piece in motion.pieces:
        if sample < len(piece.wanted):
            return piece, sample
        sample -= len(piece.wanted)
    raise IndexError(sample)


def _free_state(system: System, motion: Motion, sample: int) -> dict[str, tuple[float, float]]:
    """Free coordinates and rates at a sample; angles within one turn unless turns count."""
    whole, within = (free_values(system, motion, wrap) for wrap in (False, True))
    state = {}
    for dim, names in free_names(system).items():
        value, rate = PAIRS[dim]
        for column, name in enumerate(names):
            chosen = whole if system.topology.unwrapped(name) else within
            state[name] = (float(chosen[value][sample, column]), float(whole[rate][sample, column]))
    return state


@dataclass(frozen=True, eq=False)
class Visited:
    """Points of a section, and where the motion was when it came to the first and left the last.

    `first`, `last`: at a whole period of the drives: not behind the first point of a stroboscopic
    section and not before the first crossing; not before the last point. None if it was not asked
    for, or the motion did not come so far.
    """

    values: dict[str, Floats]  # what `poincare` returns of the free coordinates and of contact
    first: ContinuationEnd | None
    last: ContinuationEnd | None
    refusal: ComputationError | None  # what is missing, if the motion stopped
    warning: str = ""  # what `poincare` says of the points
    interval: float = 0.0  # time in seconds between two looks at the forces in clearances


def stroboscopic_points(
    system: System,
    options: SectionOptions,
    ends: tuple[bool, bool] = (True, True),
) -> Going[Visited]:
    """Points of a stroboscopic section of a motion, and its first and last end if wanted.

    Ends are at whole periods beside the first and the last point.
    """
    period = common_period(system.mechanism)
    # without a phase the last point is at a whole period itself
    last = options.skip + options.periods - (not options.phase)
    asked = [*zip((period * options.skip, period * last), ends, strict=True)]
    plan = strobing(system, options, tuple(time for time, wanted in asked if wanted))
    motion = yield from March(system, options).advancing(plan.times)
    places = [int(np.searchsorted(motion.time, time)) if wanted else -1 for time, wanted in asked]
    return _visited(plan.points(motion), motion, places, links(system.model))


def crossing_points(
    mechanism: Mechanism,
    before: ContinuationEnd | None,
    options: SectionOptions,
    ends: bool = True,
) -> Going[Visited]:
    """Crossings of a section, and where the motion was at whole periods of the drives.

    Without a common period nothing distinguishes one time from another, and ends are the crossings
    themselves. With `ends` the motion is followed once more to find them.
    """
    start = System(mechanism) if before is None else before.system(mechanism)
    require_section(start, options)
    plan = crossing(start, options, last_time(start, options))
    followed = yield from March(start, options).advancing(plan.times, guards=plan.guards)
    points = plan.points(followed)
    points.require()
    motion, places = points.motion, [-1, -1]
    if ends and len(points.time):
        times = [_whole(mechanism, float(points.time[place])) for place in (0, -1)]
        motion = yield from March(start, options).advancing(np.unique(times))
        places = [int(np.searchsorted(motion.time, time)) for time in times]
    names = free_names(start).get("clearance", [])
    result = _visited(points, motion, places, names)
    if places[0] >= 0 and result.first is None and result.refusal is None:
        return replace(result, refusal=_refusal(motion.failure, motion.stop_time))
    return result


def _visited(
    points: SectionPoints, motion: Motion, places: Sequence[int], names: Sequence[str]
) -> Visited:
    """What a motion visited, and its ends at some of its samples; −1 for none."""
    first, last = (
        end_of(points.system, motion, place) if 0 <= place < len(motion.time) else None
        for place in places
    )
    return Visited(
        values=points.values(names),
        first=first,
        last=last,
        refusal=_refusal(points.failure, points.motion.stop_time),
        warning=points.warning if points.options.section else "",
        interval=points.interval,
    )


def _refusal(failure: str | None, time: float | None) -> ComputationError | None:
    return None if failure is None else ComputationError(failure, time=time)


def _whole(mechanism: Mechanism, time: float) -> float:
    """The next time at which drives are where they were at the start."""
    try:
        period = common_period(mechanism)
    except NoPeriodError:
        return time
    return period * math.ceil(time / period - WHOLE)


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

    `store`: where answers are kept as they come, in the order of computation: a chunk for each
    value, with the ends that the next one needs.
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
            result: dict[int, Answer] = {}
            for outcome in (executor or Threads()).run(question.answer, points):
                if outcome.value is None:
                    raise ComputationError(str(outcome.reason), time=outcome.stop_time)
                answer, end = outcome.value
                answer = replace(answer, values={**answer.values, END: _written(end)})
                result[outcome.index] = answer
                enter(stacked(fields, [answer]), outcome.index, index, 0)
            part = stacked(fields, [result[row] for row in range(starts)])
            ledger.add(span, part)
            ledger.tell()
            if store is not None:
                store.write(span, part)
    except KeyboardInterrupt:
        return Computed(whole, True)
    return Computed(whole, False)


_ENDS = TypeAdapter(ContinuationEnd)


def _written(end: ContinuationEnd | None) -> str:
    """An end as text, from which it can be read again to the last bit."""
    return "" if end is None else json.dumps(asdict(end))


def _read(text: str) -> ContinuationEnd | None:
    return _ENDS.validate_json(text) if text else None
