"""What a search has found: a definition, and how it was found as labelled arrays."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.design.optimising.goals import reduced_series
from linkages.design.optimising.local import OPTIMAL
from linkages.design.optimising.motions import Motions
from linkages.design.optimising.problem import Problem
from linkages.design.optimising.record import HOLDS, Record, Tried
from linkages.design.varied.ranges import AT_BOUND
from linkages.design.varied.rewritten import kept, rewritten
from linkages.errors import LinkagesError
from linkages.kernel.system import System
from linkages.solution.measuring.measure import measure_unit, measured_series

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

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
        the order of the runs; the series that goal and constraints reduce, `curve` (state, series,
        time). All in SI. Attributes are `runs`, `notes` and `optimality`, the first-order
        optimality of Karush, Kuhn and Tucker: by what part of its value the goal would change over
        the bounds of a number at its slope; nan where the search ended before.
    """

    mechanism: Mechanism
    text: str
    data: xr.Dataset


def optimum_of(problem: Problem, record: Record, about: dict[str, Any]) -> Optimum:
    """The best of a record, which can be computed."""
    best = record.best
    assert best is not None
    numbers = problem.ranges.numbers(best.places)
    values = {
        each.path: each.written(float(number))
        for each, number in zip(problem.ranges.each, numbers, strict=True)
    }
    mechanism, text = rewritten(problem.mechanism, values, _remarks(problem, best))
    data = _dataset(problem, record, best, about)
    data.attrs["notes"] += kept(mechanism)
    return Optimum(mechanism=mechanism, text=text, data=data)


def _remarks(problem: Problem, best: Tried) -> list[str]:
    """What was optimised, and what came of it."""
    unit = units(problem)[problem.goal.measure.text]
    found = [f"linkages optimise: {problem.goal.text}: {best.value:.8g} {unit}".rstrip()]
    found += [f"  subject to {each.text}" for each in problem.constraints]
    numbers = problem.ranges.numbers(best.places)
    found += [
        f"  {each.path}: {each.shown(number)}, between {each.shown(each.lower)} and "
        f"{each.shown(each.upper)}"
        for each, number in zip(problem.ranges.each, numbers, strict=True)
    ]
    return found


def units(problem: Problem) -> dict[str, str]:
    """Unit of each measure, in SI."""
    system = System(problem.mechanism)
    found = {}
    for each in (problem.goal.measure, *(c.measured for c in problem.constraints)):
        found[each.text] = measure_unit(system, each, measured_series(system, each))
    return found


def _dataset(problem: Problem, record: Record, best: Tried, about: dict[str, Any]) -> xr.Dataset:
    import xarray as xr

    ranges, known = problem.ranges, units(problem)
    first = _start(problem, record)
    both = (first, best)
    numbers = np.array([problem.start, ranges.numbers(best.places)])
    rest = np.array([one.excesses for one in both])
    sizes = np.ones(rest.shape[1]) if record.sizes is None else record.sizes
    variables: dict[str, Any] = {
        "number": (("state", "path"), numbers),
        "lower": ("path", ranges.lower),
        "upper": ("path", ranges.upper),
        "bound": ("path", _bounds(best)),
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
    found = (one for one in record.tried if np.array_equal(one.places, places))
    return next(found, problem.failed(places, 1.0, "not computed"))


def _bounds(best: Tried) -> list[str]:
    low, high = best.places <= AT_BOUND, best.places >= 1.0 - AT_BOUND
    return ["lower" if a else "upper" if b else "" for a, b in zip(low, high, strict=True)]


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
    motions = Motions(problem, Record(problem.goal, problem.constraints), (), texts)
    time = np.linspace(0.0, problem.run.end, problem.run.samples)
    curves = np.full((2, len(texts), len(time)), np.nan)
    for row, one in enumerate(both):
        try:
            times, found = motions.curves(one.places)
        except LinkagesError:
            continue
        curves[row] = [np.interp(time, times, found[text]) for text in texts]
    return {
        "curve": (("state", "series", "time"), curves),
        "series": ("series", texts),
        "series_units": ("series", [motions.units[text] for text in texts]),
        "time": ("time", time, {"units": "s"}),
    }
