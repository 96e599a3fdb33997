"""Sensitivities and fits as commands write them, and as result files store them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.design.fit import Fitted, fit
from linkages.design.measurements import Column, Measured
from linkages.design.sensitivities import sensitivities
from linkages.errors import InputError, Problem
from linkages.options.option import takes
from linkages.options.run import SimulationKeywords, SimulationOptions
from linkages.spec.measures import read_measure

if TYPE_CHECKING:
    import xarray as xr


@takes(SimulationOptions)
def sensitivity_asked(
    mechanism: Mechanism,
    of: Sequence[str],
    to: Sequence[str],
    **options: Unpack[SimulationKeywords],
) -> xr.Dataset:
    """Sensitivities of measures, and of the series that they reduce.

    Parameters
    ----------
    mechanism
        As `linkages.sensitivities` takes it.
    of, to
        Measures, and paths or patterns of numbers.
    options
        As `SimulationOptions` describes them.
    """
    measures = list(dict.fromkeys(read_measure(text).text for text in of))
    series = [name for text in measures for name in read_measure(text).series]
    return sensitivities(mechanism, list(dict.fromkeys([*measures, *series])), [*to], **options)


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
    """A fit to the measurements that are kept beside its results.

    Parameters
    ----------
    mechanism, vary, starts, seed
        As `linkages.fit` takes them.
    results
        Of the same fit.
    options
        As `SimulationOptions` describes them.
    """
    measured = _measurements_in(results)
    return fit(mechanism, measured, [*vary], starts=starts, seed=seed, **options)


def _measurements_in(results: xr.Dataset) -> Measured:
    """The measurements of a fit, as its results store them."""
    expected: dict[str, tuple[tuple[str, ...], str]] = {
        "series": (("series",), "OU"),
        "series_units": (("series",), "OU"),
        "time": (("time",), "f"),
        "measured": (("series", "time"), "f"),
        "sigma": (("series", "time"), "f"),
    }
    for name, (dims, kinds) in expected.items():
        result = results.variables.get(name)
        if (
            result is None
            or result.dims != dims
            or result.dtype.kind not in kinds
            or not result.size
        ):
            raise _damaged(results, f"{name!r} is missing or damaged")
    time, sigma = results["time"].to_numpy(), results["sigma"].to_numpy()
    if not (np.isfinite(time).all() and (np.diff(time) > 0).all()):
        raise _damaged(results, "times do not increase")
    if not (sigma > 0).all():
        raise _damaged(results, "standard deviations are not above zero")
    texts: Any = zip(results["series"].to_numpy(), results["series_units"].to_numpy(), strict=True)
    columns = tuple(
        Column(str(name), "", str(unit), results["measured"][k].values, results["sigma"][k].values)
        for k, (name, unit) in enumerate(texts)
    )
    known = bool(results.attrs.get("sigma_known", False))
    return Measured(time, columns, known)


def _damaged(results: xr.Dataset, what: str) -> InputError:
    message = f"expected the measurements of a fit; {what}"
    return InputError(str(results.encoding.get("source", "results")), [Problem(message=message)])
