"""Touches of journals and bearings: when within a period, in which direction, and how fast."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.sections.common_period import NoPeriodError, common_period
from linkages.kernel.system import System
from linkages.solution.moving.evaluation import evaluate_nodes
from linkages.solution.moving.motion import Motion
from linkages.solution.values.series import Series, system_series
from linkages.solution.values.surface import Surface

Floats = NDArray[np.float64]

TOUCH = "touch"
"""Dimension of what is known of touches: the clearance."""

VARIABLES = {
    "touch_phase": ("", "part of the period of the drives"),
    "touch_direction": ("rad", "direction of the touch, from the bearing's or journal's centre"),
    "touch_rate": ("m/s", "rate of the indentation"),
}
"""Name → unit and what it is, over crossings and clearances."""


def touch_values(system: System, motion: Motion, surface: Surface) -> dict[str, Floats]:
    """What is known of touches, shape (crossings, 1) each; nothing of other sections.

    Without a common period of the drives there is no phase, without an offset no direction.
    """
    if not surface.touch:
        return {}
    known = system_series(system)

    def along(quantity: str) -> Floats | None:
        series = known.get(f"{surface.touch}.{quantity}")
        return None if series is None else _values(motion, series)

    rate, x, y = along("indentation rate"), along("x offset"), along("y offset")
    found = {
        "touch_phase": _phase(system, motion),
        "touch_direction": None if x is None or y is None else np.arctan2(y, x),
        "touch_rate": rate,
    }
    return {name: values[:, None] for name, values in found.items() if values is not None}


def touch_variables(
    values: Mapping[str, Floats], section: str, dims: tuple[str, ...] = ("crossing",)
) -> dict[str, Any]:
    """Those of `values` that are about touches, as variables of a dataset.

    Parameters
    ----------
    values
        Arrays over `dims`, then one clearance.
    section
        What was asked for, such as ``gap.touch``.
    """
    import xarray as xr

    name = section.strip().rpartition(".")[0]
    return {
        variable: xr.DataArray(
            values[variable],
            dims=(*dims, TOUCH),
            coords={TOUCH: np.array([name], dtype=object)},
            attrs={"units": unit, "long_name": text},
        )
        for variable, (unit, text) in VARIABLES.items()
        if variable in values
    }


def _values(motion: Motion, series: Series) -> Floats:
    parts = [evaluate_nodes(p, [series.node(p.system.model)])[0] for p in motion.pieces]
    return np.concatenate(parts)


def _phase(system: System, motion: Motion) -> Floats | None:
    try:
        period = common_period(system.mechanism)
    except NoPeriodError:
        return None
    return np.asarray(motion.time / period % 1.0)
