"""The best within all bounds by differential evolution, whole generations side by side."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from linkages.design.optimising.problem import Problem
from linkages.design.optimising.record import Record, Tried
from linkages.errors import InputError
from linkages.kernel.varying import Varying
from linkages.spec.measures import read_measure
from linkages.sweeps.answers import Code
from linkages.sweeps.axes import Axis
from linkages.sweeps.engine import computed
from linkages.sweeps.measured import MeasureQuestion
from linkages.sweeps.points import Points
from linkages.sweeps.running import Executor

Floats = NDArray[np.float64]

PER_NUMBER = 12
"""Members of a generation for each number that is varied."""

FEWEST = 24

GENERATIONS = 300

_ALIKE = 1e-6
"""Spread of a generation, as a part of its mean, below which the search ends."""


class Generations:
    """Places in the box of bounds, many at once, through the engine of sweeps.

    Parameters
    ----------
    problem, record
        What is sought, and where motions are recorded.
    executor
        Where they are computed.
    """

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
        found = computed(question, executor=self._executor)
        tried = []
        for index, row in enumerate(rows):
            code = int(found.arrays["outcome"][index])
            if code == Code.MISSING:
                continue
            if code == Code.COMPUTED:
                values = np.array([found.arrays[text][index] for text in problem.texts])
                tried.append(problem.tried(row.copy(), values))
                continue
            missing = (
                problem.unassembled(row)
                if code == Code.NOT_ASSEMBLED
                else problem.missing(code, float(found.arrays["stop_time"][index]))
            )
            tried.append(problem.failed(row.copy(), missing, str(found.arrays["reason"][index])))
        if found.interrupted:
            for one in tried:
                self._record.add(one)
            raise KeyboardInterrupt
        return tried


def evolved(generations: Generations, problem: Problem, record: Record, seed: int) -> None:
    """Search everywhere within the bounds; what is found is in the record.

    What cannot be computed is worse than all that can, and the better the later it stops, or the
    less it is from assembly; what
    violates constraints is worse than what satisfies them (J. Lampinen, "A constraint handling
    approach for the differential evolution algorithm", CEC 2002).
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
    found = np.array(columns).T
    return found if places.ndim > 1 else found[:, 0]


def _values(generations: Generations, problem: Problem, places: Floats) -> Floats:
    """The goal, of which less is better, shape (count,); only asked where all constraints hold."""
    found = generations.at(np.atleast_2d(places.T))
    values = np.array([problem.goal.sign * one.value for one in found])
    return values if places.ndim > 1 else values[0]
