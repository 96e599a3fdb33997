"""Bifurcation diagrams: sections of the motion for many values of a parameter."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.growth.lyapunov import run_exponents
from linkages.chaos.sections.common_period import NoPeriodError
from linkages.chaos.sections.section import require_section
from linkages.chaos.sweeps.continuation import End, crossing_points, stroboscopic_points
from linkages.chaos.sweeps.diagram import Value, diagram
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError, InputError, Interrupted
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.options.exponents import ExponentOptions
from linkages.options.sections import BifurcationKeywords, BifurcationOptions
from linkages.options.signature import takes
from linkages.solution.moving.plan import Plan
from linkages.solution.options import options_of
from linkages.sweeps.axes import Axis, Vary, axis_of, coordinates, first_possible
from linkages.sweeps.running import Executor, Outcome, Progress, per_period, sweep

if TYPE_CHECKING:
    import xarray as xr

EXPONENT_PERIODS = 100
ALIGNING = 10
"""Periods in which tangents turn into the direction that grows fastest, before exponents count."""

Floats = NDArray[np.float64]

Point = tuple[int, Mapping[str, object], End | None]
"""Index of a value, overrides of an initial state, and where the motion goes on, if it does."""


@dataclass(frozen=True)
class _Request:
    """What is computed at every value."""

    varying: Varying
    axis: Axis
    given: Mapping[str, Any]

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

    def checked(self, initial: Sequence[Mapping[str, object]]) -> System:
        """The system at the first value that has one; what is wrong everywhere shows here."""
        points: list[list[Point]] = [
            [(index, over, None) for index in range(len(self.axis))] for over in initial
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
        Plan.of(system).bind(
            system
        )  # compiled here, once, and not by every thread that waits for it
        return system

    def compute(self, point: Point) -> Value:
        """The points of a value, and the exponent of the motion that they belong to."""
        index, overrides, before = point
        mechanism = self.at(index, overrides)
        options = self.options_at(mechanism, self._periods)
        continued = options.start != "same"
        if options.section is None:
            system = self.system(point)
            ends = options.exponent, continued
            visited = stroboscopic_points(system, options, ends=ends)
        else:
            ends_too = options.exponent or continued
            visited = crossing_points(mechanism, before, options, ends=ends_too)
        if not options.exponent or visited.refusal is not None or visited.first is None:
            return Value(visited, refusal=visited.refusal)
        try:
            return Value(visited, self._exponent(mechanism, visited.first))
        except ComputationError as error:
            return Value(visited, refusal=error)

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
            "source": mechanism.source,
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

    def _exponent(self, mechanism: Mechanism, first: End) -> tuple[float, float]:
        """The largest exponent and its error, from where the points begin."""
        options = ExponentOptions.like(
            self.options_at(mechanism, ALIGNING + EXPONENT_PERIODS),
            periods=EXPONENT_PERIODS,
            skip=ALIGNING,
            count=1,
        )
        exponents = run_exponents(first.system(mechanism), options)
        return float(exponents.values[0]), float(exponents.errors[0])


@takes(BifurcationOptions)
def bifurcation(
    mechanism: Mechanism,
    vary: Vary,
    *,
    initial: Sequence[Mapping[str, object]] = ({},),
    executor: Executor | None = None,
    watch: Callable[[Progress], None] | None = None,
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
    executor
        Where values are computed; the cores that this process may use if not given.
    watch
        Called after each value with the progress.
    options
        As `BifurcationOptions` describes them.

    Returns
    -------
    Dataset with the free coordinates and their rates (start, value, crossing, …), and with
    `exponent` and its `error` (start, value) if asked for. What is varied is a coordinate, in the
    unit of its attribute ``units``: SI, or that of the range. `reason` (start, value) says why a
    value could not be computed, which leaves nan, and `stop_time` when its motion stopped; points
    before that are there. `warning` (start, value) says where there are fewer points than asked
    for. With clearances, `contact_lost` and `least_force` (start, value, clearance) as
    `linkages.poincare` has them.

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
    request = _Request(Varying(mechanism), values, options)
    asked = request.options
    system = request.checked(initial)
    compute = _independent if asked.start == "same" else _continued
    found, interrupted = compute(request, initial, executor, watch)
    shape = len(initial), len(values)
    attributes = {**request.attributes, "interrupted": int(interrupted)}
    data = diagram(
        system,
        found,
        shape,
        asked.periods,
        asked.exponent,
        coordinates(mechanism, values, "value"),
        attributes,
    )
    if interrupted:
        done = sum(outcome is not None for outcome in found)
        message = f"interrupted after {done} of {len(found)} values"
        raise Interrupted(message, kept={"bifurcation": data})
    return data


Found = tuple[list[Outcome | None], bool]
"""For one start after the other the outcomes at all values, and whether that is not all."""


def _independent(
    request: _Request,
    initial: Sequence[Mapping[str, object]],
    executor: Executor | None,
    watch: Callable[[Progress], None] | None,
) -> Found:
    """Every value from the state of the definition."""
    points: list[Point] = [(i, over, None) for over in initial for i in range(len(request.axis))]
    swept = sweep(request.compute, points, executor=executor, watch=watch)
    return list(swept.outcomes), swept.interrupted


def _continued(
    request: _Request,
    initial: Sequence[Mapping[str, object]],
    executor: Executor | None,
    watch: Callable[[Progress], None] | None,
) -> Found:
    """Every value from the last state of its neighbour, all initial states side by side."""
    count = len(request.axis)
    order = range(count) if request.options.start == "forward" else range(count - 1, -1, -1)
    ends: list[End | None] = [None for _ in initial]
    found: list[Outcome | None] = [None] * (len(initial) * count)
    begun = time.monotonic()
    for done, index in enumerate(order):
        swept = sweep(
            request.compute,
            [(index, *start) for start in zip(initial, ends, strict=True)],
            executor=executor,
            watch=_onwards(watch, done * len(initial), count * len(initial), begun),
        )
        for row, outcome in enumerate(swept.outcomes):
            found[row * count + index] = outcome
            if outcome is not None and outcome.value is not None:
                ends[row] = outcome.value.visited.last or ends[row]
        if swept.interrupted:
            return found, True
    return found, False


def _onwards(
    watch: Callable[[Progress], None] | None, before: int, total: int, begun: float
) -> Callable[[Progress], None] | None:
    """Progress of one value as progress of all."""
    if watch is None:
        return None
    return lambda progress: watch(Progress.after(before + progress.done, total, begun))
