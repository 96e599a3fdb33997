"""Sensitivities of outputs and measures to the numbers of a definition."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.mechanisms.registry import unit_at, unit_written
from linkages.design.differentiated import Differentiated
from linkages.design.moved import Moved
from linkages.errors import ComputationError
from linkages.kernel.number_effects import number_value
from linkages.kernel.outputs import VARIABLES, labels
from linkages.kernel.system import System
from linkages.options.option import takes
from linkages.options.run import SimulationKeywords, SimulationOptions
from linkages.reading.wording import suggestion
from linkages.solution.measure_names import known_series, resolved_text, series_unit
from linkages.solution.measuring import is_formula
from linkages.solution.series import TIME, Series, available, requested, system_series
from linkages.spec.measures import read_measure
from linkages.spec.units import unit

if TYPE_CHECKING:
    import xarray as xr

PARAMETER = "parameter"


def sensitivities(
    mechanism: Mechanism,
    outputs: str | Sequence[str],
    parameters: str | Sequence[str],
    **run: Unpack[SimulationKeywords],
) -> xr.Dataset:
    """Exact derivatives of outputs and measures by numbers of the definition, along the motion.

    Parameters
    ----------
    mechanism
        Its motion starts as the definition says.
    outputs
        Outputs such as ``"drive_effort"``, series such as ``"crank.effort"``, and measures such as
        ``"max(abs(crank.effort))"``.
    parameters
        Dotted paths of numbers of the definition, such as ``"bars.rod.length"``, or patterns such
        as ``"bars.*"`` for all that are written there.
    run
        How the motion is simulated, as `linkages.simulate` takes it.

    Returns
    -------
    Dataset with a dimension ``parameter``, and a variable for each of `outputs`: of outputs with
    time and their elements before it, of measures without. The unit of a derivative is that of the
    variable per that of the parameter, SI both; the latter stands in the coordinate
    ``parameter_units``, the numbers themselves in ``parameter_value``. The attribute ``value`` of
    a measure is the measure itself. A variable in which something does not exist is nan there, and
    has an attribute ``reason``.

    Raises
    ------
    InputError
        If a path leads to no number, or the mechanism cannot be assembled.
    ValueError
        If a text is no output, series or measure of the mechanism, or has no derivative.
    ComputationError
        If the motion stops before its end, or has no derivatives.

    Examples
    --------
    >>> import linkages
    >>> mechanism = linkages.load("slider-crank")
    >>> found = linkages.sensitivities(mechanism, "stroke(piston.position)", "bars.*.length")
    >>> found["stroke(piston.position)"].sel(parameter="bars.crank.length").item()  # 2 r
    2.0
    """
    import xarray as xr

    asked = [outputs] if isinstance(outputs, str) else [*outputs]
    paths = [parameters] if isinstance(parameters, str) else [*parameters]
    if not asked:
        raise ValueError("no outputs are asked for; expected names such as 'drive_effort'")
    measures = [text for text in asked if _is_measure(mechanism, text)]
    result = Differentiated(mechanism, measures, paths, run=dict(run))
    elements = {name: _elements(result.system, name) for name in asked if name not in measures}
    series = {each.name: each for own in elements.values() for each in own}
    moved = result.moved(result.values, {**result.series, **series})
    variables, coordinates = _over_time(result, moved, elements)
    for text, measured_in, (value, row, missing) in zip(
        measures, result.units, result.each(moved), strict=True
    ):
        attrs = {"units": _per(measured_in), "long_name": f"derivative of {text}", "value": value}
        variables[text] = ((PARAMETER,), row, attrs | _because(missing))
    units = [unit_at(mechanism.definition, path) for path in result.paths]
    coordinates |= {
        PARAMETER: [*result.paths],
        "parameter_value": (PARAMETER, result.values),
        "parameter_units": (PARAMETER, units),
    }
    about = {"name": mechanism.name, "source": mechanism.file_name}
    return xr.Dataset({text: variables[text] for text in asked}, coordinates, about)


def _is_measure(mechanism: Mechanism, text: str) -> bool:
    """Whether a text is a formula, or a number of the definition and no series."""
    known = system_series(System(mechanism))
    if is_formula(known, text):
        return True
    named = text in VARIABLES or text in known
    return not named and number_value(mechanism, text) is not None


def _over_time(
    found: Differentiated, moved: Moved, elements: Mapping[str, Sequence[Series]]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Variables of derivatives along the motion, and their coordinates."""
    system, time = found.system, found.sample_times
    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {}
    for name, own in elements.items():
        dims = VARIABLES[name].dims if name in VARIABLES else ()
        coordinates |= {dim: [*labels(system.model, dim)] for dim in dims}
        coordinates |= {"time": ("time", time, {"units": "s"})}
        missing = ""
        try:
            rows = found.sampled(moved, [one.name for one in own])
        except ComputationError as error:
            missing = str(error)
            rows = np.full((len(own), len(found.paths), len(time)), np.nan)
        finite = np.isfinite(rows)
        if not missing and not finite.all():
            first = time[~finite.all(axis=(0, 1))][0]
            missing = f"{name} has no finite derivative at t = {first:.9g} s"
        rows = np.where(finite, rows, np.nan)
        shape = tuple(len(coordinates[dim]) for dim in dims)
        unit = " or ".join(dict.fromkeys(series_unit(system, one) for one in own))
        attrs = {"units": _per(unit), "long_name": f"derivative of {name.replace('_', ' ')}"}
        values = np.moveaxis(rows, 2, 0).reshape(-1, *shape, len(found.paths))
        variables[name] = (("time", *dims, PARAMETER), values, attrs | _because(missing))
    return variables, coordinates


def _elements(system: System, name: str) -> list[Series]:
    """All series of an output, the last dimension running fastest; or the one of that name."""
    if name in VARIABLES:
        requested(system, [name])
        return [each for each in system_series(system).values() if each.variable == name]
    if "." not in name and name != TIME:
        own = available(system)
        near = suggestion(name, own) or f"; expected one such as {own[0]}"
        raise ValueError(f"unknown output {name!r}{near}")
    return [*known_series(system, [name]).values()]


def _because(missing: str) -> dict[str, str]:
    """What says why something does not exist."""
    return {"reason": missing} if missing else {}


def _per(unit: str) -> str:
    """The unit of a derivative; that of the parameter is a coordinate."""
    return f"{unit or '1'} / parameter_units"


@dataclass(frozen=True)
class Effect:
    """How a measure changes with a number, in the unit of the definition or in SI."""

    parameter: str  # dotted path of the number
    number: float
    unit: str
    derivative: float  # of the measure in SI, by the number in that unit
    # Change of the measure in percent for one percent of the number, d ln m / d ln n; None where
    # one of the two is zero, or there is no derivative
    relative: float | None


def effects_of(mechanism: Mechanism, data: xr.Dataset, measure: str) -> list[Effect]:
    """The effects of all numbers on a measure, the largest change per percent first, zeros last."""
    value, result = float(data[measure].attrs["value"]), []
    rows = zip(
        data["parameter"].values.tolist(), data["parameter_value"].values.tolist(),
        data[measure].values.tolist(), strict=True,
    )  # fmt: skip
    for path, number, slope in rows:
        name, size = written_unit(mechanism, path)
        relative = slope * number / value if value and number and math.isfinite(slope) else None
        result.append(Effect(path, number / size, name, slope * size, relative))
    sizes = [abs(effect.derivative * effect.number) for effect in result]
    rounded = [-float(f"{size:.9g}") for size in sizes]  # round-off is no order
    order = np.argsort(rounded, kind="stable")
    ordered = [result[place] for place in order]
    return sorted(ordered, key=lambda effect: effect.derivative * effect.number == 0.0)


def written_unit(mechanism: Mechanism, path: str) -> tuple[str, float]:
    """The unit that a number of a definition is written in, and what one of it is in SI."""
    name = unit_written(mechanism.definition, path)
    if name:
        kind = unit(name)
        return name, kind.convert(1.0) - kind.convert(0.0)
    return unit_at(mechanism.definition, path), 1.0


@takes(SimulationOptions)
def sensitivity_asked(
    mechanism: Mechanism,
    of: Sequence[str],
    to: Sequence[str],
    **options: Unpack[SimulationKeywords],
) -> xr.Dataset:
    """Sensitivities of measures (`of`) and of the series that they reduce, to numbers."""
    measures = list(dict.fromkeys(read_measure(text).text for text in of))
    system = System(mechanism)
    series = [name for text in measures for name in resolved_text(system, text).series]
    return sensitivities(mechanism, list(dict.fromkeys([*measures, *series])), [*to], **options)
