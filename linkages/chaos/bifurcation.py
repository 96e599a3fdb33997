"""Bifurcation diagrams: sections of the motion for many values of a parameter."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.common_period import NoPeriodError
from linkages.chaos.continuation import End, crossing_points, stroboscopic_points
from linkages.chaos.diagram import Value, diagram
from linkages.chaos.lyapunov import run_exponents
from linkages.chaos.section import how, require_section, section_settings
from linkages.chaos.sweep import STEPS_PER_PERIOD, Executor, Outcome, Progress, sweep
from linkages.chaos.varied import Axis, Vary, axis_of, coordinates, first_possible
from linkages.components.mechanism import Mechanism
from linkages.errors import ComputationError, InputError, Interrupted
from linkages.kernel.system import System
from linkages.solution.arguments import whole_number
from linkages.solution.flows import Flows
from linkages.solution.motion import Settings

if TYPE_CHECKING:
    import xarray as xr

STARTS = ("same", "forward", "backward")
EXPONENT_PERIODS = 100
ALIGNING = 10
"""Periods in which tangents turn into the direction that grows fastest, before exponents count."""

SECTION = ("periods", "skip", "phase", "section", "direction")

Floats = NDArray[np.float64]

Point = tuple[int, Mapping[str, object], End | None]
"""Index of a value, overrides of an initial state, and where the motion goes on, if it does."""


@dataclass(frozen=True)
class _Request:
    """What is computed at every value."""

    mechanism: Mechanism
    axis: Axis
    section: Mapping[str, Any]
    start: str
    exponent: bool
    max_steps: int | None

    def at(self, index: int, overrides: Mapping[str, object]) -> Mechanism:
        return self.mechanism.with_values({**self.axis.at(index), **overrides})

    def system(self, point: Point) -> System:
        """The mechanism at a value, assembled."""
        return System(self.at(*point[:2]))

    def checked(self, initial: Sequence[Mapping[str, object]]) -> System:
        """The system at the first value that has one; what is wrong everywhere shows here."""
        points: list[list[Point]] = [
            [(index, over, None) for index in range(len(self.axis))] for over in initial
        ]
        system = first_possible(self.system, points[0])
        for others in points[1:]:
            first_possible(lambda point: self.at(*point[:2]), others)
        taken = {key: self.section[key] for key in SECTION}
        try:
            require_section(system, **taken)
        except NoPeriodError:
            first_possible(
                lambda point: require_section(self.system(point), **taken),
                points[0],
                (InputError, NoPeriodError),
            )
        Flows(system).flow()  # compiled here, once, and not by every thread that waits for it
        return system

    def compute(self, point: Point) -> Value:
        """The points of a value, and the exponent of the motion that they belong to."""
        index, overrides, before = point
        mechanism = self.at(index, overrides)
        settings = self._settings(mechanism, self.section["periods"] + self.section["skip"])
        continued = self.start != "same"
        if self.section["section"] is None:
            system = System(mechanism) if before is None else before.system(mechanism)
            taken = {key: self.section[key] for key in ("periods", "skip", "phase")}
            ends = self.exponent, continued
            visited = stroboscopic_points(system, settings, **taken, ends=ends)
        else:
            section = {**self.section, "max_steps": settings.max_steps}
            ends_too = self.exponent or continued
            visited = crossing_points(mechanism, before, settings, section, ends=ends_too)
        if not self.exponent or visited.refusal is not None or visited.first is None:
            return Value(visited, refusal=visited.refusal)
        try:
            return Value(visited, self._exponent(mechanism, visited.first))
        except ComputationError as error:
            return Value(visited, refusal=error)

    @property
    def attributes(self) -> dict[str, Any]:
        """What was asked for, as attributes of a dataset."""
        settings = self._settings(self.mechanism, self.section["periods"] + self.section["skip"])
        taken = {key: "" if found is None else found for key, found in self.section.items()}
        return {
            "name": self.mechanism.name,
            "source": self.mechanism.source,
            "varied": self.axis.label,
            "start": self.start,
            **taken,
            **how(settings),
            "max_steps": settings.max_steps,
            "exponent_periods": EXPONENT_PERIODS if self.exponent else 0,
        }

    def _settings(self, mechanism: Mechanism, periods: int) -> Settings:
        steps = STEPS_PER_PERIOD * periods if self.max_steps is None else self.max_steps
        return section_settings(mechanism, self.section["method"], self.section["rtol"], steps)

    def _exponent(self, mechanism: Mechanism, first: End) -> tuple[float, float]:
        """The largest exponent and its error, from where the points begin."""
        exponents = run_exponents(
            first.system(mechanism),
            self._settings(mechanism, ALIGNING + EXPONENT_PERIODS),
            periods=EXPONENT_PERIODS,
            skip=ALIGNING,
            count=1,
        )
        return float(exponents.values[0]), float(exponents.errors[0])


def bifurcation(
    mechanism: Mechanism,
    vary: Vary,
    *,
    periods: int = 200,
    skip: int = 100,
    phase: float = 0.0,
    section: str | None = None,
    direction: str = "up",
    start: str = "same",
    initial: Sequence[Mapping[str, object]] = ({},),
    exponent: bool = False,
    method: str | None = None,
    rtol: float | None = None,
    max_steps: int | None = None,
    executor: Executor | None = None,
    watch: Callable[[Progress], None] | None = None,
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
    periods, skip, phase, section, direction, method, rtol
        As `linkages.poincare` takes them.
    start
        ``"same"``: each value starts from the state of the definition; ``"forward"`` or
        ``"backward"``: from the last state of the value before or behind it, in the same assembly
        mode and at the start of a period of the drives, which shows hysteresis.
    initial
        Overrides of the definition, one for each initial state that is tried at every value, such
        as ``[{"clearances.r1.angle": 0}, {"clearances.r1.angle": 1.57}]``.
    exponent
        Whether to compute the largest Lyapunov exponent at every value as well: of the motion that
        the points belong to, over 100 periods that begin 10 after the first point.
    max_steps
        Steps of the integration that a value may take, and its exponent once more; one that needs
        more is left out, with this as its reason. 100,000 for each period if not given.
    executor
        Where values are computed; the cores that this process may use if not given.
    watch
        Called after each value with the progress.

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
    if start not in STARTS:
        raise ValueError(f"start must be one of {', '.join(STARTS)}, found {start!r}")
    periods, skip = whole_number("periods", periods), whole_number("skip", skip)
    max_steps = None if max_steps is None else whole_number("max_steps", max_steps)
    taken = {"periods": periods, "skip": skip, "phase": phase, "section": section,
             "direction": direction, "method": method, "rtol": rtol}  # fmt: skip
    request = _Request(mechanism, values, taken, start, exponent, max_steps)
    system = request.checked(initial)
    compute = _independent if start == "same" else _continued
    found, interrupted = compute(request, initial, executor, watch)
    shape = len(initial), len(values)
    attributes = {**request.attributes, "interrupted": int(interrupted)}
    data = diagram(
        system, found, shape, periods, exponent, coordinates(mechanism, values, "value"), attributes
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
    order = range(count) if request.start == "forward" else range(count - 1, -1, -1)
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
