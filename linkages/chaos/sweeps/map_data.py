"""Maps as labelled arrays."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.sections.contact import LinkForce
from linkages.chaos.sections.contact_log import CONTACT, contact_values, contact_variables
from linkages.chaos.sections.touches import TOUCH
from linkages.chaos.series.rotation import renamed
from linkages.kernel.outputs import links
from linkages.kernel.system import System
from linkages.sweeps.answers import CODES, Arrays, Field, reasons

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
    found: Arrays,
    shape: tuple[int, ...],
    indicator: str,
    varied: Mapping[str, Any],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """Arrays with nan where nothing was found.

    Parameters
    ----------
    first
        The mechanism at one of the points.
    found
        Values of `map_fields`, row by row.
    shape
        Numbers of rows and of columns.
    indicator
        One of `INDICATORS`.
    varied
        Coordinates of what is varied.
    attributes
        Of the dataset.
    """
    import xarray as xr

    words, units = INDICATORS[indicator]
    grid = {name: array.reshape(*shape, *array.shape[1:]) for name, array in found.items()}
    stopped = {"units": "s", "long_name": "time at which the motion stopped"}
    variables: dict[str, Any] = {
        "indicator": (("y", "x"), grid["indicator"], {"units": units, "long_name": words}),
        "rotation": (("y", "x", "coordinate"), renamed(grid["rotation"].astype(object))),
        "outcome": (("y", "x"), grid["outcome"], CODES),
        "reason": (("y", "x"), reasons(grid)),
        "stop_time": (("y", "x"), grid["stop_time"], stopped),
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
    return xr.Dataset(variables, {**varied, **members}, attributes)


def longest(intervals: NDArray[np.float64]) -> float:
    """The longest interval between two looks; nan if there was none."""
    known = intervals[np.isfinite(intervals)]
    return float(known.max()) if known.size else math.nan
