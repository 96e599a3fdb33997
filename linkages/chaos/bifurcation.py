"""Bifurcation diagrams over a parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.common_period import NoPeriodError
from linkages.chaos.continuation import (
    ContinuationEnd,
    Outcome,
    Point,
    Visited,
    continued,
    crossing_points,
    stroboscopic_points,
)
from linkages.chaos.diagram import Value, answer_of, diagram, put_together, value_fields, ways
from linkages.chaos.lyapunov import exponents_of
from linkages.chaos.sections import require_section
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError, InputError, LinkagesError
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.options.analysis_options import (
    BifurcationKeywords,
    BifurcationOptions,
    ExponentOptions,
)
from linkages.options.option import takes
from linkages.reading.overrides import NEXT, parse_assignment
from linkages.solution.many import Going, cpu_only, side_by_side
from linkages.solution.march import alone
from linkages.solution.plan import Plan
from linkages.solution.run_options import options_of
from linkages.sweeps.axes import Axis, Vary, axis_of, coordinates, first_possible, require_feasible
from linkages.sweeps.engine import (
    SIDE_BY_SIDE,
    Answer,
    Field,
    Question,
    Watch,
    end_when_stopping,
    refusal_code,
    stop_code,
)
from linkages.sweeps.places import swept
from linkages.sweeps.running import Executor, per_period, stopping

if TYPE_CHECKING:
    import xarray as xr

EXPONENT_PERIODS = 100
ALIGNING = 10
"""Periods in which tangents turn into the direction that grows fastest, before exponents count."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Request(Question):
    """What is computed at every value, for one initial state after the other."""

    varying: Varying
    axis: Axis
    initial: tuple[Mapping[str, object], ...]
    given: Mapping[str, Any]

    @property
    def count(self) -> int:
        """Number of values, for all initial states."""
        return len(self.axis) * len(self.initial)

    @property
    def described(self) -> dict[str, Any]:
        """What is asked."""
        return {
            "analysis": "bifurcation",
            "paths": list(self.axis.paths),
            "initial": [dict(state) for state in self.initial],
            "options": dict(self.given),
        }

    def numbers(self) -> Floats:
        """Numbers of all points."""
        return np.tile(self.axis.values.T, (len(self.initial), 1))

    @cached_property
    def first(self) -> System:
        """The system at the first value that has one; what is wrong everywhere shows here."""
        return self._checked()

    @cached_property
    def fields(self) -> Mapping[str, Field]:
        """Points of the section, exponents and forces in clearances."""
        return value_fields(self.first, self.options.periods, self.options.section)

    @property
    def cpu_only(self) -> str:
        """What of it is computed on the CPU only."""
        asked = self.options
        if asked.section is not None:
            return "a diagram of crossings of a section"
        if asked.start != "same":
            return "a diagram whose values go on from each other"
        return cpu_only(self.first, asked)

    together = SIDE_BY_SIDE

    def answers(self, first: int, last: int) -> list[Answer]:
        """What is found at some points, each from the state of the definition."""
        _ = self.first  # all points are built upon the same one, wherever they are computed
        size = len(self.axis)
        points: list[Point] = [
            (place % size, self.initial[place // size], None) for place in range(first, last)
        ]
        result = side_by_side([self._attempted(point) for point in points], end_when_stopping)
        return [outcome[0] for outcome in result if not isinstance(outcome, LinkagesError)]

    def answer(self, point: Point) -> Outcome:
        """What is found at a value, and where its motion ended."""
        return alone(self._attempted(point))

    def _attempted(self, point: Point) -> Going[Outcome]:
        if stopping():
            raise KeyboardInterrupt
        try:
            return (yield from self._computed(point))
        except InputError as error:
            overrides = {**self.axis.at(point[0]), **point[1]}
            return Answer.of(error, refusal_code(self.varying, overrides)), None
        except (LinkagesError, ValueError) as error:
            return Answer.of(error, stop_code(error)), None

    @cached_property
    def options(self) -> BifurcationOptions:
        """What is asked for where nothing is varied."""
        return options_of(BifurcationOptions, self.varying.mechanism, self.given)

    def options_at(self, mechanism: Mechanism, periods: int) -> BifurcationOptions:
        """The same at a value, in the steps that so many periods may take."""
        return per_period(options_of(BifurcationOptions, mechanism, self.given), periods)

    def at(self, index: int, overrides: Mapping[str, object]) -> Mechanism:
        return self.varying.mechanism_at({**self.axis.at(index), **overrides})

    def system(self, point: Point) -> System:
        """The mechanism at a value, assembled; where another motion ended, if it goes on there."""
        index, overrides, before = point
        if before is not None:
            return before.system(self.at(index, overrides))
        return self.varying.at({**self.axis.at(index), **overrides})

    def _checked(self) -> System:
        points: list[list[Point]] = [
            [(index, over, None) for index in range(len(self.axis))] for over in self.initial
        ]
        system = first_possible(self.system, points[0])
        for others in points[1:]:
            first_possible(lambda point: self.at(*point[:2]), others)
        try:
            require_section(system, self.options)
        except NoPeriodError:
            first_possible(
                lambda point: require_section(self.system(point), self.options),
                points[0],
                (InputError, NoPeriodError),
            )
        return system

    def _computed(self, point: Point) -> Going[Outcome]:
        """The points of a value, and the exponent of the motion that they belong to."""
        index, overrides, before = point
        mechanism = self.at(index, overrides)
        options = self.options_at(mechanism, self._periods)
        continued = options.start != "same"
        if options.section is None:
            ends = options.exponent, continued
            visited = yield from stroboscopic_points(self.system(point), options, ends=ends)
        else:
            ends_too = options.exponent or continued
            visited = yield from crossing_points(mechanism, before, options, ends=ends_too)
        return (yield from self._finished(mechanism, visited))

    def _finished(self, mechanism: Mechanism, visited: Visited) -> Going[Outcome]:
        """What a motion visited, and its exponent if that is asked for."""
        value = Value(visited, refusal=visited.refusal)
        asked = self.options.exponent and visited.refusal is None
        if asked and visited.first is not None:
            try:
                value = Value(visited, (yield from self._exponent(mechanism, visited.first)))
            except ComputationError as error:
                value = Value(visited, refusal=error)
        return answer_of(value, self.options.periods), visited.last

    @property
    def _periods(self) -> int:
        return self.options.periods + self.options.skip

    @property
    def attributes(self) -> dict[str, Any]:
        """What was asked for, as attributes of a dataset."""
        mechanism = self.varying.mechanism
        taken = per_period(self.options, self._periods)
        return {
            "name": mechanism.name,
            "source": mechanism.file_name,
            "varied": self.axis.label,
            "start": taken.start,
            "periods": taken.periods,
            "skip": taken.skip,
            "phase": taken.phase,
            "section": taken.section or "",
            "direction": taken.direction,
            **taken.how,
            "max_steps": taken.most_steps,
            "exponent_periods": EXPONENT_PERIODS if taken.exponent else 0,
        }

    def _exponent(self, mechanism: Mechanism, first: ContinuationEnd) -> Going[tuple[float, float]]:
        """The largest exponent and its error, from where the points begin."""
        options = ExponentOptions.like(
            self.options_at(mechanism, ALIGNING + EXPONENT_PERIODS),
            periods=EXPONENT_PERIODS,
            skip=ALIGNING,
            count=1,
        )
        exponents = yield from exponents_of(first.system(mechanism), options)
        return exponents.largest


@takes(BifurcationOptions)
def bifurcation(
    mechanism: Mechanism,
    vary: Vary,
    *,
    initial: Sequence[Mapping[str, object]] = ({},),
    device: str = "cpu",
    executor: Executor | None = None,
    store: str | Path | None = None,
    watch: Watch | None = None,
    **options: Unpack[BifurcationKeywords],
) -> xr.Dataset:
    """Section points for every value of a parameter, or of several in lockstep.

    Parameters
    ----------
    mechanism
        From a file or made in Python.
    vary
        Dotted path of its definition → values: numbers in SI, texts with one unit, such as
        ``["0.1 mm", "0.2 mm"]``, or a quantity of pint; several paths vary together. Or a range as
        on the command line: ``"clearances.r1.size=0.01mm:0.5mm:200"``, or several.
    initial
        Overrides of the definition, one for each initial state that is tried at every value, such
        as ``[{"clearances.r1.angle": 0}, {"clearances.r1.angle": 1.57}]``.
    device
        ``"cuda"``: motions are integrated on the first graphics processor of this machine. Not for
        crossings of sections, and values that go on from each other.
    executor
        Where values are computed; the cores that this process may use if not given.
    store
        Folder in which results are kept as they come; the same call goes on there.
    watch
        Called after each value with the progress.
    options
        As `BifurcationOptions` describes them.

    Returns
    -------
    Dataset with the free coordinates and their rates (start, value, crossing, …), and with
    `exponent` and its `error` (start, value) if asked for. What is varied is a coordinate, in the
    unit of its attribute ``units``: SI, or that of the range. `reason` (start, value) says why a
    value could not be computed, which leaves nan, `outcome` (start, value) says it by a code, and
    `stop_time` when its motion stopped; points before that are there. `warning` (start, value) says
    where there are fewer points than asked for. With clearances, `contact_lost` and `least_force`
    (start, value, clearance) as `linkages.poincare` has them.

    Raises
    ------
    InputError
        If a path names nothing or nothing is free.
    ValueError, TypeError
        For arguments that make no sense.
    Interrupted
        After Ctrl-C; ``kept["bifurcation"]`` has the values so far.
    """
    values = axis_of(vary)
    if isinstance(initial, Mapping | str):
        raise TypeError(f"initial must be a list of mappings, found {initial!r}")
    given = {name: value for name, value in options.items() if value is not None}
    question = _Request(Varying(mechanism), values, tuple(initial), given)
    asked, system = question.options, question.first
    require_feasible(question.count)
    # compiled here, once, and not by every thread that waits for it
    Plan.of(system).bind(system)
    shape = len(initial), len(values)
    varied = coordinates(mechanism, values, "value")
    made = partial(diagram, system, shape, asked.exponent, varied, question.attributes)
    going_on = partial(continued, question, asked.start == "forward", watch=watch)
    same = asked.start == "same"
    return swept(
        question, mechanism, "bifurcation", "values", made,
        device=device, executor=executor, store=store, watch=watch,
        chunk=None if same else len(initial), answers=None if same else going_on,
    )  # fmt: skip


@takes(BifurcationOptions)
def bifurcation_asked(
    mechanism: Mechanism,
    vary: Sequence[str],
    *,
    initial: Sequence[str] = (),
    **options: Any,
) -> xr.Dataset:
    """The diagram of a command: ranges and initial states are texts, and it may go both ways.

    Parameters
    ----------
    mechanism, vary
        As `linkages.bifurcation` takes them.
    initial
        ``PATH=VALUE,…`` for each initial state.
    options
        As `BifurcationOptions` describes them.
    """
    states: list[Mapping[str, object]] = [
        dict(map(parse_assignment, NEXT.split(text))) for text in initial
    ] or [{}]
    start = str(options.pop("start", "same"))
    parts = [
        bifurcation(mechanism, vary, start=one, initial=states, **options) for one in ways(start)
    ]
    return put_together(parts, start, states)
