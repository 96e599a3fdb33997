"""Bifurcation diagrams as labelled arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.sections.contact_log import CONTACT, contact_variables
from linkages.chaos.sections.free_states import PAIRS, free_names
from linkages.chaos.sweeps.continuation import Visited
from linkages.chaos.sweeps.sweep import INTERRUPTED, Outcome, reason_of
from linkages.errors import ComputationError
from linkages.kernel.outputs import VARIABLES, links
from linkages.kernel.system import System

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

NOTHING = (np.nan, np.nan)


@dataclass(frozen=True, eq=False)
class Value:
    """What was found at a value of what is varied.

    Parameters
    ----------
    visited
        Points of the section.
    exponent
        The largest exponent and its error.
    refusal
        Why something of it is missing.
    """

    visited: Visited
    exponent: tuple[float, float] = NOTHING
    refusal: ComputationError | None = None


def diagram(
    system: System,
    found: Sequence[Outcome | None],
    shape: tuple[int, int],
    points: int,
    exponent: bool,
    varied: Mapping[str, Any],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """Arrays padded with nan where fewer points were found.

    Parameters
    ----------
    system
        The mechanism at one of the values.
    found
        Outcomes with a `Value`, for one start after the other; None where there is none yet.
    shape
        Numbers of starts and of values.
    points
        Most points at a value.
    exponent
        Whether exponents were computed.
    varied
        Coordinates of what is varied.
    attributes
        Of the dataset.
    """
    import xarray as xr

    values: list[Value | None] = [None if o is None else o.value for o in found]
    names = free_names(system)
    variables: dict[str, Any] = {}
    outputs = [(dim, output) for dim in names for output in PAIRS[dim]]
    if system.topology.internal:
        names["internal"] = list(system.topology.internal)
        outputs.append(("internal", "internal_state"))
    for dim, output in outputs:
        elements = names[dim]
        units, long_name = VARIABLES[output].described(system.model)
        attrs = {"units": units, "long_name": long_name}
        rows = _padded(values, output, points, len(elements))
        dims = ("start", "value", "crossing", dim)
        variables[output] = (dims, rows.reshape(*shape, points, -1), attrs)
    if exponent:
        pairs = [NOTHING if value is None else value.exponent for value in values]
        words = {"exponent": "largest Lyapunov exponent", "error": "its standard error"}
        for (name, text), column in zip(words.items(), np.array(pairs).T, strict=True):
            attrs = {"units": "1/s", "long_name": text}
            variables[name] = (("start", "value"), column.reshape(shape), attrs)
    variables |= _contact(system, values, shape)
    reasons, times = zip(*(_reason(outcome) for outcome in found), strict=True)
    warnings = ["" if value is None else value.visited.warning for value in values]
    for name, texts in (("reason", reasons), ("warning", warnings)):
        variables[name] = (("start", "value"), np.array(texts, dtype=object).reshape(shape))
    attrs = {"units": "s", "long_name": "time at which the motion stopped"}
    variables["stop_time"] = (("start", "value"), np.reshape(times, shape), attrs)
    members = {dim: np.array(elements, dtype=object) for dim, elements in names.items()}
    return xr.Dataset(variables, {**varied, **members}, attributes)


def _padded(values: Sequence[Value | None], output: str, points: int, width: int) -> Floats:
    rows = np.full((len(values), points, width), np.nan)
    for row, value in zip(rows, values, strict=True):
        if value is not None:
            found = value.visited.values[output]
            row[: len(found)] = found
    return rows


def _contact(
    system: System, values: Sequence[Value | None], shape: tuple[int, int]
) -> dict[str, Any]:
    names = links(system.model)
    if not names:
        return {}
    nothing = np.full(len(names), np.nan)
    arrays = {
        name: np.stack(
            [nothing if value is None else value.visited.values[name] for value in values]
        ).reshape(*shape, -1)
        for name in CONTACT
    }
    intervals = [value.visited.interval for value in values if value is not None]
    return contact_variables(arrays, max(intervals, default=np.nan), ("start", "value"))


def _reason(outcome: Outcome | None) -> tuple[str, float]:
    """Why there is no result or only part of one, and when the motion stopped."""
    if outcome is None:
        return INTERRUPTED, np.nan
    reason, time = outcome.reason or "", outcome.stop_time
    if outcome.value is not None and outcome.value.refusal is not None:
        reason, time = reason_of(outcome.value.refusal), outcome.value.refusal.time
    return reason, np.nan if time is None else time
