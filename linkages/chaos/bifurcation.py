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
from linkages.chaos.free_states import PAIRS, free_names
from linkages.chaos.lyapunov import run_exponents
from linkages.chaos.section import poincare, require_section, section_settings
from linkages.chaos.sweep import INTERRUPTED, Executor, Progress, sweep
from linkages.chaos.varied import Axis, axis, first_possible, units, varied
from linkages.components.mechanism import Mechanism
from linkages.errors import InputError
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.solution.motion import Settings

if TYPE_CHECKING:
    import xarray as xr

STARTS = ("same", "forward", "backward")
EXPONENT_PERIODS = 100
SECTION = ("periods", "skip", "phase", "section", "direction")

Floats = NDArray[np.float64]


Point = tuple[int, Mapping[str, object]]
"""Index of a value, and overrides of an initial state."""

Followed = tuple[dict[str, Floats], End | None]
"""What was found at a value, and from where its neighbour goes on; None if the motion stopped."""


@dataclass(frozen=True)
class _Request:
    """What is computed at every value."""

    mechanism: Mechanism
    axis: Axis
    section: Mapping[str, Any]
    exponent: bool

    def at(self, index: int, overrides: Mapping[str, object]) -> Mechanism:
        return varied(self.mechanism, {**self.axis.at(index), **overrides})

    def system(self, point: Point) -> System:
        """The mechanism at a value, assembled."""
        return System(self.at(*point))

    def checked(self, initial: Sequence[Mapping[str, object]]) -> System:
        """The system at the first value that has one; what is wrong everywhere shows here."""
        points = [[(index, over) for index in range(len(self.axis))] for over in initial]
        system = first_possible(self.system, points[0])
        for others in points[1:]:
            first_possible(lambda point: self.at(*point), others)
        taken = {key: self.section[key] for key in SECTION}
        try:
            require_section(system, **taken)
        except NoPeriodError:
            first_possible(
                lambda point: require_section(self.system(point), **taken),
                points[0],
                (InputError, NoPeriodError),
            )
        return system

    def compute(self, point: Point) -> dict[str, Floats]:
        """The points of a value from the state of the file."""
        mechanism = self.at(*point)
        data = poincare(mechanism, **self.section)
        found = {str(name): np.asarray(values) for name, values in data.data_vars.items()}
        return found | self._exponent(mechanism, None)

    def follow(self, point: tuple[int, Mapping[str, object], End | None]) -> Followed:
        """The points of a value from where another motion ended, and where this one ends."""
        index, overrides, before = point
        mechanism = self.at(index, overrides)
        if self.section["section"] is None:
            system = _going_on(mechanism, before)
            taken = {key: self.section[key] for key in ("periods", "skip", "phase")}
            found, end = stroboscopic_points(system, self._settings(mechanism), **taken)
        else:
            settings = self._settings(mechanism)
            found, end = crossing_points(mechanism, before, settings, self.section)
        return found | self._exponent(mechanism, before), end

    def _settings(self, mechanism: Mechanism) -> Settings:
        return section_settings(mechanism, self.section["method"], self.section["rtol"])

    def _exponent(self, mechanism: Mechanism, before: End | None) -> dict[str, Floats]:
        """The largest exponent and its error, if they are asked for."""
        if not self.exponent:
            return {}
        exponents = run_exponents(
            _going_on(mechanism, before),
            self._settings(mechanism),
            periods=EXPONENT_PERIODS,
            skip=self.section["skip"],
            count=1,
        )
        return {"exponent": exponents.values[0], "error": exponents.errors[0]}


def _going_on(mechanism: Mechanism, before: End | None) -> System:
    return System(mechanism) if before is None else before.system(mechanism)


def bifurcation(
    mechanism: Mechanism,
    vary: Mapping[str, Sequence[float] | Floats] | Axis,
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
    executor: Executor | None = None,
    watch: Callable[[Progress], None] | None = None,
) -> xr.Dataset:
    """Section points for every value of a parameter, or of several in lockstep.

    Parameters
    ----------
    mechanism
        From `linkages.load`.
    vary
        Dotted path of the definition file → its values in SI; several paths vary together.
    periods, skip, phase, section, direction, method, rtol
        As `linkages.poincare` takes them.
    start
        ``"same"``: each value starts from the state of the file; ``"forward"`` or ``"backward"``:
        from the last state of the value before or behind it, in the same assembly mode and at the
        start of a period of the drives, which shows hysteresis.
    initial
        Overrides of the file, one for each initial state that is tried at every value, such as
        ``[{"clearances.r1.angle": 0}, {"clearances.r1.angle": 1.57}]``.
    exponent
        Whether to compute the largest Lyapunov exponent at every value as well, over 100 periods
        after the same `skip`.
    executor
        Where values are computed; the cores of this machine if not given.
    watch
        Called after each value with the progress.

    Returns
    -------
    Dataset with the free coordinates and their rates (start, value, crossing, …), `time`, and with
    `exponent` and its `error` (start, value) if asked for; `reason` (start, value) says why a value
    could not be computed, which leaves nan. The attribute ``interrupted`` is 1 after Ctrl-C.

    Raises
    ------
    InputError
        If a path names nothing or nothing is free.
    ValueError
        For arguments that make no sense.
    """
    values = vary if isinstance(vary, Axis) else axis(vary)
    if start not in STARTS:
        raise ValueError(f"start must be one of {', '.join(STARTS)}, found {start!r}")
    taken = {"periods": periods, "skip": skip, "phase": phase, "section": section,
             "direction": direction, "method": method, "rtol": rtol}  # fmt: skip
    request = _Request(mechanism, values, taken, exponent)
    system = request.checked(initial)
    if start == "same":
        found, interrupted = _independent(request, initial, executor, watch)
    else:
        found, interrupted = _continued(request, initial, start, executor, watch)
    return _labelled(system, request, found, len(initial), periods, interrupted)


Found = list[tuple[dict[str, Floats] | None, str]]
"""Per start and value: results and reason."""


def _independent(
    request: _Request,
    initial: Sequence[Mapping[str, object]],
    executor: Executor | None,
    watch: Callable[[Progress], None] | None,
) -> tuple[Found, bool]:
    """Every value from the state of the file."""
    points: list[Point] = [(i, over) for over in initial for i in range(len(request.axis))]
    swept = sweep(request.compute, points, executor=executor, watch=watch)
    results = [None if o is None else o.value for o in swept.outcomes]
    return list(zip(results, swept.reasons, strict=True)), swept.interrupted


def _continued(
    request: _Request,
    initial: Sequence[Mapping[str, object]],
    start: str,
    executor: Executor | None,
    watch: Callable[[Progress], None] | None,
) -> tuple[Found, bool]:
    """Every value from the last state of its neighbour, all initial states side by side."""
    count = len(request.axis)
    order = range(count) if start == "forward" else range(count - 1, -1, -1)
    ends: list[End | None] = [None for _ in initial]
    found: Found = [(None, INTERRUPTED)] * (len(initial) * count)
    begun = time.monotonic()
    for done, index in enumerate(order):
        swept = sweep(
            request.follow,
            [(index, *start) for start in zip(initial, ends, strict=True)],
            executor=executor,
            watch=_onwards(watch, done * len(initial), count * len(initial), begun),
            alone=not done,  # later values find everything compiled
        )
        for row, outcome in enumerate(swept.outcomes):
            if outcome is not None:
                points, end = (None, None) if outcome.value is None else outcome.value
                found[row * count + index] = (points, outcome.reason or "")
                ends[row] = ends[row] if end is None else end
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


def _labelled(
    system: System,
    request: _Request,
    found: Found,
    starts: int,
    points: int,
    interrupted: bool,
) -> xr.Dataset:
    """Arrays padded with nan where fewer points were found."""
    import xarray as xr

    shape = (starts, len(request.axis))
    names = free_names(system)
    variables: dict[str, Any] = {}
    for dim, elements in names.items():
        for output in PAIRS[dim]:
            array = np.full((starts * shape[1], points, len(elements)), np.nan)
            for row, (result, _) in enumerate(found):
                if result is not None:
                    array[row, : len(result[output])] = result[output]
            entry = VARIABLES[output]
            attrs = {"units": entry.units, "long_name": entry.long_name}
            dims = ("start", "value", "crossing", dim)
            variables[output] = (dims, array.reshape(*shape, points, -1), attrs)
    if request.exponent:
        for name, words in (("exponent", "largest Lyapunov exponent"), ("error", "its error")):
            rows = [np.nan if r is None else float(r[name]) for r, _ in found]
            attrs = {"units": "1/s", "long_name": words}
            variables[name] = (("start", "value"), np.reshape(rows, shape), attrs)
    reasons = np.array([reason for _, reason in found], dtype=object).reshape(shape)
    variables["reason"] = (("start", "value"), reasons)
    coordinates: dict[str, Any] = {
        path: ("value", numbers, {"units": unit})
        for path, numbers, unit in zip(
            request.axis.paths,
            request.axis.values,
            units(request.mechanism, request.axis),
            strict=True,
        )
    }
    coordinates |= {dim: np.array(elements, dtype=object) for dim, elements in names.items()}
    attributes: dict[str, Any] = {
        "name": request.mechanism.name,
        "source": request.mechanism.source,
        "varied": request.axis.label,
        "interrupted": int(interrupted),
    }
    return xr.Dataset(variables, coordinates, attributes)
