"""Bifurcation diagrams as labelled arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.sections.contact_log import CONTACT, contact_variables
from linkages.chaos.sections.free_states import state_outputs
from linkages.chaos.sections.touches import VARIABLES as TOUCHES
from linkages.chaos.sections.touches import touch_variables
from linkages.chaos.sweeps.continuation import Visited
from linkages.chaos.sweeps.map_data import longest
from linkages.errors import ComputationError
from linkages.kernel.outputs import VARIABLES, links
from linkages.kernel.system import System
from linkages.solution.values.surface import parse_section
from linkages.sweeps.answers import CODES, Answer, Arrays, Field, reasons
from linkages.sweeps.pointwise import stop_code
from linkages.sweeps.running import reason_of

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

NOTHING = (np.nan, np.nan)

BOTH = "both"
"""Forward, and backward."""


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


def value_fields(system: System, points: int, section: str | None) -> dict[str, Field]:
    """What is found at a value: at most so many points, and what goes with them."""
    touching = section is not None and parse_section(system, section).touch
    clearances = (len(links(system.model)),)
    return {
        **{
            output: Field(shape=(points, len(elements)))
            for output, (_, elements) in state_outputs(system).items()
        },
        **{name: Field(shape=(points, 1)) for name in TOUCHES if touching},
        "exponent": Field(), "error": Field(), "warning": Field("U"), "interval": Field(),
        **{name: Field(shape=clearances) for name in CONTACT},
    }  # fmt: skip


def answer_of(value: Value, points: int) -> Answer:
    """The answer at a value, padded with nan where fewer points were found."""
    visited, (exponent, error) = value.visited, value.exponent
    found: dict[str, Any] = {
        name: array if name in CONTACT else _padded(array, points)
        for name, array in visited.values.items()
    }
    found |= {"exponent": exponent, "error": error}
    found |= {"warning": visited.warning, "interval": visited.interval}
    if value.refusal is None:
        return Answer(found)
    refusal = value.refusal
    return Answer(found, stop_code(refusal), reason_of(refusal), refusal.time)


def _padded(rows: Floats, points: int) -> Floats:
    found = np.full((points, *rows.shape[1:]), np.nan)
    found[: len(rows)] = rows
    return found


def ways(start: str) -> tuple[str, ...]:
    """How diagrams are gone through, one after the other."""
    return ("forward", "backward") if start == BOTH else (start,)


def put_together(
    parts: Sequence[xr.Dataset], start: str, states: Sequence[Mapping[str, object]]
) -> xr.Dataset:
    """Diagrams of one way or of both as one, whose starts have names.

    Parameters
    ----------
    parts
        For each way; the last ones may be missing.
    start
        As options have it, or `BOTH`.
    states
        Overrides of each initial state.
    """
    import xarray as xr

    texts = [", ".join(f"{path}={value}" for path, value in state.items()) for state in states]
    texts = texts if len(states) > 1 else [""]
    prefixes = ways(start) if start == BOTH else ("",)
    named = []
    for part, way in zip(parts, prefixes, strict=False):
        names = [": ".join(t for t in (way, text) if t) for text in texts]
        named.append(part.assign_coords(start=np.array(names, dtype=object)))
    whole = named[0] if len(named) == 1 else xr.concat(named, "start", data_vars="all")
    whole.attrs["interrupted"] = max(part.attrs["interrupted"] for part in parts)
    return whole


def diagram(
    system: System,
    found: Arrays,
    shape: tuple[int, int],
    exponent: bool,
    varied: Mapping[str, Any],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """Points of sections over what is varied, as labelled arrays.

    Parameters
    ----------
    system
        The mechanism at one of the values.
    found
        Values of `value_fields`, for one start after the other.
    shape
        Numbers of starts and of values.
    exponent
        Whether exponents were computed.
    varied
        Coordinates of what is varied.
    attributes
        Of the dataset.
    """
    import xarray as xr

    dims = ("start", "value")
    grid = {name: array.reshape(*shape, *array.shape[1:]) for name, array in found.items()}
    variables: dict[str, Any] = {}
    own = state_outputs(system)
    for output, (dim, _) in own.items():
        units, long_name = VARIABLES[output].described(system.model)
        attrs = {"units": units, "long_name": long_name}
        variables[output] = ((*dims, "crossing", dim), grid[output], attrs)
    # some sections and mechanisms have no phase or direction
    touches = {name: grid[name] for name in TOUCHES if name in grid}
    touches = {name: values for name, values in touches.items() if np.isfinite(values).any()}
    variables |= touch_variables(touches, str(attributes["section"]), (*dims, "crossing"))
    if exponent:
        for name, text in (
            ("exponent", "largest Lyapunov exponent"),
            ("error", "its standard error"),
        ):
            variables[name] = (dims, grid[name], {"units": "1/s", "long_name": text})
    if links(system.model):
        contact = {name: grid[name] for name in CONTACT}
        variables |= contact_variables(contact, longest(grid["interval"]), dims)
    variables["outcome"] = (dims, grid["outcome"], CODES)
    variables["reason"] = (dims, reasons(grid))
    variables["warning"] = (dims, grid["warning"].astype(object))
    attrs = {"units": "s", "long_name": "time at which the motion stopped"}
    variables["stop_time"] = (dims, grid["stop_time"], attrs)
    members = {dim: np.array(elements, dtype=object) for dim, elements in own.values()}
    return xr.Dataset(variables, {**varied, **members}, attributes)
