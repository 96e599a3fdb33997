"""Find the numbers of a definition that make a measure least or greatest."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any, Unpack

import numpy as np

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.design.optimising.evolution import Generations, evolved
from linkages.design.optimising.goals import constraint_of, goal_of
from linkages.design.optimising.local import Local
from linkages.design.optimising.optimum import Optimum, optimum_of, units
from linkages.design.optimising.problem import Problem
from linkages.design.optimising.record import EnoughError, Record
from linkages.design.varied.ranges import Vary, ranges_of, require_starts
from linkages.errors import ComputationError, Interrupted
from linkages.options.run import SimulationKeywords, SimulationOptions
from linkages.options.signature import takes
from linkages.reading.wording import suggestion
from linkages.solution.options import options_of
from linkages.sweeps.distributions import probabilities
from linkages.sweeps.running import Threads

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
    problem = Problem(
        mechanism, ranges_of(mechanism, vary), goal_of(minimise, maximise),
        tuple(constraint_of(text) for text in texts), given,
    )  # fmt: skip
    units(problem)  # what is wrong with measures shows here
    record = Record(problem.goal, problem.constraints, watch, runs)
    about: dict[str, Any] = {"search": search, "starts": starts, "seed": seed, "interrupted": 0}
    try:
        if search == "global":
            _everywhere(problem, record, seed, Threads(cores))
        else:
            _nearby(problem, record, starts, seed)
    except EnoughError:
        pass
    except KeyboardInterrupt:
        raise _interrupted(problem, record, about) from None
    _require_feasible(problem, record)
    return optimum_of(problem, record, about)


def _everywhere(problem: Problem, record: Record, seed: int, executor: Threads) -> None:
    evolved(Generations(problem, record, executor), problem, record, seed)
    best = record.best
    if best is not None and not best.missing:
        Local(problem, record).from_(best.places)


def _nearby(problem: Problem, record: Record, starts: int, seed: int) -> None:
    first = problem.ranges.places(problem.start)
    others = np.zeros((0, len(first)))
    if starts > 1:
        others = np.array(probabilities(problem.ranges.paths, starts - 1, seed, "sobol")).T
    for places in (first, *others):
        Local(problem, record).from_(places)


def _interrupted(problem: Problem, record: Record, about: dict[str, Any]) -> Interrupted:
    message = f"interrupted after {len(record.tried)} runs"
    if record.best is None or not record.holds(record.best):
        return Interrupted(message)
    found = optimum_of(problem, record, about | {"interrupted": 1})
    kept = {"optimise": found.data, "optimised.yaml": found.text}
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
