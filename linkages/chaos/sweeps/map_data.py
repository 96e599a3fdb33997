"""Maps as labelled arrays."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.sections.contact import Contact
from linkages.chaos.sections.contact_log import CONTACT, contact_values, contact_variables
from linkages.kernel.outputs import links
from linkages.kernel.system import System
from linkages.sweeps.running import Swept

if TYPE_CHECKING:
    import xarray as xr

INDICATORS = {
    "exponent": ("largest Lyapunov exponent", "1/s"),
    "fli": ("fast Lyapunov indicator", ""),
    "gali": ("generalised alignment index", ""),
}


@dataclass(frozen=True, eq=False)
class MapPoint:
    """What was found at a point.

    Parameters
    ----------
    indicator, error, sign
        Its value, and of an exponent the standard error and the sign, 0 if it cannot be told.
    kinds
        What each free angle does.
    contacts, interval
        Forces in clearances, and the time between two looks at them.
    """

    indicator: float
    error: float
    sign: int
    kinds: Mapping[str, str]
    contacts: tuple[Contact, ...]
    interval: float


def map_data(
    first: System,
    swept: Swept,
    shape: tuple[int, int],
    indicator: str,
    varied: Mapping[str, Any],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """Arrays with nan where nothing was found.

    Parameters
    ----------
    first
        The mechanism at one of the points.
    swept
        Outcomes with a `MapPoint`, row by row.
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

    found: list[MapPoint | None] = [None if o is None else o.value for o in swept.outcomes]

    def grid(values: Sequence[Any], dtype: Any = float) -> NDArray[Any]:
        return np.array(values, dtype=dtype).reshape(shape)

    bodies = first.mechanism.bodies
    angles = [name for name in first.topology.free if bodies[name].rotates]
    kinds = np.empty((len(found), len(angles)), dtype=object)
    for row, point in zip(kinds, found, strict=True):
        row[:] = ["" if point is None else point.kinds.get(name, "") for name in angles]
    words, units = INDICATORS[indicator]
    values = grid([math.nan if point is None else point.indicator for point in found])
    stopped = {"units": "s", "long_name": "time at which the motion stopped"}
    variables: dict[str, Any] = {
        "indicator": (("y", "x"), values, {"units": units, "long_name": words}),
        "rotation": (("y", "x", "coordinate"), kinds.reshape(*shape, len(angles))),
        "reason": (("y", "x"), grid(swept.reasons, object)),
        "stop_time": (("y", "x"), grid(swept.stop_times), stopped),
    }
    if indicator == "exponent":
        errors = grid([math.nan if point is None else point.error for point in found])
        signs = grid([0 if point is None else point.sign for point in found], np.int8)
        error = {"units": units, "long_name": "standard error"}
        sign = {"long_name": "sign of the exponent, 0 where it cannot be told from zero"}
        variables |= {"error": (("y", "x"), errors, error), "sign": (("y", "x"), signs, sign)}
    members = {"coordinate": np.array(angles, dtype=object)}
    if names := links(first.model):
        variables |= _contact(names, found, shape)
        members["clearance"] = np.array(names, dtype=object)
    return xr.Dataset(variables, {**varied, **members}, attributes)


def _contact(
    names: Sequence[str], found: Sequence[MapPoint | None], shape: tuple[int, int]
) -> dict[str, Any]:
    pairs = [contact_values(() if point is None else point.contacts, names) for point in found]
    arrays = {name: np.reshape([pair[name] for pair in pairs], (*shape, -1)) for name in CONTACT}
    interval = max((point.interval for point in found if point is not None), default=math.nan)
    return contact_variables(arrays, interval, ("y", "x"))
