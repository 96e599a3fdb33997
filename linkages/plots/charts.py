"""Every figure by name, drawn into given axes or into a figure of its own.

Each function returns the matplotlib axes that it drew into: more can be drawn there, and
``chart.figure.savefig("name.pdf")`` writes them. Nothing uses pyplot; in a notebook, show
``chart.figure``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from matplotlib.axes import Axes

from linkages.plots.chaos import bifurcations, sections
from linkages.plots.chaos import exponents as exponent_histories
from linkages.plots.chaos import maps as chaos_maps
from linkages.plots.mechanism import drawing
from linkages.plots.mechanism import traces as joint_traces
from linkages.plots.mechanism.samples import pose_at
from linkages.plots.mechanism.view import picture
from linkages.plots.motion import clearance_orbit as orbits
from linkages.plots.motion import phase, time_figures
from linkages.plots.motion.free_axes import Free, free_coordinates
from linkages.plots.style import panels, styled
from linkages.solution.resolved import resolved
from linkages.solution.solution import Solution
from linkages.solution.values.series import data_series, find_series

if TYPE_CHECKING:
    import xarray as xr

    Source = Solution | xr.Dataset

__all__ = [
    "bifurcation",
    "clearance_force",
    "clearance_orbit",
    "clearance_state",
    "drive_effort",
    "drive_force",
    "exponents",
    "indicator_map",
    "load_force",
    "load_torque",
    "mechanism",
    "pair",
    "phase_diagram",
    "rotation_map",
    "section",
    "slider_acceleration",
    "slider_acceleration_error",
    "slider_position",
    "slider_position_error",
    "slider_velocity",
    "slider_velocity_error",
    "traces",
]

SINGLE = 3.6  # inches: height of a picture that stands alone


@styled
def mechanism(
    solution: Solution, ax: Axes | None = None, *, time: float = 0.0, dimensions: bool = False
) -> Axes:
    """The mechanism at the sample nearest to a time in seconds, with all names.

    Parameters
    ----------
    solution
        With ``joint_position``.
    ax
        Where to draw; axes of a new figure if not given.
    time
        In seconds.
    dimensions
        Whether to write lengths of bars and of sides of plates, and to mark centres of mass.

    Raises
    ------
    ValueError
        For data without joint positions; so do all other functions if theirs are missing.
    """
    data = solution.data
    _require(data, "joint_position")
    index = int(np.argmin(np.abs(np.asarray(data["time"], dtype=float) - time)))
    pose = pose_at(data, solution.mechanism, index)
    ax = ax or picture(drawing.reach(pose))[1]
    return drawing.draw_pose(ax, pose, dimensions=dimensions)


@styled
def traces(solution: Solution, ax: Axes | None = None) -> Axes:
    """The paths of all moving joints over the mechanism where it starts."""
    data = solution.data
    _require(data, "joint_position")
    if ax is None:
        ax = picture(drawing.framed(data, solution.mechanism)[1], joint_traces.MARGIN)[1]
    return joint_traces.draw(ax, data, solution.mechanism)


class Chart(Protocol):
    """Draws a variable over time."""

    def __call__(self, source: Source, ax: Axes | None = None) -> Axes:
        """Into given axes, or into a figure of its own."""


def _chart(variable: str, what: str) -> Chart:
    """The function that draws a variable over time."""

    def chart(source: Source, ax: Axes | None = None) -> Axes:
        return _over_time(source, variable, ax)

    chart.__name__ = chart.__qualname__ = variable
    chart.__doc__ = f"""{what} over time.

    Parameters
    ----------
    source
        A solution, or its data.
    ax
        Where to draw; axes of a new figure if not given.
    """
    return chart


slider_position = _chart("slider_position", "Displacements of the sliders")
slider_velocity = _chart("slider_velocity", "Velocities of the sliders")
slider_acceleration = _chart("slider_acceleration", "Accelerations of the sliders")
slider_position_error = _chart(
    "slider_position_error", "What clearances change of the sliders' displacements,"
)
slider_velocity_error = _chart(
    "slider_velocity_error", "What clearances change of the sliders' velocities,"
)
slider_acceleration_error = _chart(
    "slider_acceleration_error", "What clearances change of the sliders' accelerations,"
)
clearance_force = _chart("clearance_force", "Forces in the clearances")
load_force = _chart("load_force", "Forces of all loads")
load_torque = _chart("load_torque", "Torques of all loads")


@styled
def clearance_orbit(source: Source, name: str | None = None, ax: Axes | None = None) -> Axes:
    """The way of a pin in its hole, where contact may open: of the clearance named, or the first.

    Raises
    ------
    ValueError
        For data without offsets, or an unknown clearance.
    """
    data = _resolved(source, "clearance_offset", orbits.SHOWN)
    chosen = _chosen(name, dict.fromkeys(orbits.opening(data)), "clearance whose contact may open")
    ax = ax or panels(1, 1, SINGLE, orbits.ABOVE)[1][0]
    return orbits.draw_orbit(ax, data.sel(clearance=chosen), chosen)


@styled
def clearance_state(source: Source, ax: Axes | None = None) -> Axes:
    """Free flight, impacts and following contact over time, where contact may open."""
    data = _resolved(source, "clearance_offset", orbits.SHOWN)
    _require(data, "clearance_state")
    if ax is None:
        ax = orbits.state_page(data)
    return orbits.draw_states(ax, data, str(data.attrs.get("name", "")))


def drive_effort(solution: Solution, ax: Axes | None = None) -> Axes:
    """Torques of the drives on bars over time."""
    return _of_drives(solution, "drive_effort", ax)


def drive_force(solution: Solution, ax: Axes | None = None) -> Axes:
    """Forces of the drives on sliders over time."""
    return _of_drives(solution, "drive_force", ax)


def _of_drives(solution: Solution, variable: str, ax: Axes | None) -> Axes:
    _require(solution.data, "drive_effort")
    data = _resolved(solution, "drive_effort")
    chosen = time_figures.efforts(data, solution.mechanism, variable)
    return _over_time(chosen, variable, ax)


@styled
def phase_diagram(solution: Solution, name: str | None = None, ax: Axes | None = None) -> Axes:
    """Rate against value of a free coordinate: of the one named, or the first."""
    data = solution.data
    found = {c.name: c for c in phase.coordinates(data, solution.mechanism)}
    chosen = found[_chosen(name, found)]
    return phase.draw(ax or panels(1, 1, SINGLE)[1][0], data, chosen, solution.mechanism.name)


@styled
def pair(source: Source, x: str, y: str, ax: Axes | None = None, *, wrap: bool = True) -> Axes:
    """One output against another, such as ``"r1.angle"`` and ``"slider9.velocity"``.

    Parameters
    ----------
    source
        A solution, or its data.
    x, y
        Names of series: an element and a quantity, or an output that has no elements.
    ax
        Where to draw; axes of a new figure if not given.
    wrap
        Whether angles are taken within half a turn either way.
    """
    data = _data(source)
    known = data_series(data)
    across, up = find_series(known, x), find_series(known, y)
    _require(data, across.variable)
    return phase.draw_pair(ax or panels(1, 1, SINGLE)[1][0], data, across, up, wrap)


@styled
def section(data: xr.Dataset, name: str | None = None, ax: Axes | None = None) -> Axes:
    """Points of `linkages.poincare`: of the free coordinate named, or the first."""
    chosen = _free(data, name)
    heading = str(data.attrs.get("name", ""))
    return sections.draw(ax or panels(1, 1, SINGLE)[1][0], data, chosen, heading)


@styled
def exponents(data: xr.Dataset, ax: Axes | None = None) -> Axes:
    """How the exponents of `linkages.lyapunov` settle over time."""
    if ax is None:
        ax = exponent_histories.page(data)
    return exponent_histories.draw(ax, data, str(data.attrs.get("name", "")))


@styled
def bifurcation(
    data: xr.Dataset, name: str | None = None, ax: Axes | None = None, *, rates: bool = False
) -> Axes:
    """Points of `linkages.bifurcation` over the parameter: of the coordinate named, or the first.

    Parameters
    ----------
    data
        As `linkages.bifurcation` returns it.
    name
        Of a free coordinate.
    ax
        Where to draw; axes of a new figure if not given.
    rates
        Whether to draw its rate instead of its value.
    """
    chosen = _free(data, name)
    ax = bifurcations.draw(ax or panels(1, 1, SINGLE)[1][0], data, chosen, rates=rates)
    bifurcations.show_parameter(ax, data)
    ax.set_title(str(data.attrs.get("name", "")))
    return ax


@styled
def indicator_map(data: xr.Dataset, ax: Axes | None = None) -> Axes:
    """The indicator of `linkages.chaos_map`, with a colour bar."""
    if ax is None:
        return chaos_maps.page(data).axes[0]
    chaos_maps.draw(ax, data)
    figure = ax.get_figure(root=True)
    assert figure is not None
    figure.colorbar(ax.collections[0], ax=ax, label=chaos_maps.indicator_label(data))
    return ax


@styled
def rotation_map(data: xr.Dataset, name: str | None = None, ax: Axes | None = None) -> Axes:
    """What a free angle does at each point of `linkages.chaos_map`: the one named, or the first."""
    chosen = _chosen(name, {str(n): n for n in data["coordinate"].values})
    if ax is None:
        return chaos_maps.class_page(data, chosen).axes[0]
    return chaos_maps.draw_classes(ax, data, chosen)


@styled
def _over_time(source: Source, variable: str, ax: Axes | None) -> Axes:
    data = _resolved(source, variable)
    _require(data, variable)
    if ax is None:
        ax = time_figures.page(data, variable)
    return time_figures.draw(ax, data, variable, str(data.attrs.get("name", "")))


def _resolved(source: Source, variable: str, also: Sequence[str] = ()) -> xr.Dataset:
    """Data of a variable; of a solution with samples that show every swing."""
    if not isinstance(source, Solution) or variable not in source.data:
        return _data(source)
    return resolved(source, [variable], also)


def _data(source: Source) -> xr.Dataset:
    found: Any = source
    return found if hasattr(found, "data_vars") else found.data


def _require(data: xr.Dataset, variable: str) -> None:
    if variable not in data or not data[variable].size:
        raise ValueError(f"the data have no {variable}, or no samples of it")


def _free(data: xr.Dataset, name: str | None) -> Free:
    found = {coordinate.name: coordinate for coordinate in free_coordinates(data)}
    return found[_chosen(name, found)]


def _chosen(name: str | None, found: Mapping[str, object], what: str = "free coordinate") -> str:
    if not found:
        raise ValueError(f"the data have no {what}")
    if name is not None and name not in found:
        raise ValueError(f"unknown {what} {name!r}; expected one of: {', '.join(found)}")
    return next(iter(found)) if name is None else name
