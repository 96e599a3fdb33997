"""The isoperiodic plane: after how many periods of the drives a motion repeats, point by point."""

from __future__ import annotations

from abc import ABC
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.contact_log import TOUCH
from linkages.chaos.continuation import Outcome, Point, continued, end_of
from linkages.chaos.diagram import free_names_of_angles, touchable
from linkages.chaos.strobed_motion import REGIMES, Followed, Regime, plane_fields
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError, LinkagesError
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.options.analysis_options import MapOptions
from linkages.solution.many import Going, cpu_only, side_by_side
from linkages.solution.run_options import options_of
from linkages.sweeps.engine import (
    SIDE_BY_SIDE,
    Answer,
    Arrays,
    Code,
    Computed,
    Field,
    Question,
    Watch,
    chunk_size,
    computed,
    end_when_stopping,
    first_system,
    marks,
    refusal_code,
    stop_code,
)
from linkages.sweeps.places import swept
from linkages.sweeps.points import Points
from linkages.sweeps.refinement import refined
from linkages.sweeps.running import (
    Executor,
    Progress,
    TaskOutcome,
    Threads,
    per_period,
    stopping,
)
from linkages.sweeps.store import SweepStore, stored

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
Integers = NDArray[np.intp]

OF_PERIODS = ("start", "refine")
"""Options of the indicator ``period`` alone; stores of other ones do not have them."""


@dataclass(frozen=True, eq=False)
class MapQuestion(Question, ABC):
    """What is asked at the points of a grid, row by row, or at some of them.

    `varying`, `points`, `given`: what is varied, the grid, and the options that were given.
    """

    varying: Varying
    points: Points
    given: Mapping[str, Any]
    chosen: Integers | None = field(default=None)  # places of the points in the grid; None for all

    @property
    def count(self) -> int:
        """Number of points."""
        return self.points.count if self.chosen is None else len(self.chosen)

    @property
    def described(self) -> dict[str, Any]:
        """What is asked."""
        only = () if self.options.indicator == "period" else OF_PERIODS
        own = {name: value for name, value in self.given.items() if name not in only}
        return {"analysis": "map", "options": own, **self.points.described}

    def places(self, first: int, last: int) -> Integers:
        """Places of some of the points in the grid."""
        return np.arange(first, last) if self.chosen is None else self.chosen[first:last]

    def numbers(self) -> Floats:
        """Numbers of all points."""
        return self.points.matrix_of(self.places(0, self.count))

    @cached_property
    def first(self) -> System:
        """The first system that can be built; what is wrong everywhere shows there."""
        return first_system(self.varying, self.points)

    @cached_property
    def options(self) -> MapOptions:
        """What is asked for where nothing is varied."""
        return self.options_at(self.varying.mechanism)

    def options_at(self, mechanism: Mechanism) -> MapOptions:
        """The same at a point, in the steps that it may take."""
        options = options_of(MapOptions, mechanism, self.given)
        return per_period(options, options.periods + options.skip)

    together = SIDE_BY_SIDE


@dataclass(frozen=True, eq=False)
class Plane(MapQuestion):
    """What motions settle to."""

    states: bool = False  # whether the last state of each motion is wanted

    @property
    def described(self) -> dict[str, Any]:
        """What is asked."""
        return {**super().described, **({"states": True} if self.states else {})}

    @cached_property
    def fields(self) -> Mapping[str, Field]:
        """What is found at a point."""
        return plane_fields(self.first, self.states)

    @property
    def cpu_only(self) -> str:
        """What of it is computed on the CPU only."""
        if self.options.start != "same":
            return "a map whose points go on from each other"
        return cpu_only(self.first, self.options)

    def answers(self, first: int, last: int) -> list[Answer]:
        """What is found at some points, each from the state of the definition."""
        _ = self.first  # all points are built upon the same one, wherever they are computed
        overrides = self.points.overrides_of(self.places(first, last))
        along = self.varying.along(overrides)
        tasks = [
            self._attempted(overrides[place], partial(along.system, place))
            for place in range(len(along))
        ]
        found = side_by_side(tasks, end_when_stopping)
        return [outcome[0] for outcome in found if not isinstance(outcome, LinkagesError)]

    def _attempted(
        self, overrides: Mapping[str, object], start: Callable[[], System], ends: bool = False
    ) -> Going[Outcome]:
        """What is found at a point, and where its motion ended if that is asked for."""
        if stopping():
            raise KeyboardInterrupt
        followed: Followed | None = None
        try:
            system = start()
            followed = Followed(system, self.options_at(system.mechanism), self.states)
            answer = followed.answer((yield from followed.going()))
            return answer, end_of(system, followed.motions[-1]) if ends else None
        except InputError as error:
            return Answer.of(error, refusal_code(self.varying, overrides)), None
        except (LinkagesError, ValueError) as error:
            cost = 0 if followed is None else followed.march.cost["evaluations"]
            return Answer.of(error, stop_code(error), cost), None


@dataclass(frozen=True, eq=False)
class Neighbours(Plane):
    """The same, each point from the last state of its neighbour in the row.

    As `continued` takes what goes on: rows are its initial states, columns its values.
    """

    @property
    def initial(self) -> list[dict[str, object]]:
        """What is varied from row to row."""
        rows, columns = self.points.shape
        whole = self.points.overrides_of(columns * np.arange(rows))
        return [{path: each[path] for path in self.points.axes[0].paths} for each in whole]

    @cached_property
    def _columns(self) -> list[dict[str, object]]:
        whole = self.points.overrides(0, self.points.shape[1])
        return [{path: each[path] for path in self.points.axes[1].paths} for each in whole]

    def answer(self, point: Point) -> Outcome:
        """What is found at a point, and where its motion ended."""
        return self.outcomes([point])[0]

    def outcomes(self, points: Sequence[Point]) -> list[Outcome]:
        """The same of several points, side by side."""
        _ = self.first
        found = side_by_side([self._going_on(point) for point in points], end_when_stopping)
        return [outcome for outcome in found if not isinstance(outcome, LinkagesError)]

    def _going_on(self, point: Point) -> Going[Outcome]:
        index, row, before = point
        overrides = {**row, **self._columns[index]}

        def start() -> System:
            if before is None:
                return self.varying.at(overrides)
            return before.system(self.varying.mechanism_at(overrides))

        return self._attempted(overrides, start, ends=True)


class _Together:
    """An executor for the points of a column: many are computed side by side."""

    def __init__(self, question: Neighbours, executor: Executor | None) -> None:
        self._question, self._executor = question, executor or Threads()

    def run(self, _task: Callable[[Any], Any], points: Sequence[Any]) -> Iterator[TaskOutcome]:
        """Yield outcomes as they come."""
        fewest, most = SIDE_BY_SIDE
        workers: int = getattr(self._executor, "workers", 1)
        size = max(fewest, min(most, -(-len(points) // workers)))
        parts = [points[at : at + size] for at in range(0, len(points), size)]
        for outcome in self._executor.run(self._question.outcomes, parts):
            for place in range(len(parts[outcome.index])):
                value = None if outcome.value is None else outcome.value[place]
                yield replace(outcome, index=size * outcome.index + place, value=value)


def computed_plane(
    question: Plane,
    mechanism: Mechanism,
    made: Callable[[Computed, Integers], xr.Dataset],
    *,
    store: str | Path | None,
    watch: Watch | None,
    **where: Any,
) -> xr.Dataset:
    """What is found at all points.

    `made`: makes the dataset of what was found and of the place of the point from which each has
    it.
    `store`: folder in which results are kept; of a refined plane it has a store for each round.
    `where`: device and executor, as `swept` takes them.
    """
    source = np.arange(question.points.count)
    asked: Plane = question
    how: dict[str, Any] = {"store": store}
    if question.options.start != "same":
        given = question.varying, question.points, question.given
        moving = asked = Neighbours(*given, states=question.states)
        forward = question.options.start == "forward"

        def in_turn(executor: Executor | None, place: SweepStore | None) -> Computed:
            return continued(moving, forward, _Together(moving, executor), place, watch)

        how |= {"chunk": question.points.shape[0], "answers": in_turn}
    elif question.options.refine > 1:

        def refined_there(executor: Executor | None, _: SweepStore | None) -> Computed:
            folder = None if store is None else Path(store)
            found, source[:] = _refined_plane(question, mechanism, executor, folder, watch)
            return found

        how = {"answers": refined_there}
    return swept(
        asked, mechanism, "map", "points", lambda found: made(found, source),
        watch=watch, **how, **where,
    )  # fmt: skip


def _refined_plane(
    question: Plane,
    mechanism: Mechanism,
    executor: Executor | None,
    store: Path | None,
    watch: Watch | None,
) -> tuple[Computed, Integers]:
    """What is found where neighbours differ, and the place of the point from which each has it."""
    count = question.points.count
    whole, kinds = question.nothing(count), dict[bytes, int]()

    def labels(places: Integers) -> list[int]:
        before = int((whole["outcome"] != Code.MISSING).sum())
        part = Plane(question.varying, question.points, question.given, places)
        folder = None if store is None else store / f"from_{before:09d}"

        def seen(progress: Progress) -> None:
            if watch is not None:
                watch(replace(progress, done=progress.done + before, total=count))

        size = chunk_size(part, executor or Threads())  # few points are left together, otherwise
        with stored(folder, mechanism, part, size) as kept:
            found = computed(part, executor=executor, store=kept, watch=seen)
        _enter(whole, places, found.arrays)
        if found.interrupted:
            raise KeyboardInterrupt
        return [kinds.setdefault(kind, len(kinds)) for kind in _kinds(found.arrays)]

    rows, columns = question.points.shape
    try:
        source = refined((rows, columns), question.options.refine, labels)
    except KeyboardInterrupt:
        return Computed(whole, True), np.arange(count)
    return Computed(_filled(whole, source), False), source


def _enter(whole: Arrays, places: Integers, part: Arrays) -> None:
    """Enter what was found at some points; texts become as long as they need."""
    for name, array in part.items():
        whole[name] = whole[name].astype(np.promote_types(whole[name].dtype, array.dtype))
        whole[name][places] = array


def _kinds(found: Arrays) -> list[bytes]:
    """What makes points differ: outcome, regime, period, and touches and turns in a period."""
    period = np.nan_to_num(found["indicator"])[:, None]
    columns = [found["outcome"][:, None], found["regime"][:, None], period]
    repeated = (found[name] * period for name in ("touches", "rotation_number") if name in found)
    columns += [np.where(period > 0, np.round(numbers, 6), 0.0) for numbers in repeated]
    rows = np.nan_to_num(np.concatenate(columns, axis=1), nan=-1.0) + 0.0  # no negative zeros
    return [row.tobytes() for row in rows]


def _filled(whole: Arrays, source: Integers) -> Arrays:
    """Points that were not computed have the result of another one, as far as it is the same."""
    result = {name: array[source] for name, array in whole.items()}
    filled = source != np.arange(len(source))
    result["lasted"][filled] = result["evaluations"][filled] = 0
    result["contraction"][filled] = result["stop_time"][filled] = np.nan
    mean = filled & (result["regime"] != Regime.PERIODIC)
    for name in ("touches", "rotation_number"):
        if name in result:
            result[name][mean] = np.nan
    return result


def plane_data(
    first: System,
    found: Arrays,
    source: Integers,
    shape: tuple[int, ...],
    varied: Mapping[str, Any],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """The plane as labelled arrays.

    `source`: place of the point from which each point has its result.
    `shape`: numbers of rows and of columns.
    """
    import xarray as xr

    grid = {name: array.reshape(*shape, *array.shape[1:]) for name, array in found.items()}
    texts = {
        "indicator": ("", "period in periods of the drives"),
        "contraction": ("", "factor by which distances from the cycle shrink in its period"),
        "lasted": ("", "periods of the drives that were integrated"),
        "touches": ("1", "touches per period"),
        "rotation_number": ("1", "turns per period of the drives"),
        "state": ("", "last state at the beginning of a period, in SI"),
    }
    dims: dict[str, tuple[str, ...]] = {
        "touches": (TOUCH,), "rotation_number": ("coordinate",), "state": ("entry",)
    }  # fmt: skip
    variables: dict[str, Any] = {
        name: (("y", "x", *dims.get(name, ())), grid[name], {"units": units, "long_name": text})
        for name, (units, text) in texts.items()
        if name in grid
    }
    filled = (source != np.arange(len(source))).astype("i1").reshape(shape)
    variables |= {
        "regime": (("y", "x"), grid["regime"], REGIMES),
        "filled": (("y", "x"), filled, {"long_name": "taken from a neighbour, not computed"}),
        **marks(found, ("y", "x"), shape),
    }
    members: dict[str, Any] = {}
    if "touches" in grid:
        members[TOUCH] = np.array(touchable(first), dtype=object)
    if "rotation_number" in grid:
        members["coordinate"] = np.array(free_names_of_angles(first), dtype=object)
    return xr.Dataset(variables, {**varied, **members}, attributes)
