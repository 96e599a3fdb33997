"""Where series have their maxima at some places, and how they go."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from linkages.design.optimising.problem import Problem
from linkages.kernel.system import System
from linkages.solution.measuring.followed import Followed, resolved_motion
from linkages.solution.measuring.measure import measure_unit, measured_series, needed_outputs
from linkages.solution.measuring.reduced import series_values
from linkages.solution.measuring.summits import Summits, summits
from linkages.solution.simulate import simulate
from linkages.spec.formulas import Call, Node
from linkages.spec.measures import Measure, read_measure

Floats = NDArray[np.float64]


class Located:
    """Series of a motion at places in the box of bounds.

    Parameters
    ----------
    problem
        Whose motions they are.
    peaks
        Text of a series, and 1 for its maxima or −1 for those of its negative.
    """

    def __init__(self, problem: Problem, peaks: Sequence[tuple[str, float]]) -> None:
        self._problem, self._peaks = problem, peaks
        self._mechanism = problem.mechanism.keeping(problem.ranges.paths)
        self._measures = {text: read_measure(f"final({text})") for text, _ in peaks}
        self._needed: list[str] | None = None

    def at(self, places: Floats) -> Mapping[tuple[str, float], Summits]:
        """Local maxima of each; raises what `linkages.simulate` raises."""
        source = self._source(places)
        return {
            (text, sign): summits(self._measures[text], _series(self._measures[text]), source, sign)
            for text, sign in self._peaks
        }

    def curves(self, places: Floats) -> tuple[Floats, dict[str, Floats]]:
        """Times, and the series over them."""
        source = self._source(places)
        found = {
            text: series_values(measure, _series(measure), source)[0]
            for text, measure in self._measures.items()
        }
        return source.time, found

    def units(self) -> dict[str, str]:
        """Unit of each series, in SI."""
        system = System(self._mechanism)
        return {
            text: measure_unit(system, each, measured_series(system, each))
            for text, each in self._measures.items()
        }

    def _source(self, places: Floats) -> Followed:
        problem = self._problem
        numbers = problem.ranges.numbers(places)
        mechanism = self._mechanism.with_values(problem.ranges.overrides(numbers))
        if self._needed is None:
            self._needed = needed_outputs(System(mechanism), self._measures.values())
        solution = simulate(mechanism, outputs=self._needed, **problem.given)
        motion = resolved_motion(solution.system, solution.motion, solution.settings)
        series = {
            name: each
            for measure in self._measures.values()
            for name, each in measured_series(solution.system, measure).items()
        }
        return Followed(solution.system, motion, series, solution.data)


def _series(measure: Measure) -> Node:
    """What changes with time in it."""
    assert isinstance(measure.tree, Call)
    return measure.tree.arguments[-1]
