"""Bifurcation diagrams and maps as labelled arrays."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.contact_log import (
    CONTACT,
    TOUCH,
    LinkForce,
    contact_values,
    contact_variables,
    touch_variables,
)
from linkages.chaos.contact_log import VARIABLES as TOUCHES
from linkages.chaos.continuation import Visited
from linkages.chaos.free_states import state_outputs
from linkages.chaos.periods import renamed
from linkages.errors import ComputationError
from linkages.kernel.outputs import VARIABLES, links
from linkages.kernel.system import System
from linkages.solution.guards import parse_section
from linkages.sweeps.engine import Answer, Computed, Field, marks, stop_code
from linkages.sweeps.running import reason_of

if TYPE_CHECKING:
    import xarray as xr

INDICATORS = {
    "exponent": ("largest Lyapunov exponent", "1/s"),
    "fli": ("fast Lyapunov indicator", ""),
    "gali": ("generalised alignment index", ""),
}


def free_names_of_angles(system: System) -> list[str]:
    """Free coordinates that are angles."""
    bodies = system.mechanism.bodies
    return [name for name in system.topology.free if bodies[name].rotates]


def map_fields(system: System) -> dict[str, Field]:
    """What is found at a point: an indicator, its error and its sign, 0 if it cannot be told; what
    each free angle does; touches of contacts; forces in clearances, and the time between two looks
    at them.
    """  # noqa: D205
    clearances = (len(links(system.model)),)
    touching = {"touches": Field(shape=(len(names),))} if (names := touchable(system)) else {}
    return {
        **touching,
        "indicator": Field(), "error": Field(), "sign": Field("i1"), "interval": Field(),
        "rotation": Field("U", (len(free_names_of_angles(system)),)),
        **{name: Field(shape=clearances) for name in CONTACT},
    }  # fmt: skip


def touchable(system: System) -> list[str]:
    """Names of what may touch: journals and bearings, blocks and guides, bodies and their stops."""
    mechanism = system.mechanism
    return [about.name for about in mechanism.contacts] + [about.name for about in mechanism.ends]


def free_angles(
    system: System, kinds: Mapping[str, str], contacts: Sequence[LinkForce]
) -> dict[str, Any]:
    """What each free angle does, and forces in clearances, as `map_fields` has them."""
    names = links(system.model)
    rotation = [kinds.get(name, "") for name in free_names_of_angles(system)]
    return {"rotation": rotation, **contact_values(contacts, names)}


def map_data(
    first: System,
    shape: tuple[int, ...],
    indicator: str,
    varied: Mapping[str, Any],
    attributes: Mapping[str, Any],
    result: Computed,
) -> xr.Dataset:
    """Arrays with nan where nothing was found.

    `shape`: numbers of rows and of columns.
    """
    import xarray as xr

    words, units = INDICATORS[indicator]
    grid = {n: array.reshape(*shape, *array.shape[1:]) for n, array in result.arrays.items()}
    variables: dict[str, Any] = {
        "indicator": (("y", "x"), grid["indicator"], {"units": units, "long_name": words}),
        "rotation": (("y", "x", "coordinate"), renamed(grid["rotation"].astype(object))),
        **marks(result.arrays, ("y", "x"), shape),
    }
    if indicator == "exponent":
        error = {"units": units, "long_name": "standard error"}
        sign = {"long_name": "sign of the exponent, 0 where it cannot be told from zero"}
        variables["error"] = (("y", "x"), grid["error"], error)
        variables["sign"] = (("y", "x"), grid["sign"], sign)
    members = {"coordinate": np.array(free_names_of_angles(first), dtype=object)}
    if "touches" in grid:
        attrs = {"units": "1", "long_name": "touches per period"}
        variables["touches"] = (("y", "x", TOUCH), grid["touches"], attrs)
        members[TOUCH] = np.array(touchable(first), dtype=object)
    if names := links(first.model):
        interval = longest(grid["interval"])
        variables |= contact_variables({n: grid[n] for n in CONTACT}, interval, ("y", "x"))
        members["clearance"] = np.array(names, dtype=object)
    about = {**attributes, "interrupted": int(result.interrupted)}
    return xr.Dataset(variables, {**varied, **members}, about)


def longest(intervals: NDArray[np.float64]) -> float:
    """The longest interval between two looks; nan if there was none."""
    known = intervals[np.isfinite(intervals)]
    return float(known.max()) if known.size else math.nan


Floats = NDArray[np.float64]

NOTHING = (np.nan, np.nan)

BOTH = "both"
"""Forward, and backward."""


@dataclass(frozen=True, eq=False)
class Value:
    """What was found at a value of what is varied."""

    visited: Visited  # points of the section
    exponent: tuple[float, float] = NOTHING  # the largest exponent and its error
    refusal: ComputationError | None = None  # why something of it is missing


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
    result: dict[str, Any] = {
        name: array if name in CONTACT else _padded(array, points)
        for name, array in visited.values.items()
    }
    result |= {"exponent": exponent, "error": error}
    result |= {"warning": visited.warning, "interval": visited.interval}
    if value.refusal is None:
        return Answer(result)
    refusal = value.refusal
    return Answer(result, stop_code(refusal), reason_of(refusal), refusal.time)


def _padded(rows: Floats, points: int) -> Floats:
    result = np.full((points, *rows.shape[1:]), np.nan)
    result[: len(rows)] = rows
    return result


def ways(start: str) -> tuple[str, ...]:
    """How diagrams are gone through, one after the other."""
    return ("forward", "backward") if start == BOTH else (start,)


def put_together(
    parts: Sequence[xr.Dataset], start: str, states: Sequence[Mapping[str, object]]
) -> xr.Dataset:
    """Diagrams of one way or of both as one, whose starts have names."""
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
    shape: tuple[int, int],
    exponent: bool,
    varied: Mapping[str, Any],
    attributes: Mapping[str, Any],
    result: Computed,
) -> xr.Dataset:
    """Points of sections over what is varied, as labelled arrays.

    `shape`: numbers of starts and of values.
    """
    import xarray as xr

    dims = ("start", "value")
    grid = {n: array.reshape(*shape, *array.shape[1:]) for n, array in result.arrays.items()}
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
    variables |= marks(result.arrays, dims, shape)
    variables["warning"] = (dims, grid["warning"].astype(object))
    members = {dim: np.array(elements, dtype=object) for dim, elements in own.values()}
    about = {**attributes, "interrupted": int(result.interrupted)}
    return xr.Dataset(variables, {**varied, **members}, about)
