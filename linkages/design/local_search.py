"""Local optimisation with exact derivatives.

The largest value of a series is replaced by a number s, and by the conditions that the peaks are at
most s. Peaks move with the numbers: the motion is cut into windows between the first peaks, and the
largest value within each is one condition. Each is smooth as long as one peak leads within its
window (the reduction of semi-infinite problems; R. Hettich and K. O. Kortanek, SIAM Review 35
(1993) 380–429). Then the motion is cut anew, until nothing is gained.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.design.atlas import passed_by
from linkages.design.differentiated import Differentiated
from linkages.design.goals import Constraint, Goal, Peak, Plain, Record, Sum, Tried, squares_of
from linkages.design.moved import Moved
from linkages.design.ranges import AT_BOUND, Ranges
from linkages.design.reductions import looked_at, peaks, sampled
from linkages.errors import ComputationError, InputError, LinkagesError
from linkages.kernel.batch_assembly import unreached
from linkages.options.run import SimulationOptions
from linkages.solution.extremes import Extremes, local_maxima
from linkages.solution.measure_names import resolved_text
from linkages.solution.run_options import options_of
from linkages.spec.measures import argument
from linkages.sweeps.engine import Code
from linkages.sweeps.running import reason_of

Floats = NDArray[np.float64]

NOT_ASSEMBLED, INVALID = 2.0, 3.0


@dataclass(frozen=True, eq=False)
class Problem:
    """What is varied within which bounds, what is optimised, and how motions are computed."""

    mechanism: Mechanism
    ranges: Ranges
    goal: Goal
    constraints: Sequence[Constraint]
    given: Mapping[str, Any]  # options of the simulation that are given

    @cached_property
    def run(self) -> SimulationOptions:
        """How motions are computed."""
        return options_of(SimulationOptions, self.mechanism, self.given)

    @property
    def texts(self) -> list[str]:
        """Measures that tell how good a point is: of the goal, and two of each constraint."""
        measured = [each.measured.text for each in self.constraints]
        excesses = [each.excess.text for each in self.constraints]
        return [self.goal.measure.text, *measured, *excesses]

    @cached_property
    def start(self) -> Floats:
        """The numbers of the definition in SI."""
        own = Differentiated(self.mechanism, [], self.ranges.paths, run=self.given)
        return np.array(own.values, dtype=float)

    def tried(self, places: Floats, values: Floats) -> Tried:
        """What came of some places where a motion has all values of `texts`."""
        count = len(self.constraints)
        return Tried(places, float(values[0]), values[1 : 1 + count], values[1 + count :])

    def failed(self, places: Floats, missing: float, reason: str) -> Tried:
        """What came of some places where it has not."""
        nothing = np.full(len(self.constraints), np.nan)
        return Tried(places, float("nan"), nothing, nothing, missing, reason)

    def refused(self, places: Floats, error: LinkagesError) -> Tried:
        """What came of some places where something is wrong."""
        match error:
            case ComputationError(time=float(time)):
                return self.failed(places, self.missing(Code.STOPPED, time), reason_of(error))
            case _:
                return self.failed(places, self.unassembled(places), reason_of(error))

    def unassembled(self, places: Floats) -> float:
        """How far from assembly some places are, as `Tried` has it."""
        overrides = self.ranges.overrides(self.ranges.numbers(places))
        try:
            return NOT_ASSEMBLED + unreached(self.mechanism.with_values(overrides))
        except InputError:
            return INVALID

    def missing(self, code: int, time: float) -> float:
        """How much of a motion there is not, as `Tried` has it."""
        match code:
            case Code.COMPUTED:
                return 0.0
            case Code.STOPPED | Code.OVER_BUDGET if time == time:
                return 1.0 - min(time / self.run.end, 1.0 - 1e-9)
            case Code.INVALID:
                return INVALID
            case _:
                return NOT_ASSEMBLED


_KEPT = 8
"""Motions that are remembered: searches ask for values, then for derivatives of the same."""


class Linear(NamedTuple):
    """Values, shape (n,), and their derivatives by places, shape (n, paths)."""

    values: Floats
    slopes: Floats


@dataclass(frozen=True, eq=False)
class Found:
    """A motion: measures with their derivatives, and itself."""

    measures: Linear
    moved: Moved


class Motions:
    """Motions at places in the box of bounds, each recorded.

    `more` are measures beside goal and constraints; of `series` peaks are wanted.
    """

    def __init__(
        self, problem: Problem, record: Record, more: Sequence[str], series: Sequence[str]
    ) -> None:
        self._problem, self._record = problem, record
        texts = list(dict.fromkeys([*problem.texts, *more]))
        self.row = {text: row for row, text in enumerate(texts)}
        paths = problem.ranges.paths
        self._own = Differentiated(problem.mechanism, [*texts, *series], paths, run=problem.given)
        self._whole = {text: resolved_text(self._own.system, text) for text in series}
        self._kept: dict[bytes, Found | None] = {}

    def at(self, places: Floats) -> Found | None:
        """The motion at some places; None if it cannot be computed."""
        key = places.tobytes()
        if key not in self._kept:
            result = self._computed(places)
            if len(self._kept) == _KEPT:
                del self._kept[next(iter(self._kept))]
            self._kept[key] = result
        return self._kept[key]

    def _computed(self, places: Floats) -> Found | None:
        problem, ranges = self._problem, self._problem.ranges
        try:
            moved = self._own.moved(ranges.numbers(places), self._own.series)
            result = self._own.reduced(moved)
        except (ComputationError, InputError) as error:
            self._record.add(problem.refused(places, error))
            return None
        assert result.derivatives is not None
        rows = [self.row[text] for text in problem.texts]
        self._record.add(problem.tried(places, result.values[rows]))
        return Found(Linear(result.values, result.derivatives * ranges.width), moved)

    def peaks(self, found: Found, series: str, sign: float) -> Extremes:
        """Local maxima of what a measure reduces, or of its negative, in its window."""
        grid, own, values = looked_at(self._whole[series], found.moved)
        inner = np.arange(len(grid))
        result = local_maxima(
            sign * own,
            lambda places: sign * values(np.interp(places, inner, grid)),
        )
        return Extremes(result.value, np.interp(result.place, inner, grid))

    def held(self, found: Found, series: str, sign: float, places: Floats) -> Linear:
        """Some of these peaks, at places in samples from the first one."""
        value, slopes = peaks(self._whole[series], found.moved, places, sign)
        assert slopes is not None
        own = self._problem.ranges.width / self._own.scales
        return Linear(sign * value, sign * slopes.T * own)

    def curves(self, places: Floats) -> tuple[Floats, dict[str, Floats]]:
        """Times, and all series over them, without recording; raises what motions raise."""
        numbers = self._problem.ranges.numbers(places)
        moved = self._own.moved(numbers, self._own.series, derivatives=False)
        result = {text: sampled(argument(measure), moved) for text, measure in self._whole.items()}
        return moved.time, result

    @property
    def units(self) -> dict[str, str]:
        """Unit of every measure and series, in SI."""
        return dict(zip([*self.row, *self._whole], self._own.units, strict=True))


MOST_WINDOWS = 32
"""Of a series: its highest peaks have one each."""

MOST_ROUNDS = 5
"""How often the motion is cut into windows."""

GAINED = 1e-9
"""Part of what measures are at the start below which a round has gained nothing."""

STILL = 12
"""Motions without a gain after which a round is on a plateau: all is round-off there."""

OPTIMAL = 1e-4
"""First-order optimality from which on a search is not at an optimum, and goes on."""

_ACTIVE = 1e-6
"""Part of what a condition changes by over the bounds within which it is met with nothing to spare.
"""

_LEAST_SIZE = 1e-6
"""Part of the gain of a search that the goal counts for at least, where its optimum is zero."""

_TOLERANCE = 1e-11
_CLOSE = 1e-13
_ITERATIONS = 50
_STEEP = 1e3


class Local:
    """Searches from several starts."""

    def __init__(self, problem: Problem, record: Record) -> None:
        self.problem, self.record = problem, record
        self.sums = [problem.goal.sum, *(each.sum for each in problem.constraints)]
        parts = [part for each in self.sums for part in each.parts]
        peaks = [(p.measure, p.sign) for p in parts if isinstance(p, Peak)]
        self.peaks = list(dict.fromkeys(peaks))
        plain = [part.measure for part in parts if isinstance(part, Plain)]
        self.squares = [] if problem.constraints else self._squares
        plain += [measure for _, measure in self.squares]
        self.motions = Motions(problem, record, plain, [series for series, _ in self.peaks])
        self._first = np.nan  # the goal where the first search begins

    @property
    def _squares(self) -> list[tuple[float, str]]:
        """Factors and measures whose squares are added; distances of points from a path, too."""
        return squares_of(self.sums[0]) or [
            (
                aim.weight**2,
                f"sqrt(min((({x}) - {at.real!r})**2 + (({y}) - {at.imag!r})**2))",
            )
            for aim in passed_by(self.problem.mechanism, self.problem.goal)
            for x, y in [aim.names]
            for at in aim.points.tolist()
        ]

    def from_(self, places: Floats) -> None:
        """Search from some places; what is found is in the record."""
        result = self.motions.at(places)
        if result is None:
            return
        sizes, optimal = np.abs(result.measures.values), False
        if np.isnan(self._first):
            self._first = float(result.measures.values[self.motions.row[self.problem.texts[0]]])
        if self.squares:
            places, result, optimal = self._settled(self._fitted(places))
        for _ in range(MOST_ROUNDS):
            if optimal and not self.peaks:
                return
            before = result.measures.values
            places = _Round(self, places, result).minimised()
            places, result, optimal = self._settled(places)
            rows = [self.motions.row[text] for text in self.problem.texts]
            change = np.abs(result.measures.values - before)
            if (change <= GAINED * sizes)[rows].all():
                return

    def _settled(self, places: Floats) -> tuple[Floats, Found, bool]:
        """Record where a search has ended; returns that, and whether it is an optimum."""
        result = self.motions.at(places)
        assert result is not None
        optimality = _Round(self, places, result).optimality(self._first)
        self.record.settle(places, optimality)
        return places, result, optimality <= OPTIMAL

    def _fitted(self, places: Floats) -> Floats:
        """Places with the least sum of squares (Gauss, Newton) that the bounds allow."""
        from scipy.optimize import least_squares

        rows = [self.motions.row[measure] for _, measure in self.squares]
        roots = np.sqrt([factor for factor, _ in self.squares])
        known = self.motions.at(places)
        assert known is not None
        # a step to where nothing can be computed is refused as one that gains nothing
        worst = np.full(len(rows), 2.0 * np.linalg.norm(roots * known.measures.values[rows]) + 1.0)

        def values(where: Floats) -> Floats:
            result = self.motions.at(where)
            return worst if result is None else np.asarray(roots * result.measures.values[rows])

        def slopes(where: Floats) -> Floats:
            result = self.motions.at(where)
            assert result is not None
            return np.asarray(roots[:, None] * result.measures.slopes[rows])

        return np.asarray(
            least_squares(
                values, places, jac=slopes, bounds=(0.0, 1.0), method="trf", x_scale="jac",
                ftol=_CLOSE, xtol=_CLOSE, gtol=_CLOSE,
            ).x
        )  # fmt: skip


class _PlateauError(Exception):
    """Nothing has been gained for long."""


class _Round:
    """The smooth problem of one set of windows, in places and bounds on peaks."""

    def __init__(self, search: Local, places: Floats, found: Found) -> None:
        self.search, self.count = search, len(places)
        tops = [search.motions.peaks(found, *peak) for peak in search.peaks]
        self.edges = [_edges(top.place, top.value) for top in tops]
        bounds = np.array([top.value.max() for top in tops])
        self.sizes = np.where(bounds == 0.0, 1.0, np.abs(bounds))
        self.start = np.concatenate([places, bounds / self.sizes])
        self.known: dict[bytes, Linear | None] = {}
        self.last = self.start
        self.worst = 0.0
        self.best, self.still = self._tried(places, found), 0
        self.size = abs(self.best.value) or 1.0
        self.scales = np.ones(1)

    def minimised(self) -> Floats:
        """Places of the optimum."""
        from scipy.optimize import minimize

        first = self._computed(self.start)
        sizes = np.abs(first.slopes).max(axis=1)
        self.scales = np.where(sizes > 0.0, sizes, 1.0)
        box = [(0.0, 1.0)] * self.count + [(None, None)] * len(self.sizes)
        try:
            result = minimize(
                self._value, self.start, jac=self._slope, method="SLSQP", bounds=box,
                constraints=self._conditions(),
                options={"ftol": _TOLERANCE, "maxiter": _ITERATIONS},
            )  # fmt: skip
        except _PlateauError:
            self.search.record.plateau = True
            return self.best.places
        z = result.x if self._all(result.x) is not None else self.last
        return np.clip(z[: self.count], 0.0, 1.0)

    def optimality(self, first: float) -> float:
        """Part by which the goal would change over the bounds of a number at constant slope.

        The slope is the gradient of the Lagrangian (Karush, Kuhn, Tucker), along its largest entry.
        """
        from scipy.optimize import lsq_linear

        result = self.search.motions.at(np.clip(self.start[: self.count], 0.0, 1.0))
        assert result is not None
        now = self._linear(result, self.start[self.count :] * self.sizes)
        equal = self._equal
        steep = np.abs(now.slopes[1:]).max(axis=1)
        met = (equal | (now.values[1:] >= -_ACTIVE * steep)) & (steep > 0.0)
        box, places = np.eye(now.slopes.shape[1])[: self.count], self.start[: self.count]
        normals = [
            now.slopes[1:][met] / steep[met, None],
            -box[places <= AT_BOUND],
            box[places >= 1.0 - AT_BOUND],
        ]
        matrix, left = np.concatenate(normals).T, now.slopes[0]
        if matrix.shape[1]:
            lowest = np.zeros(matrix.shape[1])
            lowest[: met.sum()][equal[met]] = -np.inf
            left = left + matrix @ lsq_linear(matrix, -left, bounds=(lowest, np.inf)).x
        value = self._tried(places, result).value
        size = max(abs(value), _LEAST_SIZE * abs(first - value)) or 1.0
        return float(np.abs(left).max()) / size

    @property
    def _equal(self) -> NDArray[np.bool_]:
        """Which conditions must be zero."""
        own = [each.equal for each in self.search.problem.constraints]
        return np.array([*own, *(False for edges in self.edges for _ in edges[1:])], dtype=bool)

    def _conditions(self) -> list[dict[str, Any]]:
        """Constraints as SLSQP takes them: not below zero, or zero."""
        equal, scales = self._equal, self.scales[1:]
        return [
            {
                "type": kind,
                "fun": lambda z, rows=rows: -(self._computed(z).values[1:] / scales)[rows],
                "jac": lambda z, rows=rows: -(self._computed(z).slopes[1:] / scales[:, None])[rows],
            }
            for kind, rows in (("ineq", ~equal), ("eq", equal))
            if rows.any()
        ]

    def _value(self, z: Floats) -> float:
        result = self._all(z)
        if result is None:
            # worse than all that can be computed, so that steps become shorter
            return self.worst + _STEEP
        value = float(result.values[0]) / self.scales[0]
        self.worst = max(self.worst, value)
        return value

    def _slope(self, z: Floats) -> Floats:
        return self._computed(z).slopes[0] / self.scales[0]

    def _computed(self, z: Floats) -> Linear:
        """All values, or those of the last place that has some."""
        result = self._all(z) or self._all(self.last)
        assert result is not None
        return result

    def _all(self, z: Floats) -> Linear | None:
        """Goal, constraints and what is held down, none of which shall be above zero."""
        result = self.search.motions.at(np.clip(z[: self.count], 0.0, 1.0))
        if result is None:
            return None
        if z.tobytes() not in self.known:
            self._note(self._tried(np.clip(z[: self.count], 0.0, 1.0), result))
            self.known = {z.tobytes(): self._linear(result, z[self.count :] * self.sizes)}
        self.last = np.array(z)
        return self.known[z.tobytes()]

    def _tried(self, places: Floats, found: Found) -> Tried:
        rows = [self.search.motions.row[text] for text in self.search.problem.texts]
        return self.search.problem.tried(places, found.measures.values[rows])

    def _note(self, one: Tried) -> None:
        """Raise if it is the last of many that have gained nothing."""
        record = self.search.record
        before, now = record.order(self.best), record.order(one)
        gained = before[1] - now[1] > GAINED or (
            now[1] <= before[1] and before[2] - now[2] > GAINED * self.size
        )
        self.still = 0 if gained else self.still + 1
        if now < before:
            self.best = one
        if self.still > STILL:
            raise _PlateauError

    def _linear(self, found: Found, bounds: Floats) -> Linear:
        rows = [self._sum(each, found.measures, bounds) for each in self.search.sums]
        values = [np.array([value for value, _ in rows])]
        slopes = [np.array([slope for _, slope in rows])]
        for index, peak in enumerate(self.search.peaks):
            tops = self.search.motions.peaks(found, *peak)
            at = _led(self.edges[index], tops.place, tops.value)
            held = self.search.motions.held(found, *peak, at)
            below = np.zeros((len(at), len(self.sizes)))
            below[:, index] = -self.sizes[index]
            values.append(held.values - bounds[index])
            slopes.append(np.hstack([held.slopes, below]))
        return Linear(np.concatenate(values), np.concatenate(slopes))

    def _sum(self, wanted: Sum, measures: Linear, bounds: Floats) -> tuple[float, Floats]:
        total, slope = wanted.constant, np.zeros(self.count + len(self.sizes))
        for part in wanted.parts:
            if isinstance(part, Plain):
                row = self.search.motions.row[part.measure]
                total += part.factor * measures.values[row]
                slope[: self.count] += part.factor * measures.slopes[row]
            else:
                place = self.search.peaks.index((part.measure, part.sign))
                total += part.factor * bounds[place]
                slope[self.count + place] += part.factor * self.sizes[place]
        return float(total), slope


def _edges(places: Floats, values: Floats) -> Floats:
    """Where windows begin and end: half way between the highest peaks."""
    chosen = np.sort(places[np.argsort(-values, kind="stable")[:MOST_WINDOWS]])
    return np.concatenate([[-np.inf], 0.5 * (chosen[1:] + chosen[:-1]), [np.inf]])


def _led(edges: Floats, places: Floats, values: Floats) -> Floats:
    """The highest peak within each window; that of all where there is none."""
    whole = places[np.argmax(values)]
    result = []
    for low, high in pairwise(edges.tolist()):
        inside = (places >= low) & (places < high)
        result.append(places[inside][np.argmax(values[inside])] if inside.any() else whole)
    return np.array(result)
