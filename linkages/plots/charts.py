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

from linkages.kernel.outputs import VARIABLES
from linkages.plots.chaos import period_figures
from linkages.plots.chaos.chaos_figures import draw_exponents, exponent_page
from linkages.plots.chaos.diagrams import (
    class_page,
    draw_bifurcation,
    draw_classes,
    draw_map,
    indicator_label,
    page,
    show_parameter,
)
from linkages.plots.chaos.orbit_figures import (
    branch_figure,
    coordinates_of,
    draw_branches,
    draw_multipliers,
    draw_portrait,
    multiplier_figure,
)
from linkages.plots.chaos.section_figures import draw_section
from linkages.plots.mechanism import drawing
from linkages.plots.mechanism.plane_view import picture
from linkages.plots.mechanism.pose import pose_at
from linkages.plots.mechanism.traces import draw
from linkages.plots.motion import overlay, time_figures
from linkages.plots.motion import phase_diagrams as phase
from linkages.plots.motion.clearance_orbit import (
    ABOVE,
    SHOWN,
    draw_orbit,
    draw_states,
    holes,
    state_page,
)
from linkages.plots.motion.compared import compared, told_apart
from linkages.plots.motion.compared import vectors as compared_vectors
from linkages.plots.motion.equilibrium_figures import (
    bode_figure,
    draw_equilibria,
    position_figure,
)
from linkages.plots.motion.phase_diagrams import Free, free_coordinates
from linkages.plots.motion.wear_figures import draw_depth, draw_life, draw_profile, draw_size
from linkages.plots.style import panels, styled
from linkages.solution.series import (
    AT_JOINTS,
    REACTION,
    available,
    data_series,
    find_series,
    with_sizes,
)
from linkages.solution.solution import Solution

if TYPE_CHECKING:
    import xarray as xr

    from linkages.components.mechanisms.mechanism import Mechanism

    Source = Solution | xr.Dataset

__all__ = [
    "bar_acceleration",
    "bar_angle",
    "bar_speed",
    "bifurcation",
    "bode",
    "branches",
    "clearance_force",
    "clearance_orbit",
    "clearance_state",
    "drive_effort",
    "drive_force",
    "equilibria",
    "exponents",
    "indicator_map",
    "joint_acceleration",
    "joint_reaction",
    "joint_velocity",
    "kinetic_energy",
    "life",
    "load_force",
    "load_torque",
    "mechanical_advantage",
    "mechanism",
    "multipliers",
    "orbit",
    "over_time",
    "pair",
    "period_map",
    "phase_diagram",
    "plot",
    "polar",
    "potential_energy",
    "pressure_angle",
    "rotation_map",
    "section",
    "shaking_force",
    "shaking_moment",
    "slider_acceleration",
    "slider_acceleration_error",
    "slider_mechanical_advantage",
    "slider_position",
    "slider_position_error",
    "slider_velocity",
    "slider_velocity_error",
    "spring_force",
    "torsional_spring_torque",
    "traces",
    "transmission_angle",
    "vectors",
    "wear",
    "wear_depth",
    "wear_profile",
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
        Whether to write lengths of bars, of sides of plates and of the ground's frame, and to mark
        centres of mass.

    Raises
    ------
    ValueError
        For data without joint positions; so do all other functions if theirs are missing.
    """
    data = solution.data
    _require(data, "joint_position")
    index = int(np.argmin(np.abs(np.asarray(data["time"], dtype=float) - time)))
    pose = pose_at(data, solution.mechanism, index)
    ax = ax or picture(drawing.reach(pose, dimensions=dimensions))[1]
    return drawing.draw_pose(ax, pose, dimensions=dimensions)


@styled
def traces(solution: Solution, ax: Axes | None = None) -> Axes:
    """The paths of all moving joints over the mechanism where it starts."""
    data = solution.data
    _require(data, "joint_position")
    if ax is None:
        ax = picture(drawing.framed(data, solution.mechanism)[1])[1]
    return draw(ax, data, solution.mechanism)


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


bar_angle = _chart("bar_angle", "Angles of the bars")
bar_speed = _chart("bar_speed", "Angular speeds of the bars")
bar_acceleration = _chart("bar_acceleration", "Angular accelerations of the bars")
slider_position = _chart("slider_position", "Positions of the sliders")
slider_velocity = _chart("slider_velocity", "Velocities of the sliders")
slider_acceleration = _chart("slider_acceleration", "Accelerations of the sliders")
slider_position_error = _chart(
    "slider_position_error", "What clearances change of the sliders' positions,"
)
slider_velocity_error = _chart(
    "slider_velocity_error", "What clearances change of the sliders' velocities,"
)
slider_acceleration_error = _chart(
    "slider_acceleration_error", "What clearances change of the sliders' accelerations,"
)
joint_velocity = _chart("joint_velocity", "Speeds of the joints")
joint_acceleration = _chart("joint_acceleration", "Sizes of the joints' accelerations")
joint_reaction = _chart("joint_reaction", "Resultant reactions of the joints")
transmission_angle = _chart("transmission_angle", "Transmission angles of the dyads")
pressure_angle = _chart("pressure_angle", "Pressure angles of the cams")
mechanical_advantage = _chart("mechanical_advantage", "Mechanical advantages of the bars")
slider_mechanical_advantage = _chart(
    "slider_mechanical_advantage", "Mechanical advantages of the sliders"
)
shaking_force = _chart("shaking_force", "Size of the shaking force")
shaking_moment = _chart("shaking_moment", "Shaking moment")
kinetic_energy = _chart("kinetic_energy", "Kinetic energy")
potential_energy = _chart("potential_energy", "Potential energy")
clearance_force = _chart("clearance_force", "Forces in the clearances")
load_force = _chart("load_force", "Forces of all loads")
load_torque = _chart("load_torque", "Torques of all loads")
spring_force = _chart("spring_force", "Forces of springs and dampers")
torsional_spring_torque = _chart(
    "torsional_spring_torque", "Torques of torsional springs and dampers"
)


@styled
def over_time(source: Source, variable: str, ax: Axes | None = None) -> Axes:
    """Any output over time, a line for each element; of vectors their sizes.

    Parameters
    ----------
    source
        A solution, or its data. Of a solution what is not among its outputs is computed, but for
        those that follow from a whole motion.
    variable
        Name of the output. A series that swings faster than lines can show gets an envelope, and
        in a figure of its own a panel with a few swings.
    ax
        Where to draw; axes of a new figure if not given: those of its first panel.

    Raises
    ------
    ValueError
        For data without it.
    """
    return _over_time(source, variable, ax)


@styled
def polar(source: Source, variable: str, name: str | None = None, ax: Axes | None = None) -> Axes:
    """The tip of a vector, such as the reaction of a joint: of the element named, or the first.

    Parameters
    ----------
    source
        A solution, or its data.
    variable
        ``"joint_reaction"``, ``"shaking_force"`` or another output with components x and y.
    name
        The joint; ``"ground"`` of the shaking force.
    ax
        Where to draw; axes of a new figure if not given.
    """
    data = _at_joints(source, variable)
    if "axis" not in data[variable].dims:
        raise ValueError(f"{variable} has no direction; expected an output with components x and y")
    known = dict.fromkeys(phase.vectors(data, variable))
    chosen = _chosen(name, known, f"element of {variable}")
    if ax is None:
        return phase.polar_page(data, variable, [chosen]).axes[0]
    return phase.draw_polar(ax, data, variable, chosen)


@styled
def clearance_orbit(source: Source, name: str | None = None, ax: Axes | None = None) -> Axes:
    """The way of a pin in its hole, where contact may open: of the clearance named, or the first.

    Raises
    ------
    ValueError
        For data without offsets, or an unknown clearance.
    """
    data = _resolved(source, SHOWN)
    chosen = _chosen(name, dict.fromkeys(holes(data)), "clearance whose contact may open")
    ax = ax or panels(1, 1, SINGLE, ABOVE)[1][0]
    return draw_orbit(ax, data.sel(clearance=chosen), chosen)


@styled
def clearance_state(source: Source, ax: Axes | None = None) -> Axes:
    """Free flight, impacts and following contact over time, where contact may open."""
    data = _resolved(source, SHOWN)
    _require(data, "clearance_state")
    if ax is None:
        ax = state_page(data)
    return draw_states(ax, data, str(data.attrs.get("name", "")))


def drive_effort(solution: Solution, ax: Axes | None = None) -> Axes:
    """Torques of the drives on bars over time."""
    return _of_drives(solution, "drive_effort", ax)


def drive_force(solution: Solution, ax: Axes | None = None) -> Axes:
    """Forces of the drives on sliders over time."""
    return _of_drives(solution, "drive_force", ax)


def _of_drives(solution: Solution, variable: str, ax: Axes | None) -> Axes:
    _require(solution.data, "drive_effort")
    data = _resolved(solution, ["drive_effort"])
    chosen = time_figures.efforts(data, solution.mechanism, variable)
    return _over_time(chosen, variable, ax)


@styled
def phase_diagram(solution: Solution, name: str | None = None, ax: Axes | None = None) -> Axes:
    """Rate against value of a free coordinate: of the one named, or the first."""
    data = solution.data
    result = {c.name: c for c in phase.coordinates(data, solution.mechanism)}
    chosen = result[_chosen(name, result)]
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
    known = with_sizes(data_series(data))
    across, up = find_series(known, x), find_series(known, y)
    _require(data, across.variable)
    return phase.draw_pair(ax or panels(1, 1, SINGLE)[1][0], data, across, up, wrap)


@styled
def plot(
    sources: Source | Sequence[Source] | Mapping[str, Source],
    y: str | Sequence[str],
    against: str = "time",
    ax: Axes | None = None,
    *,
    difference: bool = False,
    wrap: bool = False,
) -> Axes:
    """Any series of one motion or of several, over time or over any other series.

    Parameters
    ----------
    sources
        Solutions or their data, several of them by what tells them apart. Those of a list are
        called by what their definitions differ in.
    y
        What to draw: names such as ``"rocker.angle"``, ``"P.velocity"`` for the magnitude of a
        vector, ``"P.x velocity"``, ``"kinetic_energy"``.
    against
        What to draw it over, such as ``"crank.angle"``.
    ax
        Where to draw series of one unit; axes of a new figure if not given, with a panel for each
        unit, of which those of the first are returned.
    difference
        Whether to draw what the others differ in from the first motion.
    wrap
        Whether angles to the right are taken within half a turn either way.

    Raises
    ------
    ValueError
        For unknown names and for what cannot be compared.
    """
    result = compared(_called(sources), _listed(y), against, difference=difference)
    if ax is None:
        return overlay.figure(result, wrap=wrap).axes[0]
    return overlay.draw(ax, result, wrap=wrap)


@styled
def vectors(
    sources: Source | Sequence[Source] | Mapping[str, Source], name: str, ax: Axes | None = None
) -> Axes:
    """A vector of one motion or of several in a polar diagram, such as ``"M.reaction"``."""
    (result,) = compared_vectors(_called(sources), [name])
    if ax is None:
        return overlay.polar_figure([result]).axes[0]
    return overlay.draw_vectors(ax, result)


@styled
def section(data: xr.Dataset, name: str | None = None, ax: Axes | None = None) -> Axes:
    """Points of `linkages.poincare`: of the free coordinate named, or the first."""
    chosen = _free(data, name)
    heading = str(data.attrs.get("name", ""))
    return draw_section(ax or panels(1, 1, SINGLE)[1][0], data, chosen, heading)


@styled
def exponents(data: xr.Dataset, ax: Axes | None = None) -> Axes:
    """How the exponents of `linkages.lyapunov` settle over time."""
    if ax is None:
        ax = exponent_page(data)
    return draw_exponents(ax, data, str(data.attrs.get("name", "")))


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
    ax = draw_bifurcation(ax or panels(1, 1, SINGLE)[1][0], data, chosen, rates=rates)
    show_parameter(ax, data)
    ax.set_title(str(data.attrs.get("name", "")))
    return ax


@styled
def orbit(data: xr.Dataset, name: str | None = None, ax: Axes | None = None) -> Axes:
    """Phase portrait of `linkages.orbit`, of one orbit: of the coordinate named, or the first.

    Parameters
    ----------
    data
        As `linkages.orbit` returns it from one start.
    name
        Of a coordinate, such as ``rod.angle``.
    ax
        Where to draw; axes of a new figure if not given.
    """
    known = [str(each) for each in data["coordinate"].values[: coordinates_of(data)]]
    index = known.index(_chosen(name, dict.fromkeys(known), "coordinate"))
    ax = draw_portrait(ax or panels(1, 1, SINGLE)[1][0], data, index)
    ax.set_title(str(data.attrs.get("name", "")))
    return ax


@styled
def equilibria(data: xr.Dataset, mechanism: Mechanism, ax: Axes | None = None) -> Axes:
    """All positions of rest over each other, stable ones in full colours.

    Parameters
    ----------
    data
        As `linkages.equilibrium` returns it.
    mechanism
        What rests there.
    ax
        Where to draw; axes of a new figure if not given.
    """
    if ax is None:
        return position_figure(data, mechanism).axes[0]
    return draw_equilibria(ax, data, mechanism)


@styled
def bode(data: xr.Dataset, number: int = 1) -> Axes:
    """Frequency response of one of `linkages.equilibrium`, magnitudes above and phases below."""
    return bode_figure(data, number).axes[0]


@styled
def wear(data: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Radial clearances of `linkages.wear` over revolutions, with bands of their errors."""
    return draw_size(ax or panels(1, 1, SINGLE)[1][0], data)


@styled
def wear_depth(
    data: xr.Dataset, name: str | None = None, side: str = "bearing", ax: Axes | None = None
) -> Axes:
    """Depth around a journal or a bearing at the end of `linkages.wear`.

    Parameters
    ----------
    data
        As `linkages.wear` returns it.
    name
        The clearance; the first one if not given.
    side
        ``journal`` or ``bearing``.
    ax
        Where to draw; axes of a new figure if not given.
    """
    known = [str(each) for each in data["clearance"].values]
    own = data.sel(clearance=_chosen(name, dict.fromkeys(known), "clearance"))
    return draw_depth(ax or panels(1, 1, SINGLE)[1][0], own, side)


@styled
def wear_profile(data: xr.Dataset, name: str | None = None, ax: Axes | None = None) -> Axes:
    """A bearing that wears out of round, over the revolutions of `linkages.wear`.

    Parameters
    ----------
    data
        As `linkages.wear` returns it with ``feedback="profile"``.
    name
        The clearance; the first one if not given.
    ax
        Where to draw; axes of a new figure if not given.
    """
    if "profile" not in data:
        raise ValueError("bearings stay round here; expected wear with feedback='profile'")
    known = [str(each) for each in data["clearance"].values]
    own = data.sel(clearance=_chosen(name, dict.fromkeys(known), "clearance"))
    return draw_profile(ax or panels(1, 1, SINGLE)[1][0], own)


@styled
def life(data: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Parts of copies that are worn out, of `linkages.wear_life`, over revolutions."""
    return draw_life(ax or panels(1, 1, SINGLE)[1][0], data)


@styled
def multipliers(data: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Multipliers of `linkages.orbit`, of one orbit, about the unit circle.

    Where one is far outside of it, magnitudes above 1 have a logarithmic scale.
    """
    return multiplier_figure(data).axes[0] if ax is None else draw_multipliers(ax, data)


@styled
def branches(data: xr.Dataset, name: str | None = None, ax: Axes | None = None) -> Axes:
    """Branches of `linkages.follow` over the first parameter: stable solid, unstable dashed.

    Parameters
    ----------
    data
        As `linkages.follow` returns it.
    name
        A coordinate or a rate, such as ``rod.angle``, or ``period``; the first coordinate if not
        given. It is drawn at the beginning of the first period of the drives.
    ax
        Where to draw. A new figure if not given, with the largest multipliers below.
    """
    return branch_figure(data, None, name).axes[1] if ax is None else draw_branches(ax, data, name)


@styled
def indicator_map(data: xr.Dataset, ax: Axes | None = None) -> Axes:
    """The indicator of `linkages.chaos_map`, with a colour bar."""
    if ax is None:
        return page(data).axes[0]
    draw_map(ax, data)
    figure = ax.get_figure(root=True)
    assert figure is not None
    figure.colorbar(ax.collections[0], ax=ax, label=indicator_label(data))
    return ax


@styled
def period_map(
    data: xr.Dataset,
    ax: Axes | None = None,
    *,
    curves: period_figures.Curves | Sequence[xr.Dataset] = (),
) -> Axes:
    """The isoperiodic plane of `linkages.chaos_map` with the indicator ``"period"``.

    Parameters
    ----------
    data
        As `linkages.chaos_map` returns it.
    ax
        Where to draw; axes of a new figure if not given.
    curves
        What is drawn on top: loci of `linkages.follow` over the same parameters, or label → x and y
        along a curve, shape (n,) each, in the units of the coordinates of `data`. Nan ends a part
        of a curve.
    """
    if ax is None:
        return period_figures.period_page(data, curves).axes[0]
    ax.legend(handles=period_figures.draw_periods(ax, data, curves))
    return ax


@styled
def rotation_map(data: xr.Dataset, name: str | None = None, ax: Axes | None = None) -> Axes:
    """What a free angle does at each point of `linkages.chaos_map`: the one named, or the first."""
    chosen = _chosen(name, {str(n): n for n in data["coordinate"].values})
    if ax is None:
        return class_page(data, chosen).axes[0]
    return draw_classes(ax, data, chosen)


@styled
def _over_time(source: Source, variable: str, ax: Axes | None) -> Axes:
    data = _at_joints(source, variable)
    heading = str(data.attrs.get("name", ""))
    if ax is None:
        return time_figures.draw_page(data, variable, heading)
    return time_figures.draw(ax, data, variable, heading)


def _at_joints(source: Source, variable: str) -> xr.Dataset:
    """Data of a variable; reactions of joints with those of several bodies there."""
    data = _resolved(source, AT_JOINTS if variable == REACTION else [variable])
    _require(data, variable)
    return time_figures.at_pins(data, variable=variable)


def _resolved(source: Source, variables: Sequence[str]) -> xr.Dataset:
    """Data of some variables; of a solution at samples that show every swing."""
    if not isinstance(source, Solution):
        return _data(source)
    has = {*map(str, source.data.data_vars)}
    has |= {name for name in available(source.system) if not VARIABLES[name].whole}
    return source.dense([name for name in variables if name in has])


def _called(
    sources: Source | Sequence[Source] | Mapping[str, Source],
) -> Mapping[str, Source]:
    """What tells sources apart → each of them."""
    given: Any = sources
    if isinstance(sources, Solution) or hasattr(sources, "data_vars"):
        return {str(_data(given).attrs.get("name", "")): given}
    if isinstance(sources, Mapping):
        return dict(given)
    several = list(given)
    mechanisms = [one.mechanism if isinstance(one, Solution) else None for one in several]
    return dict(zip(told_apart(mechanisms), several, strict=True))


def _listed(names: str | Sequence[str]) -> list[str]:
    return [names] if isinstance(names, str) else list(names)


def _data(source: Source) -> xr.Dataset:
    result: Any = source
    return result if hasattr(result, "data_vars") else result.data


def _require(data: xr.Dataset, variable: str) -> None:
    if variable not in data or not data[variable].size:
        raise ValueError(f"the data have no {variable}, or no samples of it")


def _free(data: xr.Dataset, name: str | None) -> Free:
    result = {coordinate.name: coordinate for coordinate in free_coordinates(data)}
    return result[_chosen(name, result)]


def _chosen(name: str | None, found: Mapping[str, object], what: str = "free coordinate") -> str:
    if not found:
        raise ValueError(f"the data have no {what}")
    if name is not None and name not in found:
        raise ValueError(f"unknown {what} {name!r}; expected one of: {', '.join(found)}")
    return next(iter(found)) if name is None else name
