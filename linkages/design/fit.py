"""Fit numbers of a definition to measurements by least squares, with standard errors.

P. R. Bevington and D. K. Robinson, *Data Reduction and Error Analysis for the Physical Sciences*,
3rd ed., 2003, chapters 7 and 8.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.design.differentiated import Differentiated
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
from linkages.errors import ComputationError, InputError, Interrupted
from linkages.options.option import takes
from linkages.options.run import SimulationKeywords, SimulationOptions
from linkages.solution.run_options import options_of
from linkages.spec.measures import argument, read_measure

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

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
        """Between −1 and 1, shape (paths, paths)."""
        return self.covariance / np.outer(self.errors, self.errors)


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


class Residuals:
    """Computed less measured values in standard deviations, over places in the box of bounds.

    `watch` gets the number of motions and the least sum of squares after each.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        ranges: Ranges,
        measured: Measured,
        given: dict[str, object],
        watch: Callable[[int, float], None] | None,
    ) -> None:
        self._ranges, self._watch = ranges, watch
        self._time = measured.time
        self._there = np.array([np.isfinite(column.values) for column in measured.columns])
        self._values = np.array([column.values for column in measured.columns])[self._there]
        self.sigma = np.array([column.sigma for column in measured.columns])[self._there]
        self._measures = [read_measure(f"final({column.series})") for column in measured.columns]
        texts = [each.text for each in self._measures]
        self._own = Differentiated(mechanism, texts, ranges.paths, run=given)
        self._known: dict[bytes, tuple[Floats, Floats] | None] = {}
        self.squares: list[float] = []
        self.reasons: list[str] = []
        self.best: Floats | None = None

    @property
    def start(self) -> Floats:
        """Numbers of the definition in SI."""
        return np.array(self._own.values)

    def at(self, places: Floats) -> tuple[Floats, Floats] | None:
        """Residuals, shape (m,), and derivatives by places, (m, paths); None if there are none."""
        key = places.tobytes()
        if key not in self._known:
            self._known[key] = self._computed(places)
        return self._known[key]

    def _computed(self, places: Floats) -> tuple[Floats, Floats] | None:
        try:
            moved = self._own.moved(self._ranges.numbers(places), self._own.series)
        except (ComputationError, InputError) as error:
            self.reasons.append(str(error))
            self.squares.append(np.nan)
            return None
        at = moved.places(self._time)
        result = [followed(argument(each), moved, at) for each in self._measures]
        values = np.array([each.value for each in result])[self._there]
        values = (values - self._values) / self.sigma
        squares = float(values @ values)
        if self.best is None or squares < np.nanmin(self.squares):
            self.best = places.copy()
        self.squares.append(squares)
        if self._watch is not None:
            self._watch(len(self.squares), float(np.nanmin(self.squares)))
        slopes = np.array([each.slopes for each in result]).transpose(0, 2, 1)[self._there]
        return values, slopes * self._ranges.width / self._own.scales / self.sigma[:, None]

    def values(self, places: Floats) -> Floats:
        """Residuals; larger than all others where there are none, so that steps become shorter."""
        result = self.at(places)
        if result is None:
            largest = np.nanmax(self.squares)
            return np.full(len(self._values), _STEEP * np.sqrt(largest / len(self._values) + 1.0))
        return result[0]

    def slopes(self, places: Floats) -> Floats:
        """Derivatives by places; only asked for where there are residuals."""
        result = self.at(places)
        assert result is not None
        return result[1]


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
        `residual`, their difference as a part of sigma; `history`, the sum of squares run by run.
        All in SI. Attributes are `chi_square`, `degrees_of_freedom`, `probability` and `notes`.
    """

    mechanism: Mechanism
    text: str
    data: xr.Dataset


@takes(SimulationOptions)
def fit(
    mechanism: Mechanism,
    measured: Measurements | Measured,
    vary: Vary,
    *,
    sigma: Mapping[str, Any] | None = None,
    starts: int = 1,
    seed: int = 0,
    watch: Callable[[int, float], None] | None = None,
    **options: Unpack[SimulationKeywords],
) -> Fitted:
    """Numbers of a definition with which the motion goes as it was measured.

    Least squares with exact derivatives, within bounds (a trust-region method of SciPy).

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
    residuals = Residuals(mechanism, ranges, result, given, watch)
    try:
        for places in ranges.starts(residuals.start, starts, seed):
            _fitted(residuals, places)
    except KeyboardInterrupt:
        message = f"interrupted after {len(residuals.squares)} runs"
        if residuals.best is None:
            raise Interrupted(message) from None
        kept = _result(mechanism, ranges, result, residuals, interrupted=True)
        raise Interrupted(message, kept={"fit": kept.data, "fitted.yaml": kept.text}) from None
    if residuals.best is None:
        raise ComputationError(
            f"no feasible start: {residuals.reasons[0]}; expected other numbers or bounds, or "
            "several starts", time=None,
        )  # fmt: skip
    return _result(mechanism, ranges, result, residuals, interrupted=False)


def _fitted(residuals: Residuals, places: Floats) -> None:
    """Fit from some places; what is found is in the residuals."""
    from scipy.optimize import least_squares

    if residuals.at(places) is None:
        return
    least_squares(
        residuals.values, places, jac=residuals.slopes, bounds=(0.0, 1.0), method="trf",
        ftol=_TOLERANCE, xtol=_TOLERANCE, gtol=_TOLERANCE,
    )  # fmt: skip


def _result(
    mechanism: Mechanism,
    ranges: Ranges,
    measured: Measured,
    residuals: Residuals,
    *,
    interrupted: bool,
) -> Fitted:
    best = residuals.best
    assert best is not None
    at_best = residuals.at(best)
    assert at_best is not None
    values, slopes = at_best
    at_bound = (best <= AT_BOUND) | (best >= 1.0 - AT_BOUND)
    how = known(ranges, values, slopes / ranges.width, at_bound, measured.absolute)
    numbers = ranges.numbers(best)
    pairs = zip(ranges.each, numbers, strict=True)
    changed, text = rewritten(
        mechanism,
        {each.path: each.written(float(number)) for each, number in pairs},
        _remarks(ranges, numbers, how),
    )
    data = _dataset(mechanism, ranges, measured, residuals, how, values)
    data.attrs["notes"] += kept(changed)
    data.attrs["interrupted"] = int(interrupted)
    return Fitted(mechanism=changed, text=text, data=data)


def _remarks(ranges: Ranges, numbers: Floats, how: Known) -> list[str]:
    """What was fitted, and how well it is known."""
    result = [f"linkages fit: chi-square {how.chi_square:.6g}, {how.freedom} degrees of freedom"]
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
    starts: int = 1,
    seed: int = 0,
    **options: Unpack[SimulationKeywords],
) -> Fitted:
    """A fit to the measurements that are stored with its `results`."""
    measured = measurements_in(results)
    return fit(mechanism, measured, [*vary], starts=starts, seed=seed, **options)
