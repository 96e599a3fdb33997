"""Optimise the numbers of a definition, locally or by differential evolution."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple, Unpack

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.design.atlas import Atlas, passed_by
from linkages.design.goals import (
    HOLDS,
    EnoughError,
    Goal,
    Record,
    Tried,
    constraint_of,
    goal_of,
    reduced_series,
)
from linkages.design.local_search import OPTIMAL, Local, Motions, Problem
from linkages.design.ranges import AT_BOUND, Vary, kept, ranges_of, require_starts, rewritten
from linkages.design.variants import Variant, variants_of
from linkages.errors import ComputationError, InputError, Interrupted, LinkagesError
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.options.option import takes
from linkages.options.run import SimulationKeywords, SimulationOptions
from linkages.reading.wording import suggestion
from linkages.solution.measure_names import measure_units
from linkages.solution.run_options import options_of
from linkages.spec.measures import read_measure
from linkages.sweeps.axes import Axis
from linkages.sweeps.engine import Code, computed
from linkages.sweeps.point_measures import MeasureQuestion
from linkages.sweeps.points import Points
from linkages.sweeps.running import Executor, Threads

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

PER_NUMBER = 12
"""Members of a generation for each number that is varied."""

FEWEST = 24

GENERATIONS = 300

_ALIKE = 1e-6
"""Spread of a generation, as a part of its mean, below which the search ends."""


class Generations:
    """Evaluates many places in the box of bounds at once, by the engine of sweeps."""

    def __init__(self, problem: Problem, record: Record, executor: Executor) -> None:
        self._problem, self._record, self._executor = problem, record, executor
        self._varying = Varying(problem.mechanism.keeping(problem.ranges.paths))
        self._measures = {text: read_measure(text) for text in problem.texts}
        self._known: dict[bytes, Tried] = {}

    def at(self, places: Floats) -> list[Tried]:
        """What came of each row of places, shape (count, paths)."""
        rows = np.ascontiguousarray(places)
        new = list(
            {row.tobytes(): row for row in rows if row.tobytes() not in self._known}.values()
        )
        if new:
            for one in self._computed(np.array(new)):
                self._known[one.places.tobytes()] = one
                self._record.add(one)
        return [self._known[row.tobytes()] for row in rows]

    def _computed(self, rows: Floats) -> list[Tried]:
        problem = self._problem
        along = Axis(tuple(problem.ranges.paths), problem.ranges.numbers(rows).T)
        points = Points((along,), {}, 1, 0, "random")
        question = MeasureQuestion(self._varying, points, self._measures, problem.given)
        try:
            _ = question.first  # what all are built upon must not depend on who is first
        except InputError as error:
            return [problem.refused(row.copy(), error) for row in rows]
        result = computed(question, executor=self._executor)
        tried = []
        for index, row in enumerate(rows):
            code = int(result.arrays["outcome"][index])
            if code == Code.MISSING:
                continue
            if code == Code.COMPUTED:
                values = np.array([result.arrays[text][index] for text in problem.texts])
                tried.append(problem.tried(row.copy(), values))
                continue
            missing = (
                problem.unassembled(row)
                if code == Code.NOT_ASSEMBLED
                else problem.missing(code, float(result.arrays["stop_time"][index]))
            )
            tried.append(problem.failed(row.copy(), missing, str(result.arrays["reason"][index])))
        if result.interrupted:
            for one in tried:
                self._record.add(one)
            raise KeyboardInterrupt
        return tried


def evolved(generations: Generations, problem: Problem, record: Record, seed: int) -> None:
    """Search everywhere within the bounds; results are in the record.

    What cannot be computed is worse than all that can, the less the later it stops or the closer it
    is to assembly; violated constraints are worse than satisfied ones (J. Lampinen, "A constraint
    handling approach for the differential evolution algorithm", CEC 2002).
    """
    from scipy.optimize import NonlinearConstraint, differential_evolution

    width = len(problem.ranges)
    limits = NonlinearConstraint(partial(_violations, generations, record), -np.inf, 0.0)
    differential_evolution(
        partial(_values, generations, problem),
        bounds=[(0.0, 1.0)] * width,
        constraints=limits,
        x0=problem.ranges.places(problem.start),
        popsize=max(PER_NUMBER, -(-FEWEST // width)),
        maxiter=GENERATIONS,
        tol=_ALIKE,
        polish=False,
        updating="deferred",
        vectorized=True,
        seed=seed,
    )


def _violations(generations: Generations, record: Record, places: Floats) -> Floats:
    """How much is missing, then how much each constraint is violated, shape (1 + c, count)."""
    columns = []
    for one in generations.at(np.atleast_2d(places.T)):
        own = np.full(len(record.constraints), np.inf) if one.missing else record.violations(one)
        columns.append([one.missing, *own])
    result = np.array(columns).T
    return result if places.ndim > 1 else result[:, 0]


def _values(generations: Generations, problem: Problem, places: Floats) -> Floats:
    """The goal, of which less is better, shape (count,); only asked where all constraints hold."""
    result = generations.at(np.atleast_2d(places.T))
    values = np.array([problem.goal.sign * one.value for one in result])
    return values if places.ndim > 1 else values[0]


STATES = ("start", "optimum")

ACTIVE = 1e-6
"""Part of its size within which a constraint is met with nothing to spare."""


@dataclass(frozen=True, kw_only=True)
class Optimum:
    """What `linkages.optimise` returns.

    Parameters
    ----------
    mechanism
        With the numbers that were found.
    text
        Its definition, on top of which stands what was optimised.
    data
        Dataset: `number` (state, path) with `lower`, `upper` and the `bound` (path) at which the
        optimum is; `value` (state) of the goal; `constraint_value` (state, constraint) and which of
        them are `active`; `history` and `history_number`, the best value and what was tried, in
        the order of the runs of the best variant; `variant_value` (variant), the best of each
        assembly branch and sense of the drives that was searched; the series that goal and
        constraints reduce, `curve` (state, series, time). All in SI. Attributes are `runs`,
        `variant`, `notes` and `optimality`, the first-order optimality of Karush, Kuhn and Tucker:
        by what part of its value the goal would change over the bounds of a number at its slope;
        nan where the search ended before.
    """

    mechanism: Mechanism
    text: str
    data: xr.Dataset


class Searched(NamedTuple):
    """A variant with what was asked of it, and what came of that."""

    variant: Variant
    problem: Problem
    record: Record


def optimum_of(mechanism: Mechanism, tried: Sequence[Searched], about: dict[str, Any]) -> Optimum:
    """The best of all variants, which can be computed."""
    variant, problem, record = _best(tried)
    best = record.best
    assert best is not None
    numbers = problem.ranges.numbers(best.places)
    values = {
        each.path: each.written(float(number))
        for each, number in zip(problem.ranges.each, numbers, strict=True)
    }
    changed, text = rewritten(mechanism, variant.values | values, _remarks(problem, best, variant))
    data = _dataset(problem, record, best, about)
    bests = [one.record.best for one in tried]
    data["variant_value"] = (
        "variant",
        [
            own.value if own is not None and one.record.holds(own) else math.nan
            for one, own in zip(tried, bests, strict=True)
        ],
    )
    data = data.assign_coords(variant=[one.variant.name for one in tried])
    data.attrs |= {
        "variant": variant.name,
        "runs": _runs(tried),
        "runs_missing": sum(bool(each.missing) for one in tried for each in one.record.tried),
    }
    if len(tried) == 1:
        data.attrs["notes"] += kept(changed)
    return Optimum(mechanism=changed, text=text, data=data)


def _remarks(problem: Problem, best: Tried, variant: Variant) -> list[str]:
    """What was optimised, and what came of it."""
    unit = units(problem)[problem.goal.measure.text]
    result = [f"linkages optimise: {problem.goal.text}: {best.value:.8g} {unit}".rstrip()]
    result += [f"  {variant.name}"] if variant.name else []
    result += [f"  subject to {each.text}" for each in problem.constraints]
    numbers = problem.ranges.numbers(best.places)
    result += [
        f"  {each.path}: {each.shown(number)}, between {each.shown(each.lower)} and "
        f"{each.shown(each.upper)}"
        for each, number in zip(problem.ranges.each, numbers, strict=True)
    ]
    return result


def units(problem: Problem) -> dict[str, str]:
    """Unit of each measure, in SI."""
    measures = (problem.goal.measure, *(each.measured for each in problem.constraints))
    return measure_units(System(problem.mechanism), {each.text: each for each in measures})


def _dataset(problem: Problem, record: Record, best: Tried, about: dict[str, Any]) -> xr.Dataset:
    import xarray as xr

    ranges, known = problem.ranges, units(problem)
    first = _start(problem, record)
    both = (first, best)
    numbers = np.array([problem.start, ranges.numbers(best.places)])
    rest = np.array([one.excesses for one in both])
    sizes = np.ones(rest.shape[1]) if record.sizes is None else record.sizes
    low, high = best.places <= AT_BOUND, best.places >= 1.0 - AT_BOUND
    variables: dict[str, Any] = {
        "number": (("state", "path"), numbers),
        "lower": ("path", ranges.lower),
        "upper": ("path", ranges.upper),
        "bound": ("path", np.where(low, "lower", np.where(high, "upper", "")).tolist()),
        "value": ("state", [one.value for one in both], {"units": known[problem.texts[0]]}),
        "constraint_value": (("state", "constraint"), np.array([one.measured for one in both])),
        "excess": (("state", "constraint"), rest),
        "constraint_units": ("constraint", [known[c.measured.text] for c in problem.constraints]),
        "active": ("constraint", np.abs(rest[1]) <= ACTIVE * sizes),
        **_history(problem, record, known[problem.texts[0]]),
        **_curves(problem, both),
    }
    coordinates = {
        "state": list(STATES),
        "path": ranges.paths,
        "path_unit": ("path", [each.label for each in ranges.each]),
        "constraint": [each.text for each in problem.constraints],
    }
    missing = [one for one in record.tried if one.missing]
    attrs = {
        "name": problem.mechanism.name,
        "goal": problem.goal.text,
        "runs": len(record.tried),
        "runs_missing": len(missing),
        "holds": int(record.holds(best)),
        "plateau": int(record.plateau),
        # peaks of what is level are round-off, and say nothing of a slope
        "optimality": math.nan if record.plateau else record.optimality,
        "notes": _notes(record),
        **about,
    }
    return xr.Dataset(variables, coordinates, attrs)


def _notes(record: Record) -> list[str]:
    """Why the best may be no optimum."""
    if record.plateau:
        return ["the search ended on a plateau: many runs in a row gained no more than round-off"]
    if math.isnan(record.optimality):
        return ["the search ended before an optimum: allow more runs, or start from what was found"]
    if record.optimality > OPTIMAL:
        return [
            f"first-order optimality {record.optimality:.1e} is above {OPTIMAL:g}: this may be no "
            "optimum; start from what was found, from several points (starts), or search globally"
        ]
    return []


def _start(problem: Problem, record: Record) -> Tried:
    """What came of the numbers of the definition, or the nearest within the bounds."""
    places = problem.ranges.places(problem.start)
    result = (one for one in record.tried if np.array_equal(one.places, places))
    return next(result, problem.failed(places, 1.0, "not computed"))


def _history(problem: Problem, record: Record, unit: str) -> dict[str, Any]:
    """The best that satisfies the constraints so far, and what was tried, run by run."""
    so_far, values = np.nan, []
    for one in record.tried:
        if record.holds(one) and not problem.goal.sign * one.value >= problem.goal.sign * so_far:
            so_far = one.value
        values.append(so_far)
    numbers = problem.ranges.numbers(np.array([one.places for one in record.tried]))
    violations = [record.violation(one) for one in record.tried]
    return {
        "history": ("run", values, {"units": unit, "long_name": problem.goal.measure.text}),
        "history_value": ("run", [one.value for one in record.tried], {"units": unit}),
        "history_number": (("run", "path"), numbers),
        "history_violation": ("run", violations, {"long_name": f"0 where it is below {HOLDS:g}"}),
    }


def _curves(problem: Problem, both: tuple[Tried, Tried]) -> dict[str, Any]:
    """What goal and constraints reduce, over time, at the start and at the optimum."""
    measures = [problem.goal.measure, *(each.measured for each in problem.constraints)]
    texts = list(dict.fromkeys(text for each in measures for text in reduced_series(each)))
    finals = {f"final({text})": text for text in texts}
    motions = Motions(problem, Record(problem.goal, problem.constraints), (), [*finals])
    time = np.linspace(0.0, problem.run.end, problem.run.samples)
    curves = np.full((2, len(texts), len(time)), np.nan)
    for row, one in enumerate(both if texts else ()):
        try:
            times, result = motions.curves(one.places)
        except LinkagesError:
            continue
        curves[row] = [np.interp(time, times, result[text]) for text in finals]
    return {
        "curve": (("state", "series", "time"), curves),
        "series": ("series", texts),
        "series_units": ("series", [motions.units[text] for text in finals]),
        "time": ("time", time, {"units": "s"}),
    }


SEARCHES = ("local", "global")


@takes(SimulationOptions)
def optimise(
    mechanism: Mechanism,
    vary: Vary,
    *,
    minimise: str | None = None,
    maximise: str | None = None,
    subject_to: str | Sequence[str] = (),
    search: str = "local",
    branches: str = "file",
    starts: int = 1,
    seed: int = 0,
    runs: int | None = None,
    cores: int | None = None,
    watch: Callable[[int, float], None] | None = None,
    **options: Unpack[SimulationKeywords],
) -> Optimum:
    """Numbers of a definition that make a measure of the motion least or greatest.

    A local search follows exact derivatives (sequential quadratic programming, SLSQP). A maximum
    over time, ``max(abs(crank.effort))``, is smooth where one peak leads; where several are alike,
    as at most optima, all of them are held down together. A global search is differential
    evolution over all that the bounds allow, then a local one from the best. What cannot be
    assembled or stops is worse than all that can be computed, and the worse the earlier it stops.

    Parameters
    ----------
    mechanism
        From a file or made in Python; its numbers are the start, moved to the nearest bound.
    vary
        Dotted path of the definition → lowest and highest value: numbers in SI or texts with
        units; or texts such as ``"bars.rod.length=120mm:160mm"``.
    minimise, maximise
        A measure, as `linkages.measure` reads it; one of them.
    subject_to
        What must hold: one or several comparisons of measures, such as
        ``"min(transmission_angle) > 40 deg"``; ``=`` is one, too.
    search
        ``"local"`` or ``"global"``.
    branches
        ``"file"``: the assembly branch and the sense of the drives of the definition. ``"all"``:
        each assembly branch, and both senses of drives at constant speed; the best counts.
    starts
        Local searches: the first from the definition, others from points that fill the bounds.
    seed
        Of these points, and of evolution.
    runs
        Motions after which the search ends with the best so far; None for as many as it takes.
    cores
        Of a global search; those that this process may use if not given. Results do not depend on
        it.
    watch
        Called after each motion with how many there were, and the best value so far.
    options
        As `SimulationOptions` describes them.

    Raises
    ------
    InputError, ValueError, TypeError
        For what makes no sense.
    ComputationError
        If nothing that was tried can be computed and satisfies the constraints.
    Interrupted
        After Ctrl-C; ``kept["optimise"]`` has the best so far.
    """
    if search not in SEARCHES:
        near = suggestion(search, SEARCHES) or f"; expected {' or '.join(map(repr, SEARCHES))}"
        raise ValueError(f"unknown search {search!r}{near}")
    require_starts(starts)
    if runs is not None and runs < 1:
        raise ValueError("runs must be at least 1")
    texts = [subject_to] if isinstance(subject_to, str) else [*subject_to]
    given = {name: value for name, value in options.items() if value is not None}
    options_of(SimulationOptions, mechanism, given)
    ranges = ranges_of(mechanism, vary)
    goal, limits = goal_of(minimise, maximise), tuple(constraint_of(text) for text in texts)
    about: dict[str, Any] = {"search": search, "starts": starts, "seed": seed, "interrupted": 0}
    tried: list[Searched] = []
    try:
        for variant in variants_of(mechanism, branches, ranges.paths):
            own = mechanism.with_values(variant.values) if variant.values else mechanism
            problem = Problem(own, ranges, goal, limits, given)
            units(problem)  # what is wrong with measures shows here
            left = None if runs is None else runs - _runs(tried)
            record = Record(goal, limits, _counting(watch, goal, tried), left)
            tried.append(Searched(variant, problem, record))
            if search == "global":
                evolved(Generations(problem, record, Threads(cores)), problem, record, seed)
                best = record.best
                if best is not None and not best.missing:
                    Local(problem, record).from_(best.places)
            else:
                aims = [] if limits else passed_by(own, goal)
                atlas = Atlas(own, ranges, problem.run, aims, (goal, limits))
                local = Local(problem, record)
                for places in atlas.starts(problem.start, starts, seed):
                    local.from_(places)
    except EnoughError:
        pass
    except KeyboardInterrupt:
        raise _interrupted(mechanism, tried, about) from None
    best_of = _best(tried)
    _require_feasible(best_of.problem, best_of.record)
    return optimum_of(mechanism, tried, about)


def _runs(tried: Sequence[Searched]) -> int:
    return sum(len(one.record.tried) for one in tried)


def _best(tried: Sequence[Searched]) -> Searched:
    """The variant with the best that satisfies the constraints; the first of equal ones."""

    def order(one: Searched) -> tuple[float, ...]:
        best = one.record.best
        return (math.inf,) if best is None else one.record.order(best)

    return min(tried, key=order)


def _counting(
    watch: Callable[[int, float], None] | None, goal: Goal, tried: Sequence[Searched]
) -> Callable[[int, float], None] | None:
    """The same over all variants: runs of those before count, and so does their best."""
    if watch is None or not tried:
        return watch
    before = _runs(tried)
    values = [one.record.best.value for one in tried if one.record.best is not None]

    def counted(runs: int, value: float) -> None:
        watch(
            before + runs, goal.sign * float(np.fmin.reduce(goal.sign * np.array([*values, value])))
        )

    return counted


def _interrupted(
    mechanism: Mechanism, tried: Sequence[Searched], about: dict[str, Any]
) -> Interrupted:
    message = f"interrupted after {_runs(tried)} runs"
    best = _best(tried).record if tried else None
    if best is None or best.best is None or not best.holds(best.best):
        return Interrupted(message)
    result = optimum_of(mechanism, tried, about | {"interrupted": 1})
    kept = {"optimise": result.data, "optimised.yaml": result.text}
    return Interrupted(message, kept=kept)


def _require_feasible(problem: Problem, record: Record) -> None:
    """Something that can be computed and satisfies the constraints was found."""
    best, count = record.best, len(record.tried)
    if best is not None and record.holds(best):
        return
    if best is None or best.missing:
        counted = Counter(one.reason for one in record.tried).most_common(3)
        reasons = "; ".join(f"{reason} ({times} of {count})" for reason, times in counted)
        raise ComputationError(
            f"no feasible start: no motion that was tried can be computed: {reasons}; expected "
            "other numbers or bounds, several starts, or a global search", time=None,
        )  # fmt: skip
    failing = [
        f"'{each.text}', where {each.measured.text} comes to {value:.6g} at best"
        for each, value, part in zip(
            problem.constraints, best.measured, record.violations(best), strict=True
        )
        if part > 0.0
    ]
    raise ComputationError(
        f"nothing that was tried satisfies {' and '.join(failing)} (in SI, {count} runs); expected "
        "a weaker constraint, other bounds, several starts or a global search", time=None,
    )  # fmt: skip
