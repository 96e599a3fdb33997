"""Outputs over time.

Those of sliders, drives and clearances are figures 3–9 of the paper.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.outputs import VARIABLES
from linkages.plots.motion import overlay
from linkages.plots.motion.compared import Compared, Curve
from linkages.plots.motion.curves import STEADY, CurvePeak, beyond, peak_of, worst_of
from linkages.plots.motion.overlay import Group, dense
from linkages.plots.style import figure_of, styled
from linkages.solution.extremes import even
from linkages.solution.series import PIN, REACTION, TIME

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

MOST_LINES = 8  # in one panel: more can not be told apart
POLE = 12.0  # medians beyond which a value that may be infinite is not drawn
FORCE = "drive_force"  # efforts of drives that push: torques and forces have no common axis
WORST = ("transmission_angle",)
"""Angles that are bad near 0 and 180°; the peaks of others that count turns say nothing."""


def efforts(data: xr.Dataset, mechanism: Mechanism, variable: str) -> xr.Dataset:
    """Data with the efforts of one kind of drives."""
    if "drive_effort" not in data:
        return data
    sliding, known = variable == FORCE, {*mechanism.bodies, *mechanism.actuations}
    pushes = [n in known and not mechanism.twisting(n) for n in data["drive"].values]
    names = [n for n, push in zip(data["drive"].values, pushes, strict=True) if push == sliding]
    chosen = data.sel(drive=names)
    words = {"units": "N", "long_name": "driving force"} if sliding else {"units": "N m"}
    effort = chosen["drive_effort"].assign_attrs(words)
    return chosen.drop_vars("drive_effort").assign({variable: effort})


def varying(data: xr.Dataset, _: Mechanism, variable: str) -> xr.Dataset:
    """Data with the elements of a variable that are not the same at all times."""
    if variable not in data:
        return data
    values = data[variable]
    spread = values.max("time") - values.min("time") if values.sizes["time"] else values.sum("time")
    return data.isel({str(values.dims[1]): np.flatnonzero(spread)})


def telling(data: xr.Dataset, _: Mechanism, variable: str) -> xr.Dataset:
    """Data without bars that turn steadily, as cranks do, where there are others."""
    if variable not in data or data.sizes["time"] < 3:
        return data
    array = data[variable].transpose("time", ...)
    values = np.asarray(array, dtype=float)
    changes = np.diff(values, axis=0) if VARIABLES[variable].angle else values
    kept = np.flatnonzero(np.ptp(changes, axis=0) > STEADY * np.abs(changes).max(axis=0))
    return data.isel({str(array.dims[1]): kept}) if kept.size else data


def at_pins(data: xr.Dataset, _: Mechanism | None = None, variable: str = REACTION) -> xr.Dataset:
    """Reactions of joints; where three bodies or more meet, that of the body with the largest."""
    if variable != REACTION or not {REACTION, PIN} <= {*map(str, data)} or not data.sizes["time"]:
        return data
    reaction, pins = (data[name].transpose("time", ..., "axis") for name in (REACTION, PIN))
    sizes = np.linalg.norm(pins, axis=-1).max(axis=0)
    largest = {  # the last one for a joint is kept
        str(data["pin"].values[k]).rpartition(".")[0]: k for k in np.argsort(sizes)
    }
    joints = [str(name) for name in data["joint"].values]
    shown = reaction.to_numpy().copy()
    for joint, k in largest.items():
        shown[:, joints.index(joint)] = pins[:, k]
    names = [str(data["pin"].values[largest[j]]) if j in largest else j for j in joints]
    result = reaction.copy(data=shown).assign_coords(joint=np.array(names, dtype=object))
    return result.to_dataset(name=REACTION).assign_attrs(data.attrs)


SHOWN: Mapping[str, Callable[[xr.Dataset, Mechanism, str], xr.Dataset]] = {
    "drive_effort": efforts, FORCE: efforts, "load_force": varying, "load_torque": varying,
    REACTION: at_pins, "bar_angle": telling, "bar_speed": telling,
}  # fmt: skip
"""Variable → the data that its figure shows, of those whose figure does not show all."""


def drawable(variable: str) -> bool:
    """Whether a variable has a figure over time: numbers, or vectors with a magnitude."""
    if variable == FORCE:
        return True
    result = VARIABLES[variable]
    return not result.flags and (result.magnitude or "axis" not in result.dims)


def time_figure(variable: str) -> Callable[[xr.Dataset, Mechanism], Figure | None]:
    """The function that makes the figure of a variable over time.

    It returns None for data without the variable or without samples, and where it has nothing to
    show: of loads those that vary.
    """

    @styled
    def draw_figure(data: xr.Dataset, mechanism: Mechanism) -> Figure | None:
        chosen = SHOWN[variable](data, mechanism, variable) if variable in SHOWN else data
        if variable not in chosen or chosen[variable].size == 0:
            return None
        return figure_of(overlay.draw_page(groups_of(chosen, variable, mechanism.name)))

    return draw_figure


def lines_of(data: xr.Dataset, variable: str, heading: str = "") -> Compared:
    """The series of a variable over time with their peaks; equal ones are one line.

    `data`: SI units, named in ``attrs["units"]``; equally spaced samples. A variable may say where
    its series are farthest from zero: ``attrs["farthest"]``, name → value and time.
    `variable`: what is drawn; of vectors the magnitudes.
    """
    array, item = data[variable].transpose("time", ...), VARIABLES.get(variable)
    time, values = np.asarray(data["time"], dtype=float), np.asarray(array, dtype=float)
    dims = [str(dim) for dim in array.dims[1:]]
    if "axis" in dims:
        values, dims = np.hypot.reduce(values, axis=-1), dims[:-1]
    names = [", ".join(n) for n in product(*([str(n) for n in data[d].values] for d in dims))]
    values = values.reshape(len(time), len(names))
    if item is not None and item.reciprocal:
        values = without_poles(values)
    alike: dict[int, list[str]] = {}
    for k, name in enumerate(names):
        alike.setdefault(_first_like(values, k), []).append(name)
    known: Mapping[str, tuple[float, float]] = array.attrs.get("farthest", {})
    smooth = (item is None or item.smooth) and even(time)
    horizon = data.attrs.get("horizon")

    def peak(name: str, column: Array) -> CurvePeak | None:
        if item is not None and (item.reciprocal or item.angle):
            return None
        if variable in WORST:
            return worst_of(time, column, horizon)
        if name in known:
            value, at = known[name]
            return CurvePeak(at, value, beyond(at, horizon))
        return peak_of(time, column, horizon, smooth=smooth)

    label = str(array.attrs.get("long_name", item.long_name if item else variable))
    units = str(array.attrs.get("units", ""))
    curves = [
        Curve(
            "", ", ".join(words), label, units, time, time, values[:, k],
            peak=peak(names[k], values[:, k]),
        )
        for k, words in alike.items()
    ]  # fmt: skip
    return Compared(tuple(curves), TIME, "s", heading, label, horizon)


def groups_of(data: xr.Dataset, variable: str, heading: str = "") -> list[Group]:
    """Lines that share a panel: a dense one has its own, and angles of what turns round."""
    found, item = lines_of(data, variable, heading), VARIABLES.get(variable)
    every, angle = found.curves, item is not None and item.angle
    apart = [k for k, curve in enumerate(every) if dense(curve)]
    turning = [k for k, curve in enumerate(every) if angle and np.ptp(curve.y) > 2 * np.pi]
    parts = [
        [k for k in range(len(every)) if k not in apart and (k in turning) == turns]
        for turns in (False, True)
    ]
    smooth = [p[k : k + MOST_LINES] for p in parts for k in range(0, len(p), MOST_LINES)]
    return [*((found, k, False) for k in smooth), *((found, [k], True) for k in apart)]


def _first_like(values: Array, k: int) -> int:
    """The first column that is the same but for round-off."""
    least = STEADY * np.abs(np.nan_to_num(values[:, k])).max(initial=0.0)
    apart = np.abs(values[:, : k + 1] - values[:, k : k + 1])
    return int(np.argmax((np.nan_to_num(apart, nan=0.0) <= least).all(axis=0)))


def without_poles(values: Array) -> Array:
    """Values without those near poles, which would hide all others, shape (samples, series)."""
    sizes = np.abs(np.where(np.isfinite(values), values, np.nan))
    most = POLE * np.nanmedian(sizes) if np.isfinite(sizes).any() else np.inf
    return np.where(sizes <= most, values, np.nan)


def draw(ax: Axes, data: xr.Dataset, variable: str, heading: str = "") -> Axes:
    """Draw a variable over time, a line for each element; parameters as those of `lines_of`.

    `heading`: stands before the name of a single line in the title, or over the legend.
    """
    return overlay.draw(ax, lines_of(data, variable, heading))


POLAR = ("joint_reaction", "shaking_force")  # vectors whose direction matters as much as their size
MOST = 12  # diagrams in one figure


def polar_of(variable: str) -> Callable[[xr.Dataset, Mechanism], Figure | None]:
    """The function that makes polar diagrams of a vector, one for each joint; None without data."""

    @styled
    def draw_figure(data: xr.Dataset, _: Mechanism) -> Figure | None:
        if variable not in data or not data[variable].size:
            return None
        data = at_pins(data, variable=variable)
        names = moving_vectors(data, variable)[:MOST]
        return (
            overlay.polar_figure([tips(data, variable, name) for name in names]) if names else None
        )

    return draw_figure


def moving_vectors(data: xr.Dataset, variable: str) -> list[str]:
    """Elements whose vector is not zero all the time."""
    array = data[variable].transpose("time", ..., "axis")
    sizes = np.abs(np.asarray(array, dtype=float)).max(axis=(0, 2), initial=0.0)
    return [str(n) for n, size in zip(data[array.dims[1]].values, sizes, strict=True) if size > 0]


def tips(data: xr.Dataset, variable: str, name: str) -> Compared:
    """The tip of the vector of an element, as data have it."""
    array = data[variable].transpose("time", ..., "axis")
    x, y = np.asarray(array.sel({str(array.dims[1]): name}), dtype=float).T
    words = str(array.attrs.get("long_name", VARIABLES[variable].long_name))
    sizes, units = np.hypot(x, y), str(array.attrs.get("units", ""))
    known = float(np.nanmax(sizes)) if np.isfinite(sizes).any() else np.nan
    most, _ = array.attrs.get("farthest", {}).get(name, (known, 0.0))
    time = data[TIME].to_numpy().astype(float)
    curve = Curve("", name, words, units, time, x, y, 0.0, most)
    return Compared((curve,), f"{words}, x", units, str(data.attrs.get("name", "")))
