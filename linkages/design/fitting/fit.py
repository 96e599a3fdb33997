"""Fit numbers of a definition to measurements, by least squares."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.design.fitting.known import Known, known
from linkages.design.fitting.measured import Measured, Measurements, measured_of
from linkages.design.fitting.residuals import Residuals
from linkages.design.varied.ranges import AT_BOUND, Ranges, Vary, ranges_of, require_starts
from linkages.design.varied.rewritten import kept, rewritten
from linkages.errors import ComputationError, Interrupted
from linkages.options.run import SimulationKeywords, SimulationOptions
from linkages.options.signature import takes
from linkages.solution.options import options_of
from linkages.sweeps.distributions import probabilities

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

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
    found = measured_of(mechanism, measured, sigma)
    given = {name: value for name, value in options.items() if value is not None}
    given.setdefault("end", float(found.time[-1]))
    run = options_of(SimulationOptions, mechanism, given)
    if run.end < found.time[-1]:
        raise ValueError(f"end is {run.end:g} s, but was measured until {found.time[-1]:g} s")
    residuals = Residuals(mechanism, ranges, found, given, watch)
    try:
        for places in _starts(ranges, residuals.start, starts, seed):
            _fitted(residuals, places)
    except KeyboardInterrupt:
        message = f"interrupted after {len(residuals.squares)} runs"
        if residuals.best is None:
            raise Interrupted(message) from None
        kept = _result(mechanism, ranges, found, residuals, interrupted=True)
        raise Interrupted(message, kept={"fit": kept.data, "fitted.yaml": kept.text}) from None
    if residuals.best is None:
        raise ComputationError(
            f"no feasible start: {residuals.reasons[0]}; expected other numbers or bounds, or "
            "several starts", time=None,
        )  # fmt: skip
    return _result(mechanism, ranges, found, residuals, interrupted=False)


def _starts(ranges: Ranges, first: Floats, count: int, seed: int) -> list[Floats]:
    others = np.zeros((0, len(first)))
    if count > 1:
        others = np.array(probabilities(ranges.paths, count - 1, seed, "sobol")).T
    return [ranges.places(first), *others]


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
    found = [f"linkages fit: chi-square {how.chi_square:.6g}, {how.freedom} degrees of freedom"]
    for each, number, error in zip(ranges.each, numbers, how.errors, strict=True):
        known_by = f" ± {each.of_si(error):.2g}" if np.isfinite(error) else ""
        found.append(f"  {each.path}: {each.of_si(number):.6g}{known_by} {each.label}".rstrip())
    return found


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
