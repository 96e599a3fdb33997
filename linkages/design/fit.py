"""Fit numbers of a definition to measurements by least squares, with standard errors.

P. R. Bevington and D. K. Robinson, *Data Reduction and Error Analysis for the Physical Sciences*,
3rd ed., 2003, chapters 7 and 8.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Unpack

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.design.atlas import Atlas, Timed
from linkages.design.differentiated import Differentiated
from linkages.design.goals import HOLDS, Constraint, constraint_of
from linkages.design.measurements import Measured, Measurements, measured_of, measurements_in
from linkages.design.ranges import (
    AT_BOUND,
    Ranges,
    Vary,
    kept,
    ranges_of,
    require_starts,
    rewritten,
)
from linkages.design.reductions import followed
from linkages.design.variants import Variant, variants_of
from linkages.errors import ComputationError, InputError, Interrupted
from linkages.options.option import takes
from linkages.options.run import SimulationKeywords, SimulationOptions
from linkages.solution.run_options import options_of
from linkages.spec.measures import argument, read_measure

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

ACTIVE = 1e-6
"""Part of what a constraint changes by over the bounds within which it is met exactly."""

SINGULAR = 1e-7
"""Ratio of singular values, of columns of length one, below which numbers cannot be told apart."""


@dataclass(frozen=True)
class Known:
    """How well numbers are known."""

    chi_square: float  # sum of squares of residuals, each as a part of its standard deviation
    freedom: int  # number of measured values less numbers that were fitted
    # That chi-square is as large or larger by chance; nan where standard deviations are unknown
    probability: float
    # Of the numbers in SI, shape (paths, paths); nan of those at bounds, or not to be told apart
    covariance: Floats
    notes: tuple[str, ...]  # what is doubtful

    @property
    def errors(self) -> Floats:
        """Standard errors in SI."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> Floats:
        """Between −1 and 1, shape (paths, paths); nan where a fit is exact."""
        with np.errstate(invalid="ignore"):
            return np.asarray(self.covariance / np.outer(self.errors, self.errors))


def known(
    ranges: Ranges, residuals: Floats, slopes: Floats, at_bound: NDArray[np.bool_], absolute: bool
) -> Known:
    """Uncertainty of fitted numbers.

    `residuals`, shape (m,), are parts of standard deviations; `slopes`, (m, paths), their
    derivatives.
    """
    from scipy.special import gammaincc

    chi_square = float(residuals @ residuals)
    free = np.flatnonzero(~at_bound)
    freedom = len(residuals) - len(free)
    notes = [f"{ranges.paths[place]} is at its bound" for place in np.flatnonzero(at_bound)]
    covariance = np.full((len(ranges), len(ranges)), np.nan)
    sizes = np.sqrt((slopes[:, free] ** 2).sum(axis=0))
    idle = free[sizes == 0.0]
    notes += [f"{ranges.paths[place]} changes nothing that was measured" for place in idle]
    free, sizes = free[sizes > 0.0], sizes[sizes > 0.0]
    if len(free):
        _, values, directions = np.linalg.svd(slopes[:, free] / sizes, full_matrices=False)
        weak = values <= SINGULAR * values[0]
        notes += [_alike(ranges, free, direction / sizes) for direction in directions[weak]]
        mixed = (np.abs(directions[weak]) > np.sqrt(SINGULAR)).any(axis=0)
        factor = 1.0 if absolute else chi_square / max(freedom, 1)
        scaled = directions[~weak] / values[~weak, None]
        result = factor * (scaled.T @ scaled) / np.outer(sizes, sizes)
        result[mixed], result[:, mixed] = np.nan, np.nan
        covariance[np.ix_(free, free)] = result
    if freedom < 1:
        notes.append(f"{len(residuals)} values were measured for {len(free)} numbers")
    known = absolute and freedom > 0
    chance = float(gammaincc(freedom / 2, chi_square / 2)) if known else np.nan
    return Known(chi_square, freedom, chance, covariance, (*notes,))


def _alike(ranges: Ranges, free: NDArray[np.intp], direction: Floats) -> str:
    """Which numbers cannot be told apart, as a step that changes nothing."""
    width = np.array([ranges.each[place].upper - ranges.each[place].lower for place in free])
    step = direction / (direction / width)[np.argmax(np.abs(direction / width))] / 100.0
    large = np.abs(step / width) > 1e-6
    parts = [
        f"{ranges.paths[place]} by {'+' if size > 0 else ''}{ranges.each[place].shown(size)}"
        for place, size in zip(free[large], step[large], strict=True)
    ]
    return f"cannot be told apart: changing {' and '.join(parts)} changes nothing that was measured"


_STEEP = 1e3


class _Motion(NamedTuple):
    """What comes of some places: residuals and excesses of constraints, by places."""

    residuals: Floats  # shape (m,)
    slopes: Floats  # shape (m, paths)
    excess: Floats  # shape (constraints,)
    excess_slopes: Floats  # shape (constraints, paths)
    sizes: Floats  # of what constraints compare, shape (constraints,)


class Residuals:
    """Computed less measured values in standard deviations, over places in the box of bounds.

    `watch` gets the number of motions and the least sum of squares after each, of those that
    satisfy the constraints.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        ranges: Ranges,
        measured: Measured,
        given: dict[str, object],
        constraints: Sequence[Constraint],
        watch: Callable[[int, float], None] | None,
    ) -> None:
        self._ranges, self._watch, self.constraints = ranges, watch, constraints
        self._time = measured.time
        self._there = np.array([np.isfinite(column.values) for column in measured.columns])
        self._values = np.array([column.values for column in measured.columns])[self._there]
        self.sigma = np.array([column.sigma for column in measured.columns])[self._there]
        self._measures = [read_measure(f"final({column.series})") for column in measured.columns]
        texts = [each.text for each in self._measures]
        texts += [each.excess.text for each in constraints]
        texts += [each.measured.text for each in constraints]
        self._own = Differentiated(mechanism, texts, ranges.paths, run=given)
        self._known: dict[bytes, _Motion | None] = {}
        self.squares: list[float] = []
        self.reasons: list[str] = []
        self.best: Floats | None = None
        self.least = np.nan

    @property
    def aim(self) -> Timed:
        """What the motion is compared with."""
        names = [name for each in self._measures for name in each.series]
        return Timed(names, self._time, self._there, self._values, self.sigma)

    @property
    def start(self) -> Floats:
        """Numbers of the definition in SI."""
        return np.array(self._own.values)

    def at(self, places: Floats) -> _Motion | None:
        """The motion at some places; None if it cannot be computed."""
        key = places.tobytes()
        if key not in self._known:
            self._known[key] = self._computed(places)
        return self._known[key]

    def _computed(self, places: Floats) -> _Motion | None:
        try:
            moved = self._own.moved(self._ranges.numbers(places), self._own.series)
            reduced = self._own.reduced(moved) if self.constraints else None
        except (ComputationError, InputError) as error:
            self.reasons.append(str(error))
            self.squares.append(np.nan)
            return None
        at = moved.places(self._time)
        result = [followed(argument(each), moved, at) for each in self._measures]
        values = np.array([each.value for each in result])[self._there]
        values = (values - self._values) / self.sigma
        slopes = np.array([each.slopes for each in result]).transpose(0, 2, 1)[self._there]
        slopes = slopes * self._ranges.width / self._own.scales / self.sigma[:, None]
        excess = excess_slopes = sizes = np.empty(0)
        if reduced is not None:
            assert reduced.derivatives is not None
            first, count = len(self._measures), len(self.constraints)
            excess, measured = reduced.values[first:].reshape(2, count)
            sizes = np.maximum(np.abs(measured), np.abs(excess))
            excess_slopes = reduced.derivatives[first : first + count] * self._ranges.width
        motion = _Motion(values, slopes, excess, excess_slopes, sizes)
        squares = float(values @ values)
        if self.holds(motion) and not squares >= self.least:
            self.best, self.least = places.copy(), squares
        self.squares.append(squares)
        if self._watch is not None:
            self._watch(len(self.squares), self.least)
        return motion

    def holds(self, motion: _Motion) -> bool:
        """Whether a motion satisfies all constraints."""
        parts = zip(self.constraints, motion.excess, motion.sizes, strict=True)
        return all(each.violation(value) <= HOLDS * (size or 1.0) for each, value, size in parts)

    def values(self, places: Floats) -> Floats:
        """Residuals; larger than all others where there are none, so that steps become shorter."""
        result = self.at(places)
        if result is None:
            largest = np.nanmax(self.squares)
            return np.full(len(self._values), _STEEP * np.sqrt(largest / len(self._values) + 1.0))
        return result.residuals

    def slopes(self, places: Floats) -> Floats:
        """Derivatives by places; only asked for where there are residuals."""
        result = self.at(places)
        assert result is not None
        return result.slopes


_TOLERANCE = 1e-13


@dataclass(frozen=True, kw_only=True)
class Fitted:
    """What `linkages.fit` returns.

    Parameters
    ----------
    mechanism
        With the numbers that fit best.
    text
        Its definition, on top of which stands what was fitted.
    data
        Dataset: `number` (state, path), `standard_error` (path), `covariance` and `correlation`
        (path, other_path), `lower`, `upper`; `measured`, `sigma` and `computed` (series, time) with
        `residual`, their difference as a part of sigma; `history`, the sum of squares run by run of
        the best variant; `variant_squares` (variant), the least sum of each assembly branch and
        sense of the drives that was searched. All in SI. Attributes are `chi_square`,
        `degrees_of_freedom`, `probability`, `variant` and `notes`.
    variants
        Assembly branch and sense of the drives → mechanism with the numbers that fit best in it,
        the best one first.
    """

    mechanism: Mechanism
    text: str
    data: xr.Dataset
    variants: Mapping[str, Mechanism]


@takes(SimulationOptions)
def fit(
    mechanism: Mechanism,
    measured: Measurements | Measured,
    vary: Vary,
    *,
    sigma: Mapping[str, Any] | None = None,
    subject_to: str | Sequence[str] = (),
    branches: str = "file",
    starts: int = 1,
    seed: int = 0,
    watch: Callable[[int, float], None] | None = None,
    **options: Unpack[SimulationKeywords],
) -> Fitted:
    """Numbers of a definition with which the motion goes as it was measured.

    Least squares with exact derivatives, within bounds (a trust-region method of SciPy; sequential
    quadratic programming where constraints are not satisfied).

    Parameters
    ----------
    mechanism
        From a file or made in Python; its numbers are the start, moved to the nearest bound.
    measured
        A CSV file with a head over each column, such as ``time (s)``, ``crank.angle (deg)`` or
        ``B.x position (mm)``, and ``sigma crank.angle (deg)`` or ``weight crank.angle`` where there
        are some; or a mapping of such heads to numbers. Nothing need be measured at every time.
    vary
        As `linkages.optimise` takes it.
    sigma
        Output → standard deviation of all of its values, as ``"0.5 deg"``. Without them values
        are alike, and their spread is estimated from the residuals.
    subject_to
        What must hold: comparisons of measures, as `linkages.optimise` takes them.
    branches
        ``"file"``: the assembly branch and the sense of the drives of the definition. ``"all"``:
        each assembly branch, and both senses of drives at constant speed; the best counts.
    starts, seed
        Fits from as many points, the first of which is the definition; the best counts.
    watch
        Called after each motion with how many there were, and the least sum of squares so far.
    options
        As `SimulationOptions` describes them. The motion ends with the measurements if it is not
        said.

    Raises
    ------
    InputError, ValueError, TypeError
        For what makes no sense.
    ComputationError
        If the motion cannot be computed at any start.
    Interrupted
        After Ctrl-C; ``kept["fit"]`` has the best so far.
    """
    require_starts(starts)
    ranges = ranges_of(mechanism, vary)
    result = measured_of(mechanism, measured, sigma)
    given = {name: value for name, value in options.items() if value is not None}
    given.setdefault("end", float(result.time[-1]))
    run = options_of(SimulationOptions, mechanism, given)
    if run.end < result.time[-1]:
        raise ValueError(f"end is {run.end:g} s, but was measured until {result.time[-1]:g} s")
    texts = [subject_to] if isinstance(subject_to, str) else [*subject_to]
    constraints = [constraint_of(text) for text in texts]
    variants = variants_of(mechanism, branches, ranges.paths)
    tried: list[_Tried] = []
    try:
        for variant in variants:
            own = mechanism.with_values(variant.values) if variant.values else mechanism
            residuals = Residuals(own, ranges, result, given, constraints, _counting(watch, tried))
            tried.append(_Tried(variant, residuals))
            atlas = Atlas(own, ranges, run, [residuals.aim], constrained=bool(constraints))
            for places in atlas.starts(residuals.start, starts, seed):
                _fitted(residuals, places)
    except KeyboardInterrupt:
        message = f"interrupted after {_runs(tried)} runs"
        if all(one.residuals.best is None for one in tried):
            raise Interrupted(message) from None
        kept = _result(mechanism, ranges, result, tried, interrupted=True)
        raise Interrupted(message, kept={"fit": kept.data, "fitted.yaml": kept.text}) from None
    if all(one.residuals.best is None for one in tried):
        reasons = [reason for one in tried for reason in one.residuals.reasons]
        why = reasons[0] if reasons else f"nothing that was tried satisfies {' and '.join(texts)}"
        raise ComputationError(
            f"no feasible start: {why}; expected other numbers or bounds, or several starts",
            time=None,
        )
    return _result(mechanism, ranges, result, tried, interrupted=False)


class _Tried(NamedTuple):
    """A variant with what came of it."""

    variant: Variant
    residuals: Residuals


def _runs(tried: Sequence[_Tried]) -> int:
    return sum(len(one.residuals.squares) for one in tried)


def _counting(
    watch: Callable[[int, float], None] | None, tried: Sequence[_Tried]
) -> Callable[[int, float], None] | None:
    """The same over all variants: runs of those before count, and so does their best."""
    if watch is None:
        return None
    before, least = _runs(tried), [one.residuals.least for one in tried]

    def counted(runs: int, squares: float) -> None:
        watch(before + runs, float(np.fmin.reduce([*least, squares])))

    return counted


def _fitted(residuals: Residuals, places: Floats) -> None:
    """Fit from some places; what is found is in the residuals."""
    from scipy.optimize import least_squares

    if residuals.at(places) is None:
        return
    found = least_squares(
        residuals.values, places, jac=residuals.slopes, bounds=(0.0, 1.0), method="trf",
        ftol=_TOLERANCE, xtol=_TOLERANCE, gtol=_TOLERANCE,
    ).x  # fmt: skip
    ended = residuals.at(found)
    if ended is not None and not residuals.holds(ended):
        for start in (found, places):
            _constrained(residuals, start)


def _constrained(residuals: Residuals, places: Floats) -> None:
    """The least sum of squares that satisfies the constraints, from some places."""
    from scipy.optimize import minimize

    last = residuals.at(places)
    assert last is not None

    def motion(where: Floats) -> _Motion:
        """The motion there, or the last one where there is none: the step is refused."""
        nonlocal last
        found = residuals.at(np.clip(where, 0.0, 1.0))
        last = last if found is None else found
        assert last is not None
        return last

    def squares(where: Floats) -> float:
        values = residuals.values(np.clip(where, 0.0, 1.0))
        return float(values @ values)

    def slope(where: Floats) -> Floats:
        found = motion(where)
        return 2.0 * found.residuals @ found.slopes

    sizes = np.abs(last.excess_slopes).max(axis=1)
    sizes = np.where(sizes > 0.0, sizes, 1.0)
    conditions = [
        {
            "type": "eq" if each.equal else "ineq",
            "fun": lambda w, k=k, s=each.sign or 1.0: -s * motion(w).excess[k] / sizes[k],
            "jac": lambda w, k=k, s=each.sign or 1.0: -s * motion(w).excess_slopes[k] / sizes[k],
        }
        for k, each in enumerate(residuals.constraints)
    ]
    minimize(
        squares, places, jac=slope, method="SLSQP", bounds=[(0.0, 1.0)] * len(places),
        constraints=conditions, options={"ftol": _TOLERANCE * squares(places), "maxiter": 300},
    )  # fmt: skip


def _result(
    mechanism: Mechanism,
    ranges: Ranges,
    measured: Measured,
    tried: Sequence[_Tried],
    *,
    interrupted: bool,
) -> Fitted:
    variant, residuals = min(tried, key=lambda one: np.nan_to_num(one.residuals.least, nan=np.inf))
    best = residuals.best
    assert best is not None
    at_best = residuals.at(best)
    assert at_best is not None
    values, slopes = at_best.residuals, at_best.slopes
    at_bound = (best <= AT_BOUND) | (best >= 1.0 - AT_BOUND)
    how = known(ranges, values, slopes / ranges.width, at_bound, measured.absolute)
    numbers = ranges.numbers(best)
    pairs = zip(ranges.each, numbers, strict=True)
    changed, text = rewritten(
        mechanism,
        variant.values | {each.path: each.written(float(number)) for each, number in pairs},
        _remarks(ranges, numbers, how, variant),
    )
    data = _dataset(mechanism, ranges, measured, residuals, how, values)
    data["variant_squares"] = "variant", [one.residuals.least for one in tried]
    data = data.assign_coords(variant=[one.variant.name for one in tried])
    data.attrs |= {"variant": variant.name, "runs": _runs(tried)}
    met = [
        each.text
        for each, value, slope in zip(
            residuals.constraints, at_best.excess, at_best.excess_slopes, strict=True
        )
        if abs(value) <= ACTIVE * np.abs(slope).max()
    ]
    data.attrs["notes"] += [
        f"'{text}' holds with nothing to spare: standard errors do not take it into account"
        for text in met
    ]
    if len(tried) == 1:
        data.attrs["notes"] += kept(changed)
    data.attrs["interrupted"] = int(interrupted)
    variants = {}
    for one in sorted(tried, key=lambda one: np.nan_to_num(one.residuals.least, nan=np.inf)):
        if one.residuals.best is not None:
            own = ranges.overrides(ranges.numbers(one.residuals.best))
            variants[one.variant.name] = mechanism.with_values(one.variant.values | own)
    return Fitted(mechanism=changed, text=text, data=data, variants=variants)


def _remarks(ranges: Ranges, numbers: Floats, how: Known, variant: Variant) -> list[str]:
    """What was fitted, and how well it is known."""
    result = [f"linkages fit: chi-square {how.chi_square:.6g}, {how.freedom} degrees of freedom"]
    result += [f"  {variant.name}"] if variant.name else []
    for each, number, error in zip(ranges.each, numbers, how.errors, strict=True):
        known_by = f" ± {each.of_si(error):.2g}" if np.isfinite(error) else ""
        result.append(f"  {each.path}: {each.of_si(number):.6g}{known_by} {each.label}".rstrip())
    return result


def _dataset(
    mechanism: Mechanism, ranges: Ranges, measured: Measured, residuals: Residuals, how: Known,
    values: Floats,
) -> xr.Dataset:  # fmt: skip
    import xarray as xr

    assert residuals.best is not None
    shape = len(measured.columns), len(measured.time)
    given = np.array([column.values for column in measured.columns])
    sigma = np.array([column.sigma for column in measured.columns])
    parts = np.full(shape, np.nan)
    parts[np.isfinite(given)] = values
    numbers = np.array([residuals.start, ranges.numbers(residuals.best)])
    two = ("path", "other_path")
    variables: dict[str, Any] = {
        "number": (("state", "path"), numbers),
        "standard_error": ("path", how.errors),
        "covariance": (two, how.covariance),
        "correlation": (two, how.correlation),
        "lower": ("path", ranges.lower),
        "upper": ("path", ranges.upper),
        "measured": (("series", "time"), given),
        "sigma": (("series", "time"), sigma),
        "computed": (("series", "time"), given + parts * sigma),
        "residual": (("series", "time"), parts, {"long_name": "computed less measured, per sigma"}),
        "history": ("run", residuals.squares, {"long_name": "sum of squares"}),
    }
    coordinates = {
        "state": ["start", "fit"],
        "path": ranges.paths,
        "other_path": ranges.paths,
        "path_unit": ("path", [each.label for each in ranges.each]),
        "series": [column.series for column in measured.columns],
        "series_units": ("series", [column.si for column in measured.columns]),
        "time": ("time", measured.time, {"units": "s"}),
    }
    attrs = {
        "name": mechanism.name,
        "chi_square": how.chi_square,
        "degrees_of_freedom": how.freedom,
        "probability": how.probability,
        "sigma_known": int(measured.absolute),
        "values": measured.count,
        "runs": len(residuals.squares),
        "notes": list(how.notes),
    }
    return xr.Dataset(variables, coordinates, attrs)


@takes(SimulationOptions)
def fit_asked(
    mechanism: Mechanism,
    vary: Sequence[str],
    results: xr.Dataset,
    *,
    subject_to: Sequence[str] = (),
    branches: str = "file",
    starts: int = 1,
    seed: int = 0,
    **options: Unpack[SimulationKeywords],
) -> Fitted:
    """A fit to the measurements that are stored with its `results`."""
    search: dict[str, Any] = {"subject_to": subject_to, "branches": branches}
    measured = measurements_in(results)
    return fit(mechanism, measured, [*vary], **search, starts=starts, seed=seed, **options)
